//! The world around simulated components: the clock, the queue, the observers, who is due when.

use std::sync::Arc;

use super::queue::{Queue, What};
use super::shore::Shore;
use crate::activity::Drive;
use crate::outside::Outside;
use crate::run::{Beyond, Watch};
use crate::unit::Unit;
use crate::{Event, Fault, Observer, Time};

/// Cycles of one component at one instant before that counts as a loop: more than any inbox holds events, of which a
/// coordinator takes one a cycle.
const CYCLES_AN_INSTANT: u32 = 1000;

/// Everything around the units.
pub(super) struct World {
    pub now: Time,
    pub queue: Queue,
    pub observers: Vec<Box<dyn Observer>>,
    pub each: Vec<Driven>,
    /// All are to stop.
    pub escalated: bool,
    /// What those outside share.
    shore: Arc<Shore>,
}

/// What the executor keeps of each unit.
pub(super) struct Driven {
    drive: Drive,
    /// A cycle is already in the queue because of a trigger.
    pub triggered: bool,
    /// Grows when the schedule is set anew; older entries of the queue then mean nothing.
    pub generation: u64,
    /// Cycles at the present instant.
    pub cycles: u32,
}

/// The world while one step is under way.
pub(super) struct Stepping<'a, 'w> {
    pub world: &'a mut World,
    watch: Option<Watch<'w>>,
    /// The event waited for has happened.
    pub seen: bool,
}

impl Outside for Stepping<'_, '_> {
    fn emit(&mut self, at: Time, event: &Event<'_>) {
        for observer in &mut self.world.observers {
            observer.observe(at, event);
        }
        if let Some(watch) = &mut self.watch {
            self.seen |= watch(at, event);
        }
    }

    fn trigger(&mut self, component: usize) {
        let Some(driven) = self.world.each.get_mut(component) else {
            return;
        };
        if driven.drive == Drive::Event {
            let now = self.world.now;
            self.world.trigger(component, now);
        }
    }

    fn wake_at(&mut self, component: usize, at: Time) {
        self.world.queue.push(at, What::Deadline { component });
    }

    fn escalate(&mut self, _: usize) {
        self.world.escalated = true;
    }

    fn next_order(&mut self) -> u64 {
        self.world.shore.next_order()
    }
}

impl World {
    pub(super) fn new(units: &[Unit], observers: Vec<Box<dyn Observer>>) -> Self {
        let each = |unit: &Unit| Driven {
            drive: unit.activity.drive,
            triggered: false,
            generation: 0,
            cycles: 0,
        };
        Self {
            now: Time::ZERO,
            queue: Queue::default(),
            observers,
            each: units.iter().map(each).collect(),
            escalated: false,
            shore: Arc::new(Shore::new(units.len())),
        }
    }

    pub(super) fn set_now(&mut self, now: Time) {
        self.now = now;
        self.shore.set_now(now);
    }

    /// The system, for those outside.
    pub(super) fn beyond(&self) -> Arc<dyn Beyond> {
        Arc::clone(&self.shore) as Arc<dyn Beyond>
    }

    /// The system runs no more.
    pub(super) fn end(&self) {
        self.shore.end();
    }

    /// The world while one step is under way.
    pub(super) fn stepping<'w>(&mut self, watch: Option<Watch<'w>>) -> Stepping<'_, 'w> {
        Stepping {
            world: self,
            watch,
            seen: false,
        }
    }
}

impl Driven {
    /// Sets the schedule anew.
    fn renew(&mut self, drive: Drive) -> u64 {
        self.drive = drive;
        self.triggered = false;
        self.generation += 1;
        self.generation
    }
}

impl Stepping<'_, '_> {
    /// Triggers those for whom somebody outside has written.
    pub(super) fn hear(&mut self) {
        let shore = Arc::clone(&self.world.shore);
        shore.take_news(|component| self.trigger(component));
    }

    /// One cycle of a unit, unless it has had too many at this instant.
    pub(super) fn cycle(&mut self, units: &mut [Unit], component: usize) {
        let now = self.world.now;
        let driven = &mut self.world.each[component];
        driven.cycles += 1;
        if driven.cycles > CYCLES_AN_INSTANT {
            let fault = self.world.endless(units);
            units[component].fail(fault, now, self);
            return;
        }
        let ran = units[component].state().is_running();
        let unit = &mut units[component];
        unit.cycle(now, self);
        if ran {
            unit.hold_to_deadline(unit.body.lasts, now, self);
        }
        match units[component].come_back(now, self) {
            true => self.world.begin(&units[component]),
            false => self.world.follow(&units[component]),
        }
        if ran {
            self.slaves(units, component);
        }
    }

    /// The slaves of a unit that has cycled do so, too, at the same instant.
    fn slaves(&mut self, units: &mut [Unit], master: usize) {
        for slave in 0..units.len() {
            if units[slave].master == Some(master) && units[slave].state().is_running() {
                self.cycle(units, slave);
            }
        }
    }

    /// Plans the next periodic cycle: at an absolute time, so that nothing drifts.
    pub(super) fn repeat(&mut self, unit: &Unit, last: Time, generation: u64) {
        let unchanged = self.world.each[unit.index].generation == generation;
        if let Drive::Period(period) = unit.activity.drive
            && unchanged
            && unit.state().is_running()
        {
            let component = unit.index;
            (self.world.queue).push(
                last + period,
                What::Period {
                    component,
                    generation,
                },
            );
        }
    }
}

impl World {
    /// Plans the first cycle after a start; an event-driven component has one too (RTT triggers on start).
    pub(super) fn begin(&mut self, unit: &Unit) {
        let component = unit.index;
        let driven = &mut self.each[component];
        let generation = driven.renew(unit.activity.drive);
        let first = self.now + unit.activity.delay;
        match unit.activity.drive {
            Drive::Manual | Drive::Slave => {}
            Drive::Event => self.trigger(component, first),
            Drive::Period(_) => {
                let what = What::Period {
                    component,
                    generation,
                };
                self.queue.push(first, what);
            }
        }
    }

    /// Plans a cycle, unless one is planned already.
    pub(super) fn trigger(&mut self, component: usize, at: Time) {
        let driven = &mut self.each[component];
        if driven.triggered {
            return;
        }
        driven.triggered = true;
        let generation = driven.generation;
        let what = What::Trigger {
            component,
            generation,
        };
        self.queue.push(at, what);
    }

    /// Notices that a unit's drive has changed, and plans anew from its last cycle: now.
    pub(super) fn follow(&mut self, unit: &Unit) {
        let driven = &mut self.each[unit.index];
        if driven.drive == unit.activity.drive {
            return;
        }
        let generation = driven.renew(unit.activity.drive);
        if let Drive::Period(period) = unit.activity.drive {
            let what = What::Period {
                component: unit.index,
                generation,
            };
            self.queue.push(self.now + period, what);
        }
    }

    /// The fault of those that trigger each other without end.
    fn endless(&self, units: &[Unit]) -> Fault {
        let busy = |unit: &&Unit| self.each[unit.index].cycles > CYCLES_AN_INSTANT / 2;
        Fault::Loop {
            at: self.now,
            components: (units.iter().filter(busy))
                .map(|unit| unit.name.to_string())
                .collect(),
        }
    }
}
