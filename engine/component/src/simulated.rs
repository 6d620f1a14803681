//! Simulated time: one thread, a virtual clock, a queue ordered by (time, declaration order).
//!
//! The same system runs the same way each time: nothing here asks what time it really is, but the pacer, which only
//! sleeps. What a cycle commits is delivered at once; a component it triggers runs at the same instant, after it.

mod pacer;
mod queue;
mod shore;
mod world;

use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Sample;

pub use self::pacer::Pace;
use self::pacer::Pacer;
use self::queue::{Due, What};
use self::world::World;
use crate::door::{Doors, Place};
use crate::exchange::Exchange;
use crate::face::Face;
use crate::health;
use crate::run::{Act, Beyond, Executor, Watch};
use crate::system::Joints;
use crate::unit::Unit;
use crate::{Observer, System, Time};

/// A system in simulated time.
pub struct Simulation {
    units: Vec<Unit>,
    faces: Vec<Face>,
    joints: Joints,
    world: World,
    doors: Doors,
    exchange: Option<Exchange>,
    pacer: Option<Pacer>,
}

impl Simulation {
    pub(crate) fn new(mut system: System) -> Self {
        let faces = system.take_up();
        let System {
            mut units,
            observers,
            topics,
            exchange,
            mut joints,
            ..
        } = system;
        let doors = Doors::new(&mut units, &topics, &mut joints);
        let mut simulation = Self {
            world: World::new(&units, observers),
            units,
            faces,
            joints,
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

    /// Lets in what has come over the bus, and lets those cycle for whom somebody outside has written.
    fn let_in(&mut self) {
        let now = self.world.now;
        let mut stepping = self.world.stepping(None);
        stepping.hear();
        if let Some(exchange) = &mut self.exchange {
            exchange.deliver(now, &mut stepping);
        }
    }

    fn set_time(&mut self, at: Time) {
        if at <= self.world.now {
            return;
        }
        if let Some(pacer) = &self.pacer {
            pacer.wait(at);
        }
        self.world.set_now(at);
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
        let seen = stepping.seen;
        if std::mem::take(&mut self.world.escalated) {
            self.stop_all();
        }
        seen
    }
}

impl Executor for Simulation {
    fn clock(&self) -> Time {
        self.world.now
    }

    fn faces(&self) -> &[Face] {
        &self.faces
    }

    fn joints(&mut self) -> (&mut Joints, &[Face]) {
        (&mut self.joints, &self.faces)
    }

    fn doors(&self) -> &Doors {
        &self.doors
    }

    fn beyond(&self) -> Arc<dyn Beyond> {
        self.world.beyond()
    }

    fn plan(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>) {
        let at = at.max(self.world.now);
        self.world.queue.push(at, What::Sample { place, sample });
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

    fn call(&mut self, component: usize) {
        let now = self.world.now;
        self.world.trigger(component, now);
    }

    /// No cycle is ever under way.
    fn patience(&self) -> Duration {
        Duration::MAX
    }

    fn glance(&self) -> Duration {
        Duration::MAX
    }

    fn post(&mut self, component: usize, act: Act) {
        let now = self.world.now;
        let mut stepping = self.world.stepping(None);
        let unit = &mut self.units[component];
        let ran = unit.state().is_running();
        act(unit, now, &mut stepping);
        match !ran && unit.state().is_running() {
            true => self.world.begin(unit),
            false => self.world.follow(unit),
        }
    }
}

/// Those outside learn that the system is gone.
impl Drop for Simulation {
    fn drop(&mut self) {
        self.world.end();
    }
}
