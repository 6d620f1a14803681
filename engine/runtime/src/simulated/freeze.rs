//! Freezing and thawing of simulations between two steps.

use std::collections::BTreeSet;

use asmotion_datum::DatumError;
use asmotion_port::{ConnectionId, SampleSnapshot, Time};
use serde::{Deserialize, Serialize};

use super::Simulation;
use super::queue::{DueQueue, DueWork};
use super::timeline::UnitSchedule;
use crate::component_unit::FrozenUnit;
use crate::frozen::{
    FrozenSample, FrozenSystem, SampleNames, SystemFreezeError, SystemThawError, no_data,
    system_mismatch,
};
use crate::injection::InjectionTarget;
use crate::service::ThawContext;

/// Complete state of a simulation except observers and pace.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FrozenSimulation {
    now: Time,
    /// Position of the last sample among all samples.
    order: u64,
    /// Number of queue entries planned so far.
    planned: u64,
    /// Queue entries in order: time, serial number and work.
    due: Vec<(Time, u64, FrozenWork)>,
    schedules: Vec<UnitSchedule>,
    /// Number of samples dropped by each injection port.
    dropped: Vec<u64>,
    units: Vec<FrozenUnit>,
}

/// Work of a queue entry.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum FrozenWork {
    Sample {
        target: InjectionTarget,
        sample: FrozenSample,
    },
    Deadline {
        component: usize,
    },
    Trigger {
        component: usize,
        generation: u64,
    },
    Period {
        component: usize,
        generation: u64,
    },
}

impl Simulation {
    /// Returns the complete state of the simulation, which itself continues unchanged.
    ///
    /// The state does not include observers and the pace. A system connected to the outside cannot be frozen, whether
    /// by an adapter (a bus, HTTP), by a reader, writer or caller on another thread, or by a message queue.
    ///
    /// # Errors
    /// An error if a component cannot be frozen or the system is connected to the outside.
    pub fn freeze(&mut self) -> Result<FrozenSystem, SystemFreezeError> {
        if !self.adapters.is_empty() {
            let what = "an adapter joins the system to a bus".to_owned();
            return Err(SystemFreezeError::External(what));
        }
        // includes the triggers requested by other threads so far, which the next step would process first
        self.timeline.effects(None).take_external_triggers();
        let units = self.units.iter_mut().map(|unit| unit.snapshot());
        let units: Vec<_> = units.collect::<Result<_, _>>()?;
        self.refuse_external_writers(&units)?;
        let timeline = &self.timeline;
        let due = timeline.queue.entries().into_iter();
        let due = due.map(|(at, serial, work)| Ok((at, serial, FrozenWork::of(work)?)));
        FrozenSystem::of(FrozenSimulation {
            now: timeline.now,
            order: timeline.handle.order(),
            planned: timeline.queue.planned(),
            due: due.collect::<Result<_, SystemFreezeError>>()?,
            schedules: timeline.schedules.clone(),
            dropped: self.injections.all().map(|port| port.dropped()).collect(),
            units: Self::without_repetition(units, &self.shared_queues()),
        })
    }

    /// Restores a frozen state. The simulation must have been started from the same composite; it continues as the
    /// frozen one would have, with the same clock. Observers are not notified.
    ///
    /// The state of a system to which components or connections were added while it ran can be restored in that system, but not in one
    /// started from the changed composite: there the connections have other numbers.
    ///
    /// # Errors
    /// An error if the bytes are malformed or belong to another composite or another version. The simulation is then
    /// unchanged.
    pub fn thaw(&mut self, frozen: &FrozenSystem) -> Result<(), SystemThawError> {
        let state: FrozenSimulation = frozen.read()?;
        self.compare(&state)?;
        let before = self.freeze().map_err(SystemThawError::CannotFreeze)?;
        let thawed = self.restore(&state);
        if thawed.is_err() {
            // a state frozen by this system itself can always be restored, for the rollback
            let before: FrozenSimulation = before.read()?;
            self.restore(&before)?;
        }
        thawed
    }

    /// Reports the state of a system with other components.
    fn compare(&self, state: &FrozenSimulation) -> Result<(), SystemThawError> {
        let count = self.units.len();
        if state.units.len() != count || state.schedules.len() != count {
            let theirs = state.units.len();
            return Err(system_mismatch(format!(
                "it has {theirs} components, this system has {count}"
            )));
        }
        for (unit, frozen) in self.units.iter().zip(&state.units) {
            unit.compare(frozen)?;
        }
        if state.dropped.len() != self.injections.all().count() {
            return Err(system_mismatch("its topics differ"));
        }
        let fits = state.due.iter().all(|(at, _, work)| {
            *at >= state.now
                && match work {
                    FrozenWork::Sample { target, .. } => self.injections.contains(*target),
                    FrozenWork::Deadline { component }
                    | FrozenWork::Trigger { component, .. }
                    | FrozenWork::Period { component, .. } => *component < count,
                }
        });
        if fits {
            Ok(())
        } else {
            Err(system_mismatch(
                "it contains scheduled work that this system cannot have",
            ))
        }
    }

    fn restore(&mut self, state: &FrozenSimulation) -> Result<(), SystemThawError> {
        let declarations = self.units.iter().map(|unit| &*unit.body.declaration);
        let context = ThawContext {
            names: SampleNames::of(declarations),
            reply_queues: self
                .units
                .iter()
                .map(|unit| unit.body.caller.reply_queue())
                .collect(),
        };
        for (unit, frozen) in self.units.iter_mut().zip(&state.units) {
            unit.restore(frozen, &context)?;
        }
        for (connection, waiting) in state.units.iter().flat_map(|unit| unit.waiting()) {
            self.refill(connection, waiting)
                .map_err(SystemThawError::Malformed)?;
        }
        for (port, dropped) in self.injections.all_mut().zip(&state.dropped) {
            port.set_dropped(*dropped);
        }
        let due = state.due.iter();
        let due = due.map(|(at, serial, work)| Ok((*at, *serial, work.thaw(&context.names)?)));
        let due = due.collect::<Result<_, SystemThawError>>()?;
        let timeline = &mut self.timeline;
        timeline.queue = DueQueue::of(state.planned, due);
        timeline.escalated = false;
        // before the schedules, whose counts of cycles belong to this instant
        timeline.set_now(state.now);
        timeline.resume(&state.schedules);
        timeline.handle.set_order(state.order);
        if let Some(pacer) = &mut self.pacer {
            pacer.restart(state.now);
        }
        Ok(())
    }

    /// Sends the unread samples of a connection again.
    fn refill(
        &mut self,
        connection: ConnectionId,
        waiting: &[SampleSnapshot],
    ) -> Result<(), DatumError> {
        let mut injections = self.injections.all_mut();
        if let Some(port) = injections.find(|port| port.connection() == connection) {
            return port.refill(waiting);
        }
        for unit in &mut self.units {
            for output in &mut unit.body.outputs {
                if output.refill(connection, waiting)? {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Returns the connections written by outputs and injection ports of the system.
    fn senders(&self) -> BTreeSet<u64> {
        let outputs = self.units.iter().flat_map(|unit| &unit.body.outputs);
        let links = outputs.flat_map(|output| output.links());
        let readers = links.flat_map(|link| &link.readers);
        let injections = self.injections.all().map(|port| port.connection().number());
        readers
            .map(|reader| reader.connection.number())
            .chain(injections)
            .collect()
    }

    /// Reports connections with a writer outside the system.
    fn refuse_external_writers(&self, units: &[FrozenUnit]) -> Result<(), SystemFreezeError> {
        let senders = self.senders();
        for unit in units {
            let mut channels = unit.inputs.iter().flat_map(|input| &input.channels);
            if let Some((number, _)) = channels.find(|it| !senders.contains(&it.0)) {
                let what = format!(
                    "connection {number} into an input of `{}` has a writer on another thread, or had one",
                    unit.name()
                );
                return Err(SystemFreezeError::External(what));
            }
        }
        Ok(())
    }

    /// Returns, for each connection that shares its queue, the position of that queue.
    fn shared_queues(&self) -> Vec<(u64, usize)> {
        let outputs = self.units.iter().flat_map(|unit| &unit.body.outputs);
        let links = outputs.flat_map(|output| output.links());
        let shared = links.filter_map(|link| Some((&link.readers, link.queue?)));
        shared
            .flat_map(|(readers, queue)| {
                let readers = readers.iter();
                readers.map(move |reader| (reader.connection.number(), queue))
            })
            .collect()
    }

    /// Keeps the unread samples of a shared queue only with its first connection.
    fn without_repetition(mut units: Vec<FrozenUnit>, shared: &[(u64, usize)]) -> Vec<FrozenUnit> {
        let mut seen = BTreeSet::new();
        for unit in &mut units {
            for (number, waiting) in unit.inputs.iter_mut().flat_map(|input| &mut input.channels) {
                let queue = shared.iter().find(|(connection, _)| connection == number);
                if let Some((_, queue)) = queue
                    && !seen.insert(*queue)
                {
                    waiting.clear();
                }
            }
        }
        units
    }
}

impl FrozenWork {
    fn of(work: &DueWork) -> Result<Self, SystemFreezeError> {
        Ok(match work {
            DueWork::Sample { target, sample } => Self::Sample {
                target: *target,
                sample: FrozenSample::of(&**sample).map_err(no_data("an injected sample"))?,
            },
            DueWork::Deadline { component } => Self::Deadline {
                component: *component,
            },
            DueWork::Trigger {
                component,
                generation,
            } => Self::Trigger {
                component: *component,
                generation: *generation,
            },
            DueWork::Period {
                component,
                generation,
            } => Self::Period {
                component: *component,
                generation: *generation,
            },
        })
    }

    fn thaw(&self, names: &SampleNames) -> Result<DueWork, SystemThawError> {
        Ok(match self {
            Self::Sample { target, sample } => DueWork::Sample {
                target: *target,
                sample: sample.thaw(names)?,
            },
            Self::Deadline { component } => DueWork::Deadline {
                component: *component,
            },
            Self::Trigger {
                component,
                generation,
            } => DueWork::Trigger {
                component: *component,
                generation: *generation,
            },
            Self::Period {
                component,
                generation,
            } => DueWork::Period {
                component: *component,
                generation: *generation,
            },
        })
    }
}
