//! Live: a thread for each component and its slaves, absolute deadlines on a monotonic clock.
//!
//! A component's thread sleeps until its period has passed or until something new is there; it never waits for
//! another component. Events reach the observers through a bounded queue; they are told when the owner of the run
//! lets time pass.

mod courier;
mod events;
mod schedule;
mod wake;
mod worker;

use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_datum::Sample;

use self::courier::Courier;
use self::events::Events;
use self::wake::Wake;
pub(crate) use self::wake::World;
use self::worker::{Command, Worker};
use crate::background;
use crate::door::{Doors, Place};
use crate::face::Face;
use crate::health;
use crate::run::{Act, Beyond, Executor, Watch};
use crate::stream::Letting;
use crate::system::Joints;
use crate::unit::Unit;
use crate::{Observer, System, Time};

/// The longest the owner's thread sleeps without looking for events.
const NAP: Duration = Duration::from_millis(20);

/// A system running in real time.
pub struct Live {
    world: World,
    events: Arc<Events>,
    observers: Vec<Box<dyn Observer>>,
    faces: Vec<Face>,
    joints: Joints,
    /// One for each component that is nobody's slave.
    threads: Vec<Thread>,
    doors: Doors,
    /// Samples from outside whose time has not come, latest first.
    planned: Vec<(Time, Place, Arc<dyn Sample>)>,
    grace: Duration,
    /// Lets in what comes over the bus.
    courier: Option<Courier>,
    /// Lets in what comes from sources.
    letting: Option<Letting>,
}

/// A thread, for a component and its slaves.
struct Thread {
    /// The component that is nobody's slave.
    component: usize,
    commands: mpsc::Sender<Command>,
    wake: Arc<Wake>,
    handle: Option<JoinHandle<()>>,
}

impl Live {
    pub(crate) fn new(mut system: System) -> Self {
        let faces = system.take_up();
        let System {
            mut units,
            observers,
            topics,
            exchange,
            streams,
            mut joints,
            ..
        } = system;
        let doors = Doors::new(&mut units, &topics, &mut joints);
        let events = Arc::new(Events::new(!observers.is_empty()));
        let wakes: Arc<[Arc<Wake>]> = units.iter().map(|_| Arc::default()).collect();
        let world = World::new(Instant::now(), wakes, Arc::clone(&events));
        for unit in &mut units {
            let wake = world.wake(unit.index);
            let finished = Arc::new(move || wake.news());
            unit.body.background = background::WorkPlace::Thread(finished);
        }
        let mut live = Self {
            threads: threads(units, &faces, &world),
            world,
            events,
            observers,
            faces,
            joints,
            doors,
            planned: Vec::new(),
            grace: Duration::from_secs(5),
            courier: None,
            letting: None,
        };
        live.start_up();
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

    /// Adds an observer; it sees everything from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.events.observe();
        self.observers.push(Box::new(observer));
    }

    /// How long to wait for a component whose cycle is under way; five seconds unless set.
    pub fn set_grace(&mut self, grace: Duration) {
        self.grace = grace;
    }

    fn give_planned(&mut self) {
        let now = self.world.now();
        while let Some((_, place, sample)) = self.planned.pop_if(|(at, ..)| *at <= now) {
            self.doors.give(place, &sample, now, &mut self.world);
        }
    }

    /// Tells the observers what has happened. Says whether it was what is watched for.
    fn tell(&mut self, watch: &mut Option<Watch<'_>>) -> bool {
        let mut seen = false;
        let observers = &mut self.observers;
        self.events.drain(|at, event| {
            for observer in observers.iter_mut() {
                observer.observe(at, event);
            }
            if let Some(watch) = watch {
                seen |= watch(at, event);
            }
        });
        seen
    }
}

/// Starts the threads: each has a component that is nobody's slave, and its slaves, in order of addition.
fn threads(units: Vec<Unit>, faces: &[Face], world: &World) -> Vec<Thread> {
    let mut groups: Vec<(usize, Vec<Unit>)> = Vec::new();
    for unit in units {
        let component = faces[unit.index].thread;
        match groups.iter_mut().find(|(known, _)| *known == component) {
            Some((_, group)) => group.push(unit),
            None => groups.push((component, vec![unit])),
        }
    }
    let groups = groups.into_iter();
    groups
        .map(|(component, group)| Thread::new(component, group, &faces[component].name, world))
        .collect()
}

impl Thread {
    fn new(component: usize, group: Vec<Unit>, name: &str, world: &World) -> Self {
        let (commands, inbox) = mpsc::channel();
        let wakes: Vec<_> = group.iter().map(|unit| world.wake(unit.index)).collect();
        let worker = Worker::new(group, &wakes, inbox, world.clone());
        let builder = std::thread::Builder::new().name(name.to_owned());
        let handle = builder.spawn(move || worker.run()).ok();
        if let Some(handle) = &handle {
            for wake in &wakes {
                wake.set_thread(handle.thread().clone());
            }
        }
        Self {
            component,
            commands,
            wake: world.wake(component),
            handle,
        }
    }

    fn send(&self, command: Command) {
        // A thread that is gone needs no telling.
        let _ = self.commands.send(command);
        self.wake.unpark();
    }
}

impl Executor for Live {
    fn clock(&self) -> Time {
        self.world.now()
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
        Arc::new(self.world.clone())
    }

    fn plan(&mut self, at: Time, place: Place, sample: Arc<dyn Sample>) {
        // Those of one instant keep their order.
        let position = self.planned.partition_point(|(other, ..)| *other > at);
        self.planned.insert(position, (at, place, sample));
        self.give_planned();
    }

    /// Lets time pass, tells the observers, gives out samples whose time has come.
    fn advance(&mut self, until: Time, mut watch: Option<Watch<'_>>) -> bool {
        if watch.is_some() {
            self.events.observe();
        }
        loop {
            self.give_planned();
            if self.world.take_escalation() {
                self.stop_all();
            }
            let seen = self.tell(&mut watch);
            let now = self.world.now();
            if seen || now >= until {
                return seen;
            }
            let next = self.planned.last().map_or(until, |(at, ..)| until.min(*at));
            self.events.wait(next.since(now).min(NAP));
        }
    }

    fn call(&mut self, component: usize) {
        self.world.wake(component).call();
    }

    fn patience(&self) -> Duration {
        self.grace
    }

    /// Whoever looks on does not wait for a long cycle.
    fn glance(&self) -> Duration {
        NAP
    }

    fn post(&mut self, component: usize, act: Act) {
        let thread = self.faces[component].thread;
        if let Some(thread) = (self.threads.iter()).find(|one| one.component == thread) {
            thread.send(Command::Act(component, act));
        }
    }
}

/// Stops everything and ends the threads; one that does not end is left behind.
impl Drop for Live {
    fn drop(&mut self) {
        self.courier = None;
        self.letting = None;
        let late = self.stop_all();
        self.tell(&mut None);
        self.world.end();
        for thread in &self.threads {
            thread.send(Command::End);
        }
        let patience = if late.is_empty() { self.grace } else { NAP };
        let until = self.world.now() + patience;
        let ended = |thread: &Thread| thread.handle.as_ref().is_none_or(JoinHandle::is_finished);
        while !self.threads.iter().all(ended) && self.world.now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
