//! What a mission ends with.

use super::{MissionError, Outcome};
use crate::files::Disk;
use asmotion_assembly::Plan;
use asmotion_assembly::plan::Implementation;
use asmotion_component::{Event, Observer, Time};
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::Awaited;

/// What a run waits for; without wishes, `mode` with the usual value.
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
        // one specification that can bring it is enough
        if reasons.len() == machines.len() {
            let wanted = format!("{location}={value}");
            return Err(MissionError::NeverEnds { wanted, reasons });
        }
    }
    Ok(all)
}

/// The specifications of a plan; one that cannot begin is found out when it is started.
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

/// Looks out for the end.
pub(super) struct Watch {
    pub until: Vec<Awaited>,
    pub unless: Vec<Awaited>,
    /// How the run ends, once that is known.
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
