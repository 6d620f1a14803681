//! Explains run-time faults: both writers of a clash, the values involved, the step and the agent.

mod values;

use crate::codes::r001::Clash;
use crate::codes::r002::WritesForeignValue;
use crate::codes::r003::UndefinedGuard;
use crate::codes::r004::LibraryFault;
use crate::codes::r005::InfiniteRange;
use crate::codes::r006::RangeIsNoCollection;
use crate::codes::r007::RunsNoRule;
use crate::codes::r008::WrongRuleArity;
use crate::codes::r009::AgentWithoutProgram;
use crate::codes::r010::CallsTooDeep;
use crate::codes::r011::EndlessLoop;
use crate::codes::r012::CollectionTooLarge;
use crate::codes::r013::NoInputValue;
use crate::codes::r014::InvariantViolated;
use crate::codes::r015::NoMainToRun;
use crate::codes::r016::UnboundedValue;
use crate::codes::r017::UnboundVariable;
use crate::codes::r020::PickedNoCandidate;
use crate::codes::r021::TooManyCalls;
use crate::codes::r022::ReadsForeignValue;
use crate::codes::r023::WritesNowhere;
use crate::codes::r024::NoConstrainedInputs;
use crate::codes::w030::BeginsOutside;
use crate::specification::Specification;
use asmotion_diagnostics::{Diagnostic, Finding, Report};
use asmotion_machine::{FaultKind, InitialMisfit, Machine, StepFault, Witness};
use asmotion_value::Value;

impl Specification {
    /// Returns `true` if a rule at this place repeats its body.
    fn repeats(&self, origin: asmotion_ir::Origin) -> bool {
        self.program.routines.iter().any(|routine| {
            routine.code.any(&mut |rule| {
                matches!(&*rule.node, asmotion_ir::RuleNode::While { .. }) && rule.origin == origin
            })
        })
    }

    /// Explains a fault in the initial state, before there is a machine. Names of elements created
    /// at run time are not available.
    pub fn explain(&self, fault: &StepFault) -> Diagnostic {
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

    /// Explains the fault of the machine's last step, which has just failed.
    pub fn explain_in(&self, fault: &StepFault, machine: &Machine) -> Diagnostic {
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
        finding = if let FaultKind::NoInputs { is_exhaustive, .. } = fault.kind {
            values::add_drawn_inputs(finding, machine, is_exhaustive)
        } else {
            values::add_inputs(finding, machine)
        };
        if fault.step > 0 && fault.step == machine.steps() {
            finding = values::add_updates(finding, machine);
        }
        finding
    }

    /// Warns about initial values outside the codomains of their functions, which do not prevent a
    /// run.
    pub fn doubts(&self, machine: &Machine) -> Report {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let warn = |found: InitialMisfit| {
            let location =
                asmotion_simulate::applied(machine, found.misfit.function, &found.arguments);
            BeginsOutside {
                location,
                foreign: self.foreign(&found.misfit, &show),
                at: self.place_of(self.span(found.origin), &found.misfit),
            }
            .diagnostic()
        };
        machine.initial_misfits().into_iter().map(warn).collect()
    }

    fn diagnose(
        &self,
        fault: &StepFault,
        location: &dyn Fn(asmotion_ir::Slot) -> String,
        show: &dyn Fn(&Value) -> String,
    ) -> Diagnostic {
        let at = self.span(fault.origin);
        let when = match fault.step {
            0 => "in the initial state".to_owned(),
            step => format!("in step {step}"),
        };
        let mut finding = match &fault.kind {
            FaultKind::Clash {
                slot,
                first,
                first_origin,
                second,
            } => Clash {
                location: location(*slot),
                when,
                at,
                value: show(second),
                first_at: self.span(*first_origin),
                first: show(first),
            }
            .diagnostic(),
            FaultKind::Outside { slot, misfit } => WritesForeignValue {
                location: location(*slot),
                codomain: self.codomain(misfit),
                foreign: self.foreign(misfit, show),
                when,
                at: self.place_of(at, misfit),
            }
            .diagnostic(),
            FaultKind::OutsideInput {
                slot,
                misfit,
                source,
            } => ReadsForeignValue {
                location: location(*slot),
                codomain: self.codomain(misfit),
                foreign: self.foreign(misfit, show),
                given_by: source.to_string(),
                when,
                at: self.place_of(at, misfit),
            }
            .diagnostic(),
            FaultKind::OutsideArgument { slot, misfit } => WritesNowhere {
                location: location(*slot),
                foreign: self.foreign(misfit, show),
                when,
                at: self.place_of(at, misfit),
            }
            .diagnostic(),
            FaultKind::UndefinedGuard => UndefinedGuard { when, at }.diagnostic(),
            FaultKind::Library(reason) => LibraryFault {
                reason: reason.to_string(),
                help: reason.help(),
                when,
                at,
            }
            .diagnostic(),
            FaultKind::Infinite => InfiniteRange { when, at }.diagnostic(),
            FaultKind::NotACollection(value) => {
                let value = show(value);
                RangeIsNoCollection { value, when, at }.diagnostic()
            }
            FaultKind::NotARule(value) => {
                let value = show(value);
                RunsNoRule { value, when, at }.diagnostic()
            }
            &FaultKind::RuleArity {
                expected: wanted,
                actual,
            } => WrongRuleArity {
                expected: wanted,
                actual,
                when,
                at,
            }
            .diagnostic(),
            FaultKind::NoProgram(agent) => {
                let agent = show(agent);
                AgentWithoutProgram { agent, when, at }.diagnostic()
            }
            &FaultKind::TooDeep(limit) => CallsTooDeep { limit, when, at }.diagnostic(),
            &FaultKind::ManyCalls(limit) => TooManyCalls { limit, when, at }.diagnostic(),
            &FaultKind::Endless(limit) => EndlessLoop {
                limit,
                when,
                is_range: !self.repeats(fault.origin),
                at,
            }
            .diagnostic(),
            &FaultKind::TooLarge(count) => CollectionTooLarge { count, when, at }.diagnostic(),
            FaultKind::Unbound => UnboundVariable { when, at }.diagnostic(),
            FaultKind::Unbounded => UnboundedValue { when, at }.diagnostic(),
            FaultKind::Input { slot, reason } => NoInputValue {
                location: location(*slot),
                reason: reason.to_string(),
                when,
                at,
            }
            .diagnostic(),
            FaultKind::Invariant { index, value } => {
                let invariant = &self.program.invariants[*index];
                InvariantViolated {
                    name: invariant.name.to_string(),
                    is_undef: value.is_undef(),
                    assumes: invariant.assumes,
                    is_constraint: invariant.is_constraint,
                    step: fault.step,
                    when,
                    at,
                }
                .diagnostic()
            }
            FaultKind::NoInputs {
                constraints,
                is_exhaustive,
            } => {
                let name = |index: &usize| format!("`{}`", self.program.invariants[*index].name);
                let names: Vec<String> = constraints.iter().map(name).collect();
                NoConstrainedInputs {
                    are_several: names.len() > 1,
                    names: names.join(", "),
                    is_exhaustive: *is_exhaustive,
                    when,
                    at,
                }
                .diagnostic()
            }
            FaultKind::NoCandidate(picked) => {
                let values: Vec<String> = picked.iter().map(show).collect();
                let values = values.join(", ");
                PickedNoCandidate { values, when, at }.diagnostic()
            }
            FaultKind::NoMain => NoMainToRun.diagnostic(),
        };
        if !fault.agent.is_undef() {
            finding = finding.note(format!("running agent: {}", show(&fault.agent)));
        }
        finding
    }
}
