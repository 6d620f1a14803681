//! The machines of a replay, from their recorded beginnings.

use std::rc::Rc;

use asmotion_coordinator::{MachineBegin, MachineOrigin};
use asmotion_lang::guards::PassedGuard;
use asmotion_lang::ir::AddedRule;
use asmotion_lang::machine::{Machine, TransferError};
use asmotion_lang::{Specification, StepFault, simulate};

use super::difference::DifferenceKind;
use super::failure::ReplayFailure;
use super::inputs::inputs_at;

/// A machine and its specification.
#[derive(Clone)]
pub(super) struct ReplayMachine {
    pub specification: Rc<Specification>,
    pub machine: Machine,
    /// The rule that makes a step in place of the main rule.
    pub safe_rule: Option<AddedRule>,
}

impl ReplayMachine {
    /// Creates the machine that began in a coordinator. `before` is the machine before it; `is_edited` if the specification is not
    /// the recorded one.
    ///
    /// # Errors
    /// The beginning cannot be repeated.
    pub fn begin(
        specification: Rc<Specification>,
        begin: &MachineBegin,
        before: Option<&Self>,
        is_edited: bool,
    ) -> Result<Self, ReplayFailure> {
        let machine = specification.machine();
        let machine = machine.map_err(|fault| ReplayFailure::Initial {
            reason: specification.explain(&fault).message,
        })?;
        let mut new = Self {
            specification,
            machine,
            safe_rule: None,
        };
        new.set_agents(begin, is_edited)?;
        match (&begin.from, before) {
            (MachineOrigin::Initial, _) => {}
            (MachineOrigin::Predecessor { time_ns, frame }, Some(before)) => {
                let elements = new.machine.adopt_elements(&before.machine);
                let mut inputs = inputs_at(*time_ns, frame, &new.machine);
                let continued =
                    new.machine
                        .continue_from(&before.machine, &elements, &mut inputs, *time_ns);
                let refused = |reason| ReplayFailure::Transfer {
                    time_ns: *time_ns,
                    reason,
                };
                continued.map_err(|error| refused(new.unfit(before, &error)))?;
                // as the coordinator does, because it reads inputs
                let checked = new.machine.check_invariants(&mut inputs, *time_ns);
                checked.map_err(|fault| refused(new.explained(&fault)))?;
            }
            (MachineOrigin::Predecessor { .. }, None) | (MachineOrigin::Frozen, _) => {
                return Err(ReplayFailure::Frozen);
            }
        }
        Ok(new)
    }

    fn set_agents(&mut self, begin: &MachineBegin, is_edited: bool) -> Result<(), ReplayFailure> {
        let mut agents = Vec::new();
        for text in &begin.agents {
            match simulate::agent(text, &self.machine) {
                Ok(agent) => agents.push(agent),
                // an edited specification may not know the service any more
                Err(_) if is_edited => {}
                Err(_) => {
                    return Err(ReplayFailure::Agent {
                        agent: text.clone(),
                    });
                }
            }
        }
        self.machine.set_partners(agents);
        Ok(())
    }

    /// Returns the first location whose value is not the recorded one. Locations that only one of both knows are those that
    /// have been read so far, with their initial values.
    pub fn differs_from(&self, begin: &MachineBegin) -> Option<DifferenceKind> {
        let state = simulate::state(&self.machine).into_iter();
        let mut common = state.filter_map(|(location, replayed)| {
            let recorded = begin.state.get(&location)?.clone();
            Some((location, recorded, replayed))
        });
        let (location, recorded, replayed) =
            common.find(|(_, recorded, replayed)| recorded != replayed)?;
        Some(DifferenceKind::Begin {
            location,
            recorded,
            replayed,
        })
    }

    fn unfit(&self, before: &Self, error: &TransferError) -> String {
        match error {
            TransferError::Value {
                function,
                arguments,
                value,
            } => {
                let location = simulate::applied(&before.machine, *function, arguments);
                let naming = before.machine.naming();
                format!("`{location}` is {}", value.show(&naming))
            }
            TransferError::Message => "a message names an unknown element".to_owned(),
            TransferError::Fault(fault) => self.explained(fault),
        }
    }

    /// Returns the guards on the way to an update of the last step that is different. `before` is the machine before that step.
    pub fn guards(&self, before: &Machine, kind: &DifferenceKind) -> Vec<PassedGuard> {
        let DifferenceKind::Update {
            location,
            replayed: Some(_),
            ..
        } = kind
        else {
            return Vec::new();
        };
        let machine = &self.machine;
        let mut updates = machine.last_step().updates().iter();
        let update = updates.find(|it| simulate::location(machine, it.slot) == *location);
        let at = update.and_then(|it| machine.state().location(machine.program(), it.slot));
        at.map_or_else(Vec::new, |(function, arguments)| {
            let specification = &self.specification;
            specification.guards_of_update(machine, before, function, &arguments)
        })
    }

    /// Message of a fault of the machine.
    pub fn explained(&self, fault: &StepFault) -> String {
        self.specification.explain_in(fault, &self.machine).message
    }
}
