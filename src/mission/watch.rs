//! End conditions of a mission.

use super::{MissionError, Outcome};
use crate::files::Disk;
use asmotion_assembly::Plan;
use asmotion_assembly::plan::Implementation;
use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::Awaited;
use asmotion_runtime::{Event, Observer};

/// Returns the end conditions; by default `mode` with its usual value.
pub(super) fn awaited(
    plan: &Plan,
    wished: Option<&[(String, String)]>,
    usual: &str,
) -> Result<Vec<Awaited>, MissionError> {
    let Some(wished) = wished else {
        let (location, value) = ("mode".to_owned(), usual.to_owned());
        return Ok(vec![Awaited { location, value }]);
    };
    let machines = machines(plan);
    let mut all = Vec::new();
    for (location, value) in wished {
        let mut reasons = Vec::new();
        for (path, machine) in &machines {
            match Awaited::of(machine, location, value) {
                Ok(awaited) => all.push(awaited),
                Err(reason) => reasons.push((path.clone(), reason)),
            }
        }
        // it suffices if one specification can establish the condition
        if reasons.len() == machines.len() {
            let wanted = format!("{location}={value}");
            return Err(MissionError::NeverEnds { wanted, reasons });
        }
    }
    Ok(all)
}

/// Machines of the plan's specifications; errors of their initial states are reported at the start.
fn machines(plan: &Plan) -> Vec<(String, Machine)> {
    let of = |component: &asmotion_assembly::plan::Component| match &component.implementation {
        Implementation::Asm(asm) => {
            let specification = asmotion_lang::open(&asm.path, &Disk).ok()?;
            Some((asm.path.clone(), specification.machine().ok()?))
        }
        Implementation::Rust(_)
        | Implementation::Builtin(_)
        | Implementation::Process(_)
        | Implementation::Ros(_)
        | Implementation::Orocos(_) => None,
    };
    plan.components.iter().filter_map(of).collect()
}

/// Watches for the end conditions.
pub(super) struct Watch {
    pub until: Vec<Awaited>,
    pub unless: Vec<Awaited>,
    /// Outcome of the run, once it is known.
    pub outcome: Option<Outcome>,
}

impl Observer for Watch {
    fn observe(&mut self, _at: Time, event: &Event<'_>) {
        if self.outcome.is_some() {
            return;
        }
        match event {
            Event::Fault { .. } => self.outcome = Some(Outcome::Fault),
            Event::Report { kind, what, .. } if *kind == STEP_REPORT => {
                let Ok(step) = what.to::<StepRecord>() else {
                    return;
                };
                let has = |ends: &[Awaited]| {
                    step.updates.iter().any(|update| {
                        ends.iter()
                            .any(|end| end.location == update.location && end.value == update.after)
                    })
                };
                if has(&self.until) {
                    self.outcome = Some(Outcome::Reached);
                } else if has(&self.unless) {
                    self.outcome = Some(Outcome::Failed);
                }
            }
            _ => {}
        }
    }
}
