//! Run-time faults as diagnostics: both writers, the values at hand, the step and the agent.

mod outside;
mod values;

use crate::Specification;
use asmotion_diagnostics::{Diagnostic, Report};
use asmotion_machine::{Fault, FaultKind, InitialMisfit, Machine, Witness};
use asmotion_value::Value;

impl Specification {
    /// What a fault says of a machine that could not be built: values are shown as far as they can be.
    pub fn explain(&self, fault: &Fault) -> Diagnostic {
        let naming = asmotion_machine::Naming {
            program: &self.program,
            reserve: &[],
        };
        let show = |value: &Value| value.show(&naming).to_string();
        let finding = self.diagnose(fault, &|slot| format!("location {slot}"), &show);
        match Witness::initially(&self.program, fault) {
            Some(witness) => values::add(finding, fault, &witness, self, &show),
            None => finding,
        }
    }

    /// What the fault says that this machine has just returned.
    pub fn explain_in(&self, fault: &Fault, machine: &Machine) -> Diagnostic {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let mut finding = self.diagnose(
            fault,
            &|slot| asmotion_simulate::location(machine, slot),
            &show,
        );
        if let Some(witness) = machine.witness(fault) {
            finding = values::add(finding, fault, &witness, self, &show);
        }
        finding = values::add_inputs(finding, machine);
        if fault.step > 0 && fault.step == machine.steps() {
            finding = values::add_updates(finding, machine);
        }
        finding
    }

    /// What is odd about the state a machine begins in, and no reason to stop: initial values that are
    /// no elements of their domains.
    pub fn doubts(&self, machine: &Machine) -> Report {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let warn = |found: InitialMisfit| {
            let location =
                asmotion_simulate::applied(machine, found.misfit.function, &found.arguments);
            let fact = self.no_element(&found.misfit, "in the initial state", &show);
            let finding = Diagnostic::warning("W030", fact).label(
                self.span(found.origin),
                format!("the initial value of `{location}`"),
            );
            self.outside(
                finding,
                &found.misfit,
                &show,
                "let it begin with an element",
            )
        };
        machine.initial_misfits().into_iter().map(warn).collect()
    }

    fn diagnose(
        &self,
        fault: &Fault,
        location: &dyn Fn(asmotion_ir::Slot) -> String,
        show: &dyn Fn(&Value) -> String,
    ) -> Diagnostic {
        let at = self.span(fault.origin);
        let when = match fault.step {
            0 => "in the initial state".to_owned(),
            step => format!("in step {step}"),
        };
        let mut finding = match &fault.kind {
            FaultKind::Clash { slot, first, first_origin, second } => {
                let location = location(*slot);
                Diagnostic::error("R001", format!("inconsistent update of `{location}` {when}"))
                    .label(at, format!("this writes {}", show(second)))
                    .label(self.span(*first_origin), format!("and in the same step this writes {}", show(first)))
                    .note("a step applies all updates at once, so a location gets one value; the state is kept")
                    .help("put one of them in the `else` of the other, or both in `seq … endseq` if the later one wins")
            }
            FaultKind::Outside { slot, misfit } => {
                let place = format!("`{}` takes values of `{}`", location(*slot), self.codomain(misfit));
                let finding = Diagnostic::error("R002", self.no_element(misfit, &when, show)).label(at, place);
                self.outside(finding, misfit, show, "guard the update")
            }
            FaultKind::OutsideInput { slot, misfit, source } => {
                let place = format!("`{}` takes values of `{}`", location(*slot), self.codomain(misfit));
                let finding = Diagnostic::error("R022", self.no_element(misfit, &when, show)).label(at, place);
                self.outside(finding, misfit, show, "let the environment give an element")
                    .note(format!("the value came from {source}"))
            }
            FaultKind::OutsideArgument { slot, misfit } => {
                let place = format!("there is no location `{}` to write", location(*slot));
                let finding = Diagnostic::error("R023", self.no_element(misfit, &when, show)).label(at, place);
                self.outside(finding, misfit, show, "guard the update")
            }
            FaultKind::UndefinedGuard => Diagnostic::error("R003", format!("a guard is undef {when}"))
                .label(at, "neither true nor false")
                .note("`undef` spreads: a comparison with an undef side is undef, `=` and `!=` are not")
                .help("initialise the locations it reads, or test them with `isDef(…)` first"),
            FaultKind::Library(reason) => {
                Diagnostic::error("R004", format!("{reason}, {when}")).label(at, "evaluated here").help(reason.help())
            }
            FaultKind::Infinite => Diagnostic::error("R005", format!("a variable ranges over a domain without end, {when}"))
                .label(at, "its elements cannot be listed")
                .help("range over a subset, as in `domain Small subsetof Integer` with `domain Small = {0 : 9}`"),
            FaultKind::NotACollection(value) => {
                Diagnostic::error("R006", format!("a variable ranges over {}, {when}", show(value)))
                    .label(at, "a set, sequence or bag is wanted")
                    .help("initialise the location it reads")
            }
            FaultKind::NotARule(value) => Diagnostic::error("R007", format!("{} is run as a rule, {when}", show(value)))
                .label(at, "a rule is wanted")
                .help("give the location a rule, as in `<<r_x>>`"),
            FaultKind::RuleArity { wanted, actual } => {
                let plural = if *wanted == 1 { "" } else { "s" };
                Diagnostic::error("R008", format!("the rule takes {wanted} argument{plural}, not {actual}, {when}"))
                    .label(at, "run here")
                    .help("give one argument for each parameter")
            }
            FaultKind::NoProgram(agent) => Diagnostic::error("R009", format!("the agent {} has no program, {when}", show(agent)))
                .label(at, "run here")
                .help("add `agent Domain: r_rule[]` for its domain to the default init"),
            FaultKind::TooDeep(limit) => Diagnostic::error("R010", format!("calls nest deeper than {limit}, {when}"))
                .label(at, "called once more")
                .help("check that the recursion ends for every argument"),
            FaultKind::ManyCalls(limit) => Diagnostic::error("R021", format!("functions and rules were called {limit} times {when}"))
                .label(at, "called once more")
                .help("a recursion that calls itself twice doubles with every level: keep what it computes in a location"),
            FaultKind::Endless(limit) => Diagnostic::error("R011", format!("the loops ran {limit} times {when}"))
                .label(at, "this loop did not end")
                .help("check that its body makes the guard false"),
            FaultKind::TooLarge(count) => Diagnostic::error("R012", format!("a collection of {count} elements would be built, {when}"))
                .label(at, "built here")
                .help("range over a smaller domain"),
            FaultKind::Unbound => Diagnostic::error("R017", format!("a variable is not bound, {when}"))
                .label(at, "read here, outside the rule or term that binds it")
                .help("bind it here with `let`, `forall` or `choose`"),
            FaultKind::Unbounded => Diagnostic::error("R016", format!("a value grows without end, {when}"))
                .label(at, "it nests too deeply, or holds too much")
                .note("values of `Any` nest 500 deep at most, and hold 1,048,576 elements")
                .help("keep the parts in locations of their own, or give the location a narrower domain"),
            FaultKind::Input { slot, reason } => {
                Diagnostic::error("R013", format!("no value for `{}` {when}: {reason}", location(*slot)))
                    .label(at, "read here")
                    .help("let the environment answer it, or give it a default")
            }
            FaultKind::Invariant { index, value } => {
                let invariant = &self.program.invariants[*index];
                let what = if value.is_undef() { "is undef" } else { "does not hold" };
                let help = match (value.is_undef(), invariant.assumes, fault.step) {
                    (true, ..) => "initialise the locations it reads, or test them with `isDef(…)` first",
                    (false, true, _) => "it is an assumption on the inputs of the step, and these break it",
                    (false, false, 0) => "let the initial values satisfy it",
                    (false, false, _) => "find the rule that broke it among the updates of the step",
                };
                Diagnostic::error("R014", format!("the invariant `{}` {what} {when}", invariant.name))
                    .label(at, "this condition")
                    .help(help)
            }
            FaultKind::NoCandidate(picked) => {
                let values: Vec<String> = picked.iter().map(show).collect();
                Diagnostic::error("R020", format!("{} was picked, and is no candidate, {when}", values.join(", ")))
                    .label(at, "chosen here")
                    .help("pick a value in the range for which the guard holds")
            }
            FaultKind::NoMain => Diagnostic::error("R015", "there is no main rule to run")
                .help("add `main rule r_Main = …`"),
        };
        if !fault.agent.is_undef() {
            finding = finding.note(format!("the agent {} was running", show(&fault.agent)));
        }
        finding
    }
}
