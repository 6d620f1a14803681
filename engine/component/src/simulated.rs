//! Simulated time: one thread, a virtual clock, a queue ordered by (time, declaration order).
//!
//! The same system runs the same way each time: nothing here asks what time it really is, but the pacer, which only
//! sleeps. What a cycle commits is delivered at once; a component it triggers runs at the same instant, after it.

mod queue;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use datum::{Datum, Sample};

use self::queue::{Due, Queue, What};
use crate::activity::Drive;
use crate::declaration::Declaration;
use crate::door::{Doors, Place};
use crate::outside::Outside;
use crate::property::suggestion_among;
use crate::run::{Run, RunError};
use crate::unit::Unit;
use crate::{Event, Fault, LifeCycleError, Observer, State, System, Time, Transition};

/// Cycles of one component at one instant before that counts as a loop.
const CYCLES_AN_INSTANT: u32 = 100;

/// How fast virtual time passes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pace {
    /// As fast as the machine can.
    #[default]
    Unlimited,
    /// So many virtual seconds in a real one.
    Factor(f64),
}

/// A system in simulated time.
pub struct Simulation {
    units: Vec<Unit>,
    world: World,
    doors: Doors,
    pacer: Option<Pacer>,
}

/// Everything around the units.
struct World {
    now: Time,
    queue: Queue,
    observers: Vec<Box<dyn Observer>>,
    /// Place of the last sample among all samples.
    order: u64,
    each: Vec<Driven>,
}

/// What the executor keeps of each unit.
struct Driven {
    drive: Drive,
    /// A cycle is already in the queue because of a trigger.
    triggered: bool,
    /// Grows when the periodic schedule is set anew; older entries of the queue then mean nothing.
    generation: u64,
    /// Cycles at the present instant.
    cycles: u32,
}

/// Somebody who waits for an event.
type Watch<'a> = &'a mut dyn FnMut(Time, &Event<'_>) -> bool;

/// The world while one step is under way.
struct Stepping<'a, 'w> {
    world: &'a mut World,
    watch: Option<Watch<'w>>,
    /// The event waited for has happened.
    seen: bool,
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
        if driven.drive == Drive::Event && !driven.triggered {
            driven.triggered = true;
            let now = self.world.now;
            (self.world.queue).push(now, What::Trigger { component });
        }
    }

    fn wake_at(&mut self, component: usize, at: Time) {
        self.world.queue.push(at, What::Deadline { component });
    }

    fn next_order(&mut self) -> u64 {
        self.world.order += 1;
        self.world.order
    }
}

impl Simulation {
    pub(crate) fn new(system: System) -> Self {
        let System {
            mut units,
            observers,
            topics,
        } = system;
        let doors = Doors::new(&mut units, &topics);
        let each = units
            .iter()
            .map(|unit| Driven {
                drive: unit.activity.drive,
                triggered: false,
                generation: 0,
                cycles: 0,
            })
            .collect();
        let mut simulation = Self {
            units,
            world: World {
                now: Time::ZERO,
                queue: Queue::default(),
                observers,
                order: 0,
                each,
            },
            doors,
            pacer: None,
        };
        simulation.start_up();
        simulation
    }

    fn start_up(&mut self) {
        for index in 0..self.units.len() {
            // A failure is in the component's state and told to the observers.
            let _ = self.take_through(index, Transition::Configure);
        }
        for index in 0..self.units.len() {
            let unit = &self.units[index];
            if unit.activity.run_on_startup && unit.state() == State::Stopped {
                let _ = self.take_through(index, Transition::Start);
            }
        }
    }

    /// Makes virtual time keep pace with real time from now on.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pacer = match pace {
            Pace::Unlimited => None,
            Pace::Factor(factor) => Some(Pacer::new(self.world.now, factor)),
        };
    }

    /// Adds an observer; it sees everything from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.world.observers.push(Box::new(observer));
    }

    /// Does what is due next: a cycle, a deadline, a sample from outside. `None` if nothing is due ever.
    pub fn step(&mut self) -> Option<Time> {
        let due = self.world.queue.pop()?;
        self.act(due, None);
        Some(self.world.now)
    }

    /// When something is due next.
    pub fn next_due(&self) -> Option<Time> {
        self.world.queue.next()
    }

    /// Runs what is due up to a time, and says whether the event waited for has happened.
    fn advance(&mut self, until: Time, mut watch: Option<Watch<'_>>) -> bool {
        while self.world.queue.next().is_some_and(|at| at <= until) {
            let Some(due) = self.world.queue.pop() else {
                break;
            };
            let watch = watch.as_mut().map(|watch| &mut **watch as Watch<'_>);
            if self.act(due, watch) {
                return true;
            }
        }
        self.set_time(until);
        false
    }

    fn set_time(&mut self, at: Time) {
        if at <= self.world.now {
            return;
        }
        if let Some(pacer) = &self.pacer {
            pacer.wait(at);
        }
        self.world.now = at;
        for driven in &mut self.world.each {
            driven.cycles = 0;
        }
    }

    /// Does one thing. Says whether the event waited for has happened.
    fn act(&mut self, due: Due, watch: Option<Watch<'_>>) -> bool {
        self.set_time(due.at);
        let mut stepping = Stepping {
            world: &mut self.world,
            watch,
            seen: false,
        };
        match due.what {
            What::Sample { place, sample } => {
                self.doors.give(place, &sample, due.at, &mut stepping);
            }
            What::Deadline { component } => {
                self.units[component].settle(due.at, &mut stepping);
            }
            What::Trigger { component } => {
                stepping.world.each[component].triggered = false;
                stepping.cycle(&mut self.units, component);
            }
            What::Period {
                component,
                generation,
            } => {
                if stepping.world.each[component].generation == generation {
                    stepping.cycle(&mut self.units, component);
                    stepping.repeat(&self.units[component], due.at, generation);
                }
            }
        }
        stepping.seen
    }

    /// Runs something of a unit that is not a cycle: a transition, a change of properties.
    fn attend<R>(&mut self, index: usize, act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> R) -> R {
        let now = self.world.now;
        let mut stepping = Stepping {
            world: &mut self.world,
            watch: None,
            seen: false,
        };
        act(&mut self.units[index], now, &mut stepping)
    }

    fn take_through(&mut self, index: usize, transition: Transition) -> Result<(), LifeCycleError> {
        let result = self.attend(index, |unit, now, outside| {
            unit.transition(transition, now, outside)
        });
        if result.is_ok() && transition == Transition::Start {
            self.world.begin(&self.units[index]);
        }
        result
    }

    fn find(&self, component: &str) -> Result<usize, RunError> {
        let found = (self.units.iter()).position(|unit| *unit.name == *component);
        found.ok_or_else(|| RunError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(component, self.units.iter().map(|unit| &*unit.name)),
        })
    }

    fn unit(&self, component: &str) -> Option<&Unit> {
        self.units.iter().find(|unit| *unit.name == *component)
    }

    fn enqueue(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>) {
        let at = at.max(self.world.now);
        self.world.queue.push(at, What::Sample { place, sample });
    }
}

impl Stepping<'_, '_> {
    /// One cycle of a unit, unless it has had too many at this instant.
    fn cycle(&mut self, units: &mut [Unit], component: usize) {
        let now = self.world.now;
        let driven = &mut self.world.each[component];
        driven.cycles += 1;
        if driven.cycles > CYCLES_AN_INSTANT {
            let fault = self.world.endless(units);
            units[component].fail(fault, now, self);
            return;
        }
        units[component].cycle(now, self);
        self.world.follow(&units[component]);
    }

    /// Plans the next periodic cycle: at an absolute time, so that nothing drifts.
    fn repeat(&mut self, unit: &Unit, last: Time, generation: u64) {
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
    fn begin(&mut self, unit: &Unit) {
        let component = unit.index;
        let driven = &mut self.each[component];
        driven.drive = unit.activity.drive;
        driven.generation += 1;
        let first = self.now + unit.activity.delay;
        match driven.drive {
            Drive::Manual => {}
            Drive::Event => {
                driven.triggered = true;
                self.queue.push(first, What::Trigger { component });
            }
            Drive::Period(_) => {
                let generation = driven.generation;
                self.queue.push(
                    first,
                    What::Period {
                        component,
                        generation,
                    },
                );
            }
        }
    }

    /// Notices that a unit's drive has changed, and plans anew from its last cycle: now.
    fn follow(&mut self, unit: &Unit) {
        let driven = &mut self.each[unit.index];
        if driven.drive == unit.activity.drive {
            return;
        }
        driven.drive = unit.activity.drive;
        driven.generation += 1;
        if let Drive::Period(period) = driven.drive {
            let what = What::Period {
                component: unit.index,
                generation: driven.generation,
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

impl Run for Simulation {
    fn now(&self) -> Time {
        self.world.now
    }

    fn run_until(&mut self, until: Time) {
        self.advance(until, None);
    }

    fn run_until_event(
        &mut self,
        limit: Time,
        wanted: &mut dyn FnMut(Time, &Event<'_>) -> bool,
    ) -> bool {
        self.advance(limit, Some(wanted))
    }

    fn inject_sample(
        &mut self,
        at: Time,
        port: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.port(port, &sample)?;
        self.enqueue(at, place, sample);
        Ok(())
    }

    fn publish_sample(
        &mut self,
        at: Time,
        topic: &str,
        sample: Arc<dyn Sample>,
    ) -> Result<(), RunError> {
        let place = self.doors.topic(topic, &sample)?;
        self.enqueue(at, place, sample);
        Ok(())
    }

    fn transition(
        &mut self,
        component: &str,
        transition: Transition,
    ) -> Result<(), LifeCycleError> {
        let index = self.find(component).map_err(|_| LifeCycleError::Unknown {
            component: component.to_owned(),
        })?;
        self.take_through(index, transition)
    }

    fn trigger(&mut self, component: &str) -> Result<(), RunError> {
        let component = self.find(component)?;
        let driven = &mut self.world.each[component];
        if !driven.triggered {
            driven.triggered = true;
            let now = self.world.now;
            self.world.queue.push(now, What::Trigger { component });
        }
        Ok(())
    }

    fn set_period(&mut self, component: &str, period: Duration) -> Result<(), RunError> {
        let index = self.find(component)?;
        self.units[index].activity.drive = Drive::of_period(period);
        self.world.follow(&self.units[index]);
        Ok(())
    }

    fn set_properties(
        &mut self,
        component: &str,
        values: &[(String, Datum)],
    ) -> Result<(), RunError> {
        let index = self.find(component)?;
        self.attend(index, |unit, now, outside| {
            unit.set_properties(values, now, outside)
        })?;
        Ok(())
    }

    fn components(&self) -> Vec<String> {
        self.units.iter().map(|unit| unit.name.to_string()).collect()
    }

    fn state(&self, component: &str) -> Option<State> {
        self.unit(component).map(Unit::state)
    }

    fn cycles(&self, component: &str) -> u64 {
        let unit = self.unit(component);
        unit.map_or(0, |unit| unit.status.cycles.load(Ordering::Relaxed))
    }

    fn overruns(&self, component: &str) -> u64 {
        let unit = self.unit(component);
        unit.map_or(0, |unit| unit.status.overruns.load(Ordering::Relaxed))
    }

    fn fault(&self, component: &str) -> Option<Fault> {
        self.unit(component).and_then(|unit| unit.fault.clone())
    }

    fn declaration(&self, component: &str) -> Option<Declaration> {
        let unit = self.unit(component);
        unit.map(|unit| unit.body.declaration.clone())
    }

    fn properties(&mut self, component: &str) -> Result<Vec<(String, Datum)>, RunError> {
        let index = self.find(component)?;
        Ok(self.units[index].body.values())
    }

    fn stop(&mut self) -> Vec<String> {
        for index in (0..self.units.len()).rev() {
            if self.units[index].state().is_running() {
                let _ = self.take_through(index, Transition::Stop);
            }
        }
        Vec::new()
    }
}

/// Holds virtual time back to a pace.
struct Pacer {
    from: Time,
    since: Instant,
    factor: f64,
}

impl Pacer {
    fn new(from: Time, factor: f64) -> Self {
        Self {
            from,
            since: Instant::now(),
            factor,
        }
    }

    /// Sleeps until virtual time may be `at`.
    fn wait(&self, at: Time) {
        let seconds = at.since(self.from).as_secs_f64() / self.factor;
        let Ok(after) = Duration::try_from_secs_f64(seconds) else {
            return;
        };
        std::thread::sleep(after.saturating_sub(self.since.elapsed()));
    }
}
