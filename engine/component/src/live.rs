//! Live: a thread for each component, absolute deadlines on a monotonic clock.
//!
//! A component's thread sleeps until its period has passed or until something new is there; it never waits for
//! another component. Events reach the observers through a bounded queue; they are told when the owner of the run
//! lets time pass.

mod courier;
mod events;
mod run;
mod wake;
mod worker;

use std::sync::atomic::Ordering;
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use datum::Sample;

use self::courier::Courier;
use self::events::Events;
use self::wake::Wake;
pub(crate) use self::wake::World;
use self::worker::{Command, Worker};
use crate::declaration::Declaration;
use crate::door::{Doors, Place};
use crate::health;
use crate::property::suggestion_among;
use crate::run::{Asked, Run, RunError, Watch};
use crate::stream::Letting;
use crate::unit::{Status, Unit};
use crate::{LifeCycleError, Observer, State, System, Time, Transition};

/// The longest the owner's thread sleeps without looking for events.
const NAP: Duration = Duration::from_millis(20);

/// A system running in real time.
pub struct Live {
    world: World,
    events: Arc<Events>,
    observers: Vec<Box<dyn Observer>>,
    hosts: Vec<Host>,
    doors: Doors,
    /// Samples from outside whose time has not come, latest first.
    planned: Vec<(Time, Place, Arc<dyn Sample>)>,
    grace: Duration,
    /// Lets in what comes over the bus.
    courier: Option<Courier>,
    /// Lets in what comes from sources.
    letting: Option<Letting>,
}

/// What the owner keeps of a component whose unit its thread has.
struct Host {
    name: Arc<str>,
    declaration: Declaration,
    may_interrupt: bool,
    status: Arc<Status>,
    wake: Arc<Wake>,
    commands: mpsc::Sender<Command>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    pub(crate) fn new(system: System) -> Self {
        let System {
            mut units,
            observers,
            topics,
            exchange,
            streams,
            ..
        } = system;
        let doors = Doors::new(&mut units, &topics);
        let events = Arc::new(Events::new(!observers.is_empty()));
        let wakes: Arc<[Arc<Wake>]> = units.iter().map(|_| Arc::default()).collect();
        let world = World::new(Instant::now(), Arc::clone(&wakes), Arc::clone(&events));
        let start: Vec<_> = units
            .iter()
            .map(|unit| unit.activity.run_on_startup)
            .collect();
        let hosts = units
            .into_iter()
            .zip(wakes.iter())
            .map(|(unit, wake)| Host::new(unit, wake, &world))
            .collect();
        let mut live = Self {
            world,
            events,
            observers,
            hosts,
            doors,
            planned: Vec::new(),
            grace: Duration::from_secs(5),
            courier: None,
            letting: None,
        };
        live.start_up(&start);
        if exchange.is_none() {
            let now = live.world.now();
            health::tell_alone(&topics, &mut live.doors, now, &mut live.world);
        }
        live.courier = exchange.map(|exchange| Courier::new(exchange, live.world.clone()));
        if !streams.is_empty() {
            live.letting = Some(Letting::new(streams, &live.world));
        }
        live
    }

    /// Configures everything, one after the other, then starts what runs on start-up.
    fn start_up(&mut self, start: &[bool]) {
        for index in 0..self.hosts.len() {
            // However long it takes: maps are loaded here. A failure is in the component's state.
            let _ = self.take_through(index, Transition::Configure, Duration::MAX);
        }
        for (index, start) in start.iter().enumerate() {
            if *start && self.hosts[index].status.state() == State::Stopped {
                let _ = self.take_through(index, Transition::Start, self.grace);
            }
        }
    }

    /// Adds an observer; it sees everything from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.events.observe();
        self.observers.push(Box::new(observer));
    }

    /// How long to wait for a component whose cycle is under way; five seconds unless set.
    pub fn set_grace(&mut self, grace: Duration) {
        self.grace = grace;
    }

    fn take_through(
        &mut self,
        index: usize,
        transition: Transition,
        patience: Duration,
    ) -> Result<(), LifeCycleError> {
        let host = &self.hosts[index];
        host.allow_interrupt(transition);
        let busy = || LifeCycleError::Busy {
            component: host.name.to_string(),
            transition,
        };
        match host.ask(patience, |answer| Command::Transition(transition, answer)) {
            Some(Err(RunError::LifeCycle(error))) => Err(error),
            Some(Ok(())) => Ok(()),
            // a transition ends in no other way
            Some(Err(
                RunError::Unknown { .. }
                | RunError::Mismatch { .. }
                | RunError::Property(_)
                | RunError::Busy { .. },
            ))
            | None => Err(busy()),
        }
    }

    fn find(&self, component: &str) -> Result<usize, RunError> {
        let found = (self.hosts.iter()).position(|host| *host.name == *component);
        found.ok_or_else(|| RunError::Unknown {
            what: "component",
            name: component.to_owned(),
            nearest: suggestion_among(component, self.hosts.iter().map(|host| &*host.name)),
        })
    }

    fn host(&self, component: &str) -> Option<&Host> {
        self.hosts.iter().find(|host| *host.name == *component)
    }

    /// Lets time pass, tells the observers, gives out samples whose time has come.
    fn advance(&mut self, until: Time, mut watch: Option<Watch<'_>>) -> bool {
        loop {
            self.give_planned();
            let mut seen = false;
            let observers = &mut self.observers;
            self.events.drain(|at, event| {
                for observer in observers.iter_mut() {
                    observer.observe(at, event);
                }
                if let Some(watch) = &mut watch {
                    seen |= watch(at, event);
                }
            });
            let now = self.world.now();
            if seen || now >= until {
                return seen;
            }
            let next = self.planned.last().map_or(until, |(at, ..)| until.min(*at));
            self.events.wait(next.since(now).min(NAP));
        }
    }

    fn give_planned(&mut self) {
        let now = self.world.now();
        while let Some((_, place, sample)) = self.planned.pop_if(|(at, ..)| *at <= now) {
            self.doors.give(place, &sample, now, &mut self.world);
        }
    }

    fn plan(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>) {
        // Those of one instant keep their order.
        let position = self.planned.partition_point(|(other, ..)| *other > at);
        self.planned.insert(position, (at, place, sample));
        self.give_planned();
    }
}

impl Host {
    fn new(unit: Unit, wake: &Arc<Wake>, world: &World) -> Self {
        let (commands, inbox) = mpsc::channel();
        let name = Arc::clone(&unit.name);
        let declaration = unit.body.declaration.clone();
        let status = Arc::clone(&unit.status);
        let may_interrupt = unit.activity.may_interrupt;
        let worker = Worker::new(unit, Arc::clone(wake), inbox, world.clone());
        let thread = std::thread::Builder::new()
            .name(name.to_string())
            .spawn(move || worker.run())
            .ok();
        if let Some(thread) = &thread {
            wake.set_thread(thread.thread().clone());
        }
        Self {
            name,
            declaration,
            may_interrupt,
            status,
            wake: Arc::clone(wake),
            commands,
            thread,
        }
    }

    /// Lets a long cycle know that the component shall stop.
    fn allow_interrupt(&self, transition: Transition) {
        if transition == Transition::Stop && self.may_interrupt {
            self.status.interrupt.store(true, Ordering::Relaxed);
        }
    }

    /// Asks the component's thread, and waits for nothing.
    fn begin(&self, command: impl FnOnce(mpsc::Sender<Result<(), RunError>>) -> Command) -> Asked {
        let (answer, answered) = mpsc::channel();
        // A thread that is gone answers nothing, which is an answer.
        let _ = self.commands.send(command(answer));
        self.wake.unpark();
        Asked::of(&self.name, answered)
    }

    /// Asks the component's thread, and waits for the answer; `None` if none comes in time.
    fn ask<R>(
        &self,
        patience: Duration,
        command: impl FnOnce(mpsc::Sender<R>) -> Command,
    ) -> Option<R> {
        let (answer, answered) = mpsc::channel();
        self.commands.send(command(answer)).ok()?;
        self.wake.unpark();
        if patience == Duration::MAX {
            answered.recv().ok()
        } else {
            answered.recv_timeout(patience).ok()
        }
    }
}

/// Stops everything and ends the threads; one that does not end is left behind.
impl Drop for Live {
    fn drop(&mut self) {
        self.courier = None;
        self.letting = None;
        let late = self.stop();
        for host in &self.hosts {
            // A thread that is gone needs no telling.
            let _ = host.commands.send(Command::End);
            host.wake.unpark();
        }
        let patience = if late.is_empty() { self.grace } else { NAP };
        let until = self.world.now() + patience;
        let ended = |host: &Host| host.thread.as_ref().is_none_or(JoinHandle::is_finished);
        while !self.hosts.iter().all(ended) && self.world.now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
