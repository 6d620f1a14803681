//! The normalised trace of a run: inputs, choices and updates, one fact a line.
//!
//! ```text
//! # trace-format 1
//! D0 Robot = {rob1,rob2}        elements of the domains that may grow, before the first step;
//!                               each listed under the domain that declares or creates it
//! @step 1
//! T 40000000                    time of the step in nanoseconds, unless it is 0
//! M estop = false               value read from the environment, in order of reading
//! C 1 of 3                      chosen candidate, counted from 0
//! P self -> planner: plan(3)    message sent, in order of sending
//! U mode = MOVING               update set, sorted
//! UD Order = {order!1}          elements added to a domain
//! S mode = MOVING               every location that rules may update, after the step
//! D Order = {order!1}           elements of the domains that may grow, after the step
//! D Robot = {rob1,rob2}
//! @invariant post inv_safe      or `@error CLASH …`: the reason that there is no further step
//! @end INV                      `OK`, or the kind of the fault
//! I mode = IDLE                 initial values of the locations that rules may update
//! ```
//!
//! Values are written in the notation of the language, without blanks; the elements of sets, bags
//! and maps are sorted by their text. Any tool that runs the language can write such traces, so
//! that runs can be compared. A [`Recording`](crate::Recording) replays one.

mod text;

use asmotion_ir::{DomainId, FunctionKind, Program, Slot};
use asmotion_machine::{FaultKind, Machine, Naming, Step, StepFault};
use asmotion_value::{Atom, Value};
use std::collections::BTreeMap;
use std::fmt::Write;

/// A trace under construction.
#[derive(Debug, Default)]
pub struct Trace {
    text: String,
}

impl Trace {
    /// Starts a trace: format, comment lines, and the machine's domains.
    pub fn begin(machine: &Machine, comment: &str) -> Self {
        let mut trace = Self::default();
        trace.head(comment);
        trace.domains("D0", machine.naming());
        trace
    }

    /// Returns the trace of a run that failed in the initial state.
    pub fn failed_initial_state(program: &Program, fault: &StepFault, comment: &str) -> String {
        let mut trace = Self::default();
        trace.head(comment);
        let naming = Naming {
            program,
            reserve: &[],
        };
        trace.domains("D0", naming);
        trace.line(format_args!("@step 1"));
        if let FaultKind::Invariant { index, .. } = &fault.kind {
            trace.invariant(program, *index, "pre");
        } else {
            trace.line(format_args!("@error {}", kind(fault)));
        }
        trace.line(format_args!("@end {}", kind(fault)));
        trace.text
    }

    /// Adds the machine's last step.
    pub fn step(&mut self, machine: &Machine) {
        let step = machine.last_step();
        self.causes(machine, &step, step.number());
        self.effects(machine, &step);
    }

    /// Adds the machine's last step, which failed.
    pub fn fault(&mut self, machine: &Machine, fault: &StepFault) {
        let step = machine.last_step();
        // a fault of step 0 appears in the first step, which completes the initial state
        self.causes(machine, &step, fault.step.max(1));
        if let FaultKind::NoInputs { constraints, .. } = &fault.kind {
            for index in constraints {
                self.invariant(machine.program(), *index, "pre");
            }
        } else if let FaultKind::Invariant { index, .. } = &fault.kind {
            let is_before = fault.step == 0 || machine.program().invariants[*index].assumes;
            if !is_before {
                self.effects(machine, &step);
            }
            let when = if is_before { "pre" } else { "post" };
            self.invariant(machine.program(), *index, when);
        } else {
            self.line(format_args!("@error {}", kind(fault)));
        }
    }

    /// Returns the complete trace; `fault` is the fault that ended the run, if any.
    pub fn end(mut self, machine: &Machine, fault: Option<&StepFault>) -> String {
        self.line(format_args!("@end {}", fault.map_or("OK", kind)));
        let state = machine.state();
        let fixed = written(machine).filter(|&slot| slot < machine.program().slots);
        self.locations(
            "I",
            machine,
            fixed.map(|slot| (slot, state.get_initial(slot))),
        );
        self.text
    }

    fn head(&mut self, comment: &str) {
        self.line(format_args!("# trace-format 1"));
        for line in comment.lines() {
            self.line(format_args!("# {line}"));
        }
    }

    fn invariant(&mut self, program: &Program, index: usize, when: &str) {
        // an unnamed invariant is identified by its text, on one line
        let name: Vec<&str> = program.invariants[index].name.split_whitespace().collect();
        self.line(format_args!("@invariant {when} {}", name.join(" ")));
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        // writing to a string cannot fail
        let _ = self.text.write_fmt(line);
        self.text.push('\n');
    }

    fn causes(&mut self, machine: &Machine, step: &Step<'_>, number: u64) {
        self.line(format_args!("@step {number}"));
        if step.now_ns() != 0 {
            self.line(format_args!("T {}", step.now_ns()));
        }
        for input in step.inputs() {
            self.line(format_args!(
                "M {} = {}",
                location(machine, input.slot),
                text::text(machine.naming(), &input.value)
            ));
        }
        for choice in step.choices() {
            self.line(format_args!("C {} of {}", choice.index, choice.count));
        }
    }

    fn effects(&mut self, machine: &Machine, step: &Step<'_>) {
        for sent in step.sent() {
            let sent = crate::show::sent(machine, sent);
            self.line(format_args!("P {sent}"));
        }
        let updates = step
            .updates()
            .iter()
            .map(|update| (update.slot, &update.value));
        self.locations("U", machine, updates);
        let mut joined: BTreeMap<DomainId, Vec<Value>> = BTreeMap::new();
        for (domain, atom) in step.extended() {
            joined.entry(*domain).or_default().push(Value::Atom(*atom));
        }
        for (domain, atoms) in joined {
            self.domain("UD", machine.naming(), domain, &atoms);
        }
        let state = machine.state();
        let slots = written(machine).map(|slot| (slot, state.get(slot)));
        self.locations("S", machine, slots);
        self.domains("D", machine.naming());
    }

    fn locations<'a>(
        &mut self,
        word: &str,
        machine: &Machine,
        locations: impl Iterator<Item = (Slot, &'a Value)>,
    ) {
        let line = |(slot, value)| {
            let value = text::text(machine.naming(), value);
            format!("{} = {value}", location(machine, slot))
        };
        let lines = locations.map(line);
        let mut lines: Vec<String> = lines.collect();
        lines.sort();
        for line in lines {
            self.line(format_args!("{word} {line}"));
        }
    }

    /// Adds the domains that may grow, each with the elements that were declared in it or created
    /// for it.
    fn domains(&mut self, word: &str, naming: Naming<'_>) {
        let declared = naming.program.atom_domains.iter();
        let homes = declared.chain(naming.reserve.iter().map(|(domain, _)| domain));
        let mut domains: BTreeMap<DomainId, Vec<Value>> = BTreeMap::new();
        for (index, domain) in (0..).zip(homes) {
            if naming.program.domains[domain.0 as usize].grows {
                let atom = Value::Atom(Atom(index));
                domains.entry(*domain).or_default().push(atom);
            }
        }
        for (domain, atoms) in domains {
            self.domain(word, naming, domain, &atoms);
        }
    }

    fn domain(&mut self, word: &str, naming: Naming<'_>, domain: DomainId, elements: &[Value]) {
        let name = &naming.program.symbols.domains[domain.0 as usize];
        let set = text::set(naming, elements);
        self.line(format_args!("{word} {name} = {set}"));
    }
}

/// Iterates over the locations that rules may update.
fn written(machine: &Machine) -> impl Iterator<Item = Slot> {
    let (state, program) = (machine.state(), machine.program());
    state.slots().filter(move |&slot| {
        let function = state.function(program, slot);
        let kind = function.map(|id| program.functions[id.0 as usize].kind);
        matches!(kind, Some(FunctionKind::Controlled | FunctionKind::Out)) && slot != program.result
    })
}

fn kind(fault: &StepFault) -> &'static str {
    match &fault.kind {
        FaultKind::Clash { .. } => "CLASH",
        FaultKind::Outside { .. }
        | FaultKind::OutsideInput { .. }
        | FaultKind::OutsideArgument { .. } => "DOMAIN",
        FaultKind::Input { .. } => "MONREAD",
        FaultKind::Invariant { .. } | FaultKind::NoInputs { .. } => "INV",
        FaultKind::UndefinedGuard => "EXC:UndefinedGuard",
        FaultKind::Library(_) => "EXC:Library",
        FaultKind::Infinite => "EXC:Infinite",
        FaultKind::NotACollection(_) => "EXC:NotACollection",
        FaultKind::NotARule(_) => "EXC:NotARule",
        FaultKind::RuleArity { .. } => "EXC:RuleArity",
        FaultKind::NoProgram(_) => "EXC:NoProgram",
        FaultKind::TooDeep(_) => "EXC:TooDeep",
        FaultKind::ManyCalls(_) => "EXC:ManyCalls",
        FaultKind::Endless(_) => "EXC:Endless",
        FaultKind::TooLarge(_) => "EXC:TooLarge",
        FaultKind::Unbound => "EXC:Unbound",
        FaultKind::Unbounded => "EXC:Unbounded",
        FaultKind::NoCandidate(_) => "EXC:NoCandidate",
        FaultKind::NoMain => "EXC:NoMain",
    }
}

fn location(machine: &Machine, slot: Slot) -> String {
    match machine.state().location(machine.program(), slot) {
        Some((function, arguments)) => text::applied(machine.naming(), function, &arguments),
        None => format!("location {slot}"),
    }
}
