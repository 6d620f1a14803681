//! End conditions of a mission.

use super::{MissionError, MissionOutcome};
use crate::files::DiskLoader;
use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_lang::machine::Machine;
use asmotion_lang::simulate::AwaitedUpdate;
use asmotion_plan::{Implementation, Plan};
use asmotion_runtime::{Event, Observer};

/// Returns the end conditions; by default `mode` with its usual value.
pub(super) fn awaited_updates(
    plan: &Plan,
    requested: Option<&[(String, String)]>,
    default: &str,
) -> Result<Vec<AwaitedUpdate>, MissionError> {
    let Some(requested) = requested else {
        let (location, value) = ("mode".to_owned(), default.to_owned());
        return Ok(vec![AwaitedUpdate { location, value }]);
    };
    let machines = machines(plan);
    let mut all = Vec::new();
    for (location, value) in requested {
        let mut reasons = Vec::new();
        for (path, machine) in &machines {
            match AwaitedUpdate::of(machine, location, value) {
                Ok(awaited) => all.push(awaited),
                Err(reason) => reasons.push((path.clone(), reason)),
            }
        }
        // it suffices if one specification can establish the condition
        if reasons.len() == machines.len() {
            let requested = format!("{location}={value}");
            return Err(MissionError::NeverEnds { requested, reasons });
        }
    }
    Ok(all)
}

/// Machines of the plan's specifications; errors of their initial states are reported at the start.
fn machines(plan: &Plan) -> Vec<(String, Machine)> {
    let of = |component: &asmotion_plan::Component| match &component.implementation {
        Implementation::Asm { file, .. } => {
            let specification = asmotion_lang::open(file, &DiskLoader).ok()?;
            Some((file.clone(), specification.machine().ok()?))
        }
        Implementation::Rust(_)
        | Implementation::Builtin { .. }
        | Implementation::Process { .. }
        | Implementation::Ros { .. }
        | Implementation::Orocos { .. } => None,
    };
    plan.components.iter().filter_map(of).collect()
}

/// Watches for the end conditions.
pub(super) struct EndCondition {
    pub until: Vec<AwaitedUpdate>,
    pub unless: Vec<AwaitedUpdate>,
    /// Outcome of the run, once it is known.
    pub outcome: Option<MissionOutcome>,
}

impl Observer for EndCondition {
    fn observe(&mut self, _at: Time, event: &Event<'_>) {
        if self.outcome.is_some() {
            return;
        }
        match event {
            Event::Fault { .. } => self.outcome = Some(MissionOutcome::Fault),
            Event::Report {
                kind, data: what, ..
            } if *kind == STEP_REPORT => {
                let Ok(step) = what.to::<StepRecord>() else {
                    return;
                };
                let has = |ends: &[AwaitedUpdate]| {
                    step.updates.iter().any(|update| {
                        ends.iter()
                            .any(|end| end.location == update.location && end.value == update.after)
                    })
                };
                if has(&self.until) {
                    self.outcome = Some(MissionOutcome::Reached);
                } else if has(&self.unless) {
                    self.outcome = Some(MissionOutcome::Failed);
                }
            }
            Event::Cycle { .. }
            | Event::Published { .. }
            | Event::Injected { .. }
            | Event::Called { .. }
            | Event::Answered { .. }
            | Event::Replied { .. }
            | Event::LifeCycle { .. }
            | Event::Overrun { .. }
            | Event::Late { .. }
            | Event::Denied { .. }
            | Event::Dropped { .. }
            | Event::Property { .. }
            | Event::Report { .. }
            | Event::Lost { .. } => {}
        }
    }
}
