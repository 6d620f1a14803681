//! Simulated time: one thread, a virtual clock, a queue ordered by (time, declaration order).
//!
//! The same system runs the same way each time: nothing here asks what time it really is, but the pacer, which only
//! sleeps. What a cycle commits is delivered at once; a component it triggers runs at the same instant, after it.

mod pacer;
mod queue;
mod run;
mod world;

use std::sync::Arc;

use datum::Sample;

pub use self::pacer::Pace;
use self::pacer::Pacer;
use self::queue::{Due, What};
use self::world::World;
use crate::door::{Doors, Place};
use crate::exchange::Exchange;
use crate::health;
use crate::outside::Outside;
use crate::property::suggestion_among;
use crate::run::{RunError, Watch};
use crate::unit::Unit;
use crate::{LifeCycleError, Observer, State, System, Time, Transition};

/// A system in simulated time.
pub struct Simulation {
    units: Vec<Unit>,
    world: World,
    doors: Doors,
    exchange: Option<Exchange>,
    pacer: Option<Pacer>,
}

impl Simulation {
    pub(crate) fn new(system: System) -> Self {
        let System {
            mut units,
            observers,
            topics,
            exchange,
            ..
        } = system;
        let doors = Doors::new(&mut units, &topics);
        let mut simulation = Self {
            world: World::new(&units, observers),
            units,
            doors,
            exchange,
            pacer: None,
        };
        simulation.start_up();
        if simulation.exchange.is_none() {
            let now = simulation.world.now;
            let mut stepping = simulation.world.stepping(None);
            health::tell_alone(&topics, &mut simulation.doors, now, &mut stepping);
        }
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
        self.let_in();
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
        loop {
            self.let_in();
            let Some(due) = self.world.queue.pop_until(until) else {
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

    /// Lets in what has come over the bus.
    fn let_in(&mut self) {
        let Some(exchange) = &mut self.exchange else {
            return;
        };
        let now = self.world.now;
        let mut stepping = self.world.stepping(None);
        exchange.deliver(now, &mut stepping);
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
        let mut stepping = self.world.stepping(watch);
        match due.what {
            What::Sample { place, sample } => {
                self.doors.give(place, &sample, due.at, &mut stepping);
            }
            What::Deadline { component } => {
                self.units[component].settle(due.at, &mut stepping);
            }
            What::Trigger {
                component,
                generation,
            } => {
                let driven = &mut stepping.world.each[component];
                if driven.generation == generation {
                    driven.triggered = false;
                    stepping.cycle(&mut self.units, component);
                }
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
    fn attend<R>(
        &mut self,
        index: usize,
        act: impl FnOnce(&mut Unit, Time, &mut dyn Outside) -> R,
    ) -> R {
        let now = self.world.now;
        let mut stepping = self.world.stepping(None);
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
