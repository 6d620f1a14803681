//! The timeline of a simulation: the clock, the queue of due items, and the observers.

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::{Drive, Fault};
use asmotion_port::Time;
use serde::{Deserialize, Serialize};

use super::cycle_order::CycleOrder;
use super::handle::SimulatedHandle;
use super::queue::{DueQueue, DueWork};
use crate::component_unit::ComponentUnit;
use crate::effects::Effects;
use crate::event::{Event, Observer, ReportInterest};
use crate::handle::RunHandle;
use crate::run::Watch;

/// Limit on the cycles of one component at one instant; more are a loop. Larger than the capacity of any input queue,
/// because a coordinator consumes one event a cycle.
const CYCLES_AN_INSTANT: u32 = 1000;

/// The state of a simulation around its units.
pub(super) struct Timeline {
    pub now: Time,
    pub queue: DueQueue,
    observers: Vec<Box<dyn Observer>>,
    /// The reports that each observer uses.
    interests: Vec<ReportInterest>,
    pub schedules: Vec<UnitSchedule>,
    /// The units that have cycled at the current instant, whose counts of cycles end with it.
    busy: Vec<usize>,
    /// Slaves of each unit, in the order of the units.
    slaves: Vec<Vec<usize>>,
    /// The order in which units have cycled lately, to prefetch those that are probably next.
    order: CycleOrder,
    /// A component has failed whose activity stops all components.
    pub escalated: bool,
    /// Shared with threads outside the simulation.
    pub handle: Arc<SimulatedHandle>,
}

/// The schedule of one unit.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitSchedule {
    drive: Drive,
    /// The unit is stopped and answers operations: requests trigger it, whatever its drive.
    serves: bool,
    /// A triggered cycle is in the queue already.
    pub triggered: bool,
    /// Incremented when the schedule is renewed, which invalidates older queue entries.
    pub generation: u64,
    /// Number of cycles at the current instant.
    pub cycles: u32,
}

/// The effects of one step on the timeline.
pub(super) struct SimulatedEffects<'a, 'w> {
    pub timeline: &'a mut Timeline,
    watch: Option<Watch<'w>>,
    /// An event satisfied `watch`.
    pub seen: bool,
}

impl Effects for SimulatedEffects<'_, '_> {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        for observer in &mut self.timeline.observers {
            observer.observe(at, event);
        }
        if let Some(watch) = &mut self.watch {
            self.seen |= (watch.predicate)(at, event);
        }
    }

    fn wants_report(&self, kind: &str) -> bool {
        let mut interests = self.timeline.interests.iter();
        let watch = self.watch.as_ref();
        interests.any(|reports| reports.includes(kind))
            || watch.is_some_and(|watch| watch.reports.includes(kind))
    }

    fn trigger(&mut self, component: usize) {
        let Some(driven) = self.timeline.schedules.get_mut(component) else {
            return;
        };
        if driven.drive == Drive::Event || driven.serves {
            let now = self.timeline.now;
            self.timeline.trigger(component, now);
        }
    }

    fn wake_at(&mut self, component: usize, at: Time) {
        self.timeline
            .queue
            .push(at, DueWork::Deadline { component });
    }

    fn escalate(&mut self, _: usize) {
        self.timeline.escalated = true;
    }

    fn next_order(&mut self) -> u64 {
        self.timeline.handle.next_order()
    }
}

impl Timeline {
    pub(super) fn new(units: &[ComponentUnit], observers: Vec<Box<dyn Observer>>) -> Self {
        let mut timeline = Self {
            now: Time::ZERO,
            queue: DueQueue::default(),
            interests: observers.iter().map(|it| it.reports()).collect(),
            observers,
            schedules: Vec::new(),
            busy: Vec::new(),
            slaves: Vec::new(),
            order: CycleOrder::default(),
            escalated: false,
            handle: Arc::new(SimulatedHandle::new(units.len())),
        };
        timeline.slaves.resize(units.len(), Vec::new());
        for unit in units {
            timeline.add(unit);
        }
        timeline
    }

    /// Adds an observer, which receives all events from now on.
    pub(super) fn observe(&mut self, observer: Box<dyn Observer>) {
        self.interests.push(observer.reports());
        self.observers.push(observer);
    }

    /// Adds the schedule of a new unit, whose position follows that of the last one.
    pub(super) fn add(&mut self, unit: &ComponentUnit) {
        self.handle.extend_to(unit.index);
        self.schedules.push(UnitSchedule::of(unit));
        if self.slaves.len() <= unit.index {
            self.slaves.resize(unit.index + 1, Vec::new());
        }
        if let Some(master) = unit.master {
            self.slaves[master].push(unit.index);
        }
    }

    /// Replaces the schedules of all units by those of another run.
    pub(super) fn resume(&mut self, schedules: &[UnitSchedule]) {
        self.schedules = schedules.to_vec();
        let cycled = |(_, schedule): &(usize, &UnitSchedule)| schedule.cycles > 0;
        let busy = self.schedules.iter().enumerate().filter(cycled);
        self.busy = busy.map(|(component, _)| component).collect();
    }

    /// Ends the schedule of a removed unit.
    pub(super) fn vacate(&mut self, component: usize) {
        let schedule = &mut self.schedules[component];
        schedule.serves = false;
        schedule.set_drive(Drive::Manual);
        for slaves in &mut self.slaves {
            slaves.retain(|slave| *slave != component);
        }
    }

    pub(super) fn set_now(&mut self, now: Time) {
        self.now = now;
        self.handle.set_now(now);
        for component in self.busy.drain(..) {
            self.schedules[component].cycles = 0;
        }
    }

    /// The running system, for threads outside the simulation.
    pub(super) fn run_handle(&self) -> Arc<dyn RunHandle> {
        Arc::clone(&self.handle) as Arc<dyn RunHandle>
    }

    /// Marks the run as ended.
    pub(super) fn end(&self) {
        self.handle.end();
    }

    /// The effects of one step on the timeline.
    pub(super) fn effects<'w>(&mut self, watch: Option<Watch<'w>>) -> SimulatedEffects<'_, 'w> {
        SimulatedEffects {
            timeline: self,
            watch,
            seen: false,
        }
    }
}

impl UnitSchedule {
    /// The schedule of a unit that does not run yet.
    fn of(unit: &ComponentUnit) -> Self {
        Self {
            drive: unit.activity.drive,
            serves: false,
            triggered: false,
            generation: 0,
            cycles: 0,
        }
    }

    /// Replaces the schedule and returns its generation.
    fn set_drive(&mut self, drive: Drive) -> u64 {
        self.drive = drive;
        self.triggered = false;
        self.generation += 1;
        self.generation
    }
}

impl SimulatedEffects<'_, '_> {
    /// Triggers the components that other threads have written to.
    pub(super) fn take_external_triggers(&mut self) {
        let handle = Arc::clone(&self.timeline.handle);
        handle.take_triggered(|component| self.trigger(component));
    }

    /// Runs one cycle of a unit. If the unit exceeds `CYCLES_AN_INSTANT`, it fails instead.
    pub(super) fn cycle(&mut self, units: &mut [ComponentUnit], component: usize) {
        let now = self.timeline.now;
        let driven = &mut self.timeline.schedules[component];
        if driven.cycles == 0 {
            self.timeline.busy.push(component);
        }
        driven.cycles += 1;
        if driven.cycles > CYCLES_AN_INSTANT {
            let fault = self.timeline.endless_loop(units);
            units[component].fail(fault, now, self);
            return;
        }
        self.timeline.order.prefetch_next(units, component);
        let ran = units[component].state().is_running();
        let unit = &mut units[component];
        unit.cycle(now, self);
        if ran {
            unit.check_deadline(unit.body.cycle_duration, now, self);
        }
        if units[component].restart_after_fault(now, self) {
            let pause = units[component].reset_pause();
            self.timeline.schedule_first(&units[component], pause)
        } else {
            self.timeline.apply_drive_change(&units[component])
        }
        if ran {
            self.slaves(units, component);
        }
    }

    /// Runs a cycle of each slave of a unit that has cycled, at the same instant.
    fn slaves(&mut self, units: &mut [ComponentUnit], master: usize) {
        // a cycle neither adds nor removes slaves
        for position in 0..self.timeline.slaves[master].len() {
            let slave = self.timeline.slaves[master][position];
            if units[slave].state().is_running() {
                self.cycle(units, slave);
            }
        }
    }

    /// Plans the next periodic cycle, at an absolute time to avoid drift.
    pub(super) fn schedule_next_period(
        &mut self,
        unit: &ComponentUnit,
        last: Time,
        generation: u64,
    ) {
        let unchanged = self.timeline.schedules[unit.index].generation == generation;
        if let Drive::Period(period) = unit.activity.drive
            && unchanged
            && unit.state().is_running()
        {
            let component = unit.index;
            self.timeline.queue.push(
                last + period,
                DueWork::Period {
                    component,
                    generation,
                },
            );
        }
    }
}

impl Timeline {
    /// Plans the first cycle after a start, after a pause. An event-driven component has one too: RTT triggers on start.
    pub(super) fn schedule_first(&mut self, unit: &ComponentUnit, pause: Duration) {
        let component = unit.index;
        let driven = &mut self.schedules[component];
        driven.serves = false;
        let generation = driven.set_drive(unit.activity.drive);
        let first = self.now + pause + unit.activity.delay;
        match unit.activity.drive {
            Drive::Manual | Drive::Slave => {}
            Drive::Event => self.trigger(component, first),
            Drive::Period(_) => {
                let what = DueWork::Period {
                    component,
                    generation,
                };
                self.queue.push(first, what);
            }
        }
    }

    /// Plans a triggered cycle, unless one is planned already.
    pub(super) fn trigger(&mut self, component: usize, at: Time) {
        let driven = &mut self.schedules[component];
        if driven.triggered {
            return;
        }
        driven.triggered = true;
        let generation = driven.generation;
        let what = DueWork::Trigger {
            component,
            generation,
        };
        self.queue.push(at, what);
    }

    /// Plans the unit's cycles again if its drive has changed, counting from the cycle that has just ended.
    pub(super) fn apply_drive_change(&mut self, unit: &ComponentUnit) {
        let driven = &mut self.schedules[unit.index];
        driven.serves = unit.serves_while_stopped();
        if driven.drive == unit.activity.drive {
            return;
        }
        let generation = driven.set_drive(unit.activity.drive);
        if let Drive::Period(period) = unit.activity.drive {
            let what = DueWork::Period {
                component: unit.index,
                generation,
            };
            self.queue.push(self.now + period, what);
        }
    }

    /// The fault of components that trigger each other endlessly.
    fn endless_loop(&self, units: &[ComponentUnit]) -> Fault {
        let busy =
            |unit: &&ComponentUnit| self.schedules[unit.index].cycles > CYCLES_AN_INSTANT / 2;
        Fault::Loop {
            at: self.now,
            components: units
                .iter()
                .filter(busy)
                .map(|unit| unit.name.to_string())
                .collect(),
        }
    }
}
