//! Live: a thread for each component and its slaves, absolute deadlines on a monotonic clock.
//!
//! A component's thread sleeps until its period has passed or new data arrive; it never waits for another component.
//! Events reach the observers through a bounded queue, which is drained while the owner of the run lets time pass.

mod bus_thread;
mod schedule;
mod worker;

use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_component::WorkPlace;
use asmotion_datum::Sample;
use asmotion_port::Time;

use self::bus_thread::BusThread;
use self::worker::{Worker, WorkerCommand};
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::context::{EventQueue, LiveContext};
use crate::descriptor::ComponentDescriptor;
use crate::event::{Event, Observer};
use crate::handle::RunHandle;
use crate::health;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::run::{Act, Executor, Watch};
use crate::stream::{SinkThread, SourceThreads};
use crate::system::System;

/// Longest sleep of the owner's thread between two looks at the event queue.
const NAP: Duration = Duration::from_millis(20);

/// A system running in real time.
pub struct Live {
    context: LiveContext,
    events: Arc<EventQueue>,
    observers: Vec<Box<dyn Observer>>,
    descriptors: Vec<ComponentDescriptor>,
    connections: ConnectionTable,
    /// One for each component that is not a slave.
    threads: Vec<Thread>,
    /// Threads of components whose addition is not certain yet.
    new_threads: Vec<Thread>,
    /// Threads of removed components, which end after their current cycle, and of abandoned ones.
    ending: Vec<JoinHandle<()>>,
    injections: InjectionPorts,
    /// Samples to be injected at a later time, latest first.
    planned: Vec<(Time, InjectionTarget, Arc<dyn Sample>)>,
    grace_period: Duration,
    /// Calls the adapters; `None` without adapters.
    bus_thread: Option<BusThread>,
    /// Does the upkeep of sinks; `None` without sinks.
    sinks: Option<SinkThread>,
    /// The threads that read sources; `None` without sources.
    sources: Option<SourceThreads>,
}

/// The thread of a component and its slaves.
struct Thread {
    /// Position of the component that is not a slave.
    component: usize,
    commands: mpsc::Sender<WorkerCommand>,
    handle: Option<JoinHandle<()>>,
}

impl System {
    /// Starts the system in real time, with a thread for each component that is not a slave.
    ///
    /// Configures every component, then starts those with `run_on_startup`, and only then begins their cycles, all at
    /// the same time: the first cycle of each sees the others running, as in [`simulate`](Self::simulate). A component
    /// that fails is left as it is; its state and an [`Event::Fault`](crate::Event::Fault) show it.
    pub fn live(self) -> Live {
        Live::new(self)
    }
}

impl Live {
    fn new(mut system: System) -> Self {
        let descriptors = system.begin_run();
        let System {
            mut units,
            observers,
            topics,
            adapters,
            notifier,
            sinks,
            streams,
            mut connections,
            topics_outside,
            ..
        } = system;
        let injections = InjectionPorts::new(&mut units, &topics, &mut connections);
        let events = Arc::new(EventQueue::new(!observers.is_empty()));
        let context = LiveContext::new(Instant::now(), units.len(), Arc::clone(&events));
        for unit in &mut units {
            unit.body.work_place = work_place(&context, unit.index);
        }
        let mut live = Self {
            threads: spawn_threads(units, &descriptors, &context),
            new_threads: Vec::new(),
            ending: Vec::new(),
            context,
            events,
            observers,
            descriptors,
            connections,
            injections,
            planned: Vec::new(),
            grace_period: Duration::from_secs(5),
            bus_thread: None,
            sinks: None,
            sources: None,
        };
        live.start_up();
        if adapters.is_empty() {
            let now = live.context.now();
            health::publish_without_bus(&topics, &mut live.injections, now, &mut live.context);
        } else {
            let bus_thread = BusThread::new(adapters, notifier, live.context.clone());
            live.bus_thread = Some(bus_thread);
        }
        if !sinks.is_empty() {
            live.sinks = Some(SinkThread::new(sinks, live.context.clone()));
        }
        if !streams.is_empty() {
            live.sources = Some(SourceThreads::new(streams, &live.context));
        }
        live.connections.topics = (!topics_outside && live.bus_thread.is_none()).then_some(topics);
        live.release();
        live
    }

    /// Begins the cycles of all components at the same time.
    fn release(&mut self) {
        let now = self.context.now();
        for thread in &self.threads {
            thread.send(WorkerCommand::Release(now));
        }
    }

    /// Adds an observer, which receives all events from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.events.observe();
        self.observers.push(Box::new(observer));
    }

    /// Sets how long to wait for a component whose cycle is under way (default: 5 s).
    pub fn set_grace_period(&mut self, grace_period: Duration) {
        self.grace_period = grace_period;
    }

    fn inject_planned(&mut self) {
        let now = self.context.now();
        while let Some((_, target, sample)) = self.planned.pop_if(|(at, ..)| *at <= now) {
            self.injections
                .inject(target, &sample, now, &mut self.context);
        }
    }

    /// Passes waiting events to the observers. Returns whether one of them satisfied `watch`.
    fn notify_observers(&mut self, watch: &mut Option<Watch<'_>>) -> bool {
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

/// The threads of a component's background work.
fn work_place(context: &LiveContext, component: usize) -> WorkPlace {
    let waker = context.waker(component);
    // request a cycle whatever drives the component: a periodic one would otherwise pass the result on a period late
    WorkPlace::Thread(Arc::new(move || waker.request_cycle()))
}

/// Starts one thread for each component that is not a slave; its slaves follow in order of addition.
fn spawn_threads(
    units: Vec<ComponentUnit>,
    descriptors: &[ComponentDescriptor],
    context: &LiveContext,
) -> Vec<Thread> {
    let mut groups: Vec<(usize, Vec<ComponentUnit>)> = Vec::new();
    for unit in units {
        let component = descriptors[unit.index].thread;
        match groups.iter_mut().find(|(known, _)| *known == component) {
            Some((_, group)) => group.push(unit),
            None => groups.push((component, vec![unit])),
        }
    }
    let groups = groups.into_iter();
    groups
        .map(|(component, group)| {
            Thread::new(component, group, &descriptors[component].name, context)
        })
        .collect()
}

impl Thread {
    fn new(component: usize, group: Vec<ComponentUnit>, name: &str, context: &LiveContext) -> Self {
        let (commands, queue) = mpsc::channel();
        let wakers: Vec<_> = group.iter().map(|unit| context.waker(unit.index)).collect();
        let worker = Worker::new(group, &wakers, queue, context.clone());
        let builder = std::thread::Builder::new().name(name.to_owned());
        let handle = builder.spawn(move || worker.run()).ok();
        if let Some(handle) = &handle {
            for waker in &wakers {
                waker.set_thread(handle.thread().clone());
            }
        }
        Self {
            component,
            commands,
            handle,
        }
    }

    fn send(&self, command: WorkerCommand) {
        // fails if the thread has ended, in which case there is nothing left to do
        let _ = self.commands.send(command);
        if let Some(handle) = &self.handle {
            handle.thread().unpark();
        }
    }
}

impl Executor for Live {
    fn clock(&self) -> Time {
        self.context.now()
    }

    fn descriptors(&self) -> &[ComponentDescriptor] {
        &self.descriptors
    }

    fn descriptors_mut(&mut self) -> &mut Vec<ComponentDescriptor> {
        &mut self.descriptors
    }

    fn connections(&mut self) -> (&mut ConnectionTable, &[ComponentDescriptor]) {
        (&mut self.connections, &self.descriptors)
    }

    fn injections(&self) -> &InjectionPorts {
        &self.injections
    }

    fn injections_mut(&mut self) -> &mut InjectionPorts {
        &mut self.injections
    }

    fn prepare(&mut self, component: usize) -> WorkPlace {
        self.context.extend_to(component);
        work_place(&self.context, component)
    }

    fn run_for_new<R: Send + 'static>(
        &mut self,
        (component, name): (usize, &str),
        work: impl FnOnce() -> R + Send + 'static,
        late: impl FnOnce(R) + Send + 'static,
    ) -> Option<R> {
        let mut threads = self.new_threads.iter();
        let thread = match threads.position(|it| it.component == component) {
            Some(thread) => thread,
            None => {
                let thread = Thread::new(component, Vec::new(), name, &self.context);
                self.new_threads.push(thread);
                self.new_threads.len() - 1
            }
        };
        let (sender, receiver) = mpsc::channel();
        let work = move || {
            // fails if the caller's patience has ended
            if let Err(mpsc::SendError(result)) = sender.send(work()) {
                late(result);
            }
        };
        self.new_threads[thread].send(WorkerCommand::Work(Box::new(work)));
        receiver.recv_timeout(self.grace_period).ok()
    }

    fn abandon_new(&mut self) {
        for thread in self.new_threads.drain(..) {
            thread.send(WorkerCommand::End);
            self.ending.extend(thread.handle);
        }
    }

    fn adopt(&mut self, unit: ComponentUnit) {
        let (component, name) = (unit.index, Arc::clone(&unit.name));
        let mut threads = self.new_threads.iter();
        let thread = match threads.position(|it| it.component == component) {
            Some(thread) => {
                let thread = self.new_threads.remove(thread);
                if let Some(handle) = &thread.handle {
                    let waker = self.context.waker(component);
                    waker.set_thread(handle.thread().clone());
                }
                thread.send(WorkerCommand::Adopt(Box::new(unit)));
                thread
            }
            None => Thread::new(component, vec![unit], &name, &self.context),
        };
        thread.send(WorkerCommand::Release(self.context.now()));
        self.threads.push(thread);
    }

    fn vacate(&mut self, component: usize) {
        let thread = self.descriptors[component].thread;
        let Some(index) = self.threads.iter().position(|it| it.component == thread) else {
            return;
        };
        self.threads[index].send(WorkerCommand::Remove(component));
        if thread == component {
            let thread = self.threads.remove(index);
            self.ending.retain(|ending| !ending.is_finished());
            self.ending.extend(thread.handle);
        }
    }

    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.events.push(at, event);
    }

    fn handle(&self) -> Arc<dyn RunHandle> {
        Arc::new(self.context.clone())
    }

    fn schedule_injection(&mut self, at: Time, target: InjectionTarget, sample: Arc<dyn Sample>) {
        // samples for the same instant keep their order
        let position = self.planned.partition_point(|(other, ..)| *other > at);
        self.planned.insert(position, (at, target, sample));
        self.inject_planned();
    }

    /// Lets time pass: passes events to the observers and injects samples whose time has come.
    fn advance(&mut self, until: Time, mut watch: Option<Watch<'_>>) -> bool {
        if watch.is_some() {
            self.events.observe();
        }
        loop {
            self.inject_planned();
            if self.context.take_escalation() {
                self.stop_all();
            }
            let seen = self.notify_observers(&mut watch);
            let now = self.context.now();
            if seen || now >= until {
                return seen;
            }
            let next = self.planned.last().map_or(until, |(at, ..)| until.min(*at));
            self.events.wait(next.since(now).min(NAP));
        }
    }

    fn request_cycle(&mut self, component: usize) {
        self.context.waker(component).request_cycle();
    }

    fn change_timeout(&self) -> Duration {
        self.grace_period
    }

    /// An inspection does not wait for a long cycle.
    fn inspect_timeout(&self) -> Duration {
        NAP
    }

    fn submit(&mut self, component: usize, act: Act) {
        let thread = self.descriptors[component].thread;
        if let Some(thread) = self.threads.iter().find(|one| one.component == thread) {
            thread.send(WorkerCommand::Act(component, act));
        }
    }
}

/// Stops all components and ends the threads. A thread that does not end in time is detached.
impl Drop for Live {
    fn drop(&mut self) {
        self.sources = None;
        let late = self.stop_all();
        // afterwards, so that one-way calls of last cycles leave
        self.bus_thread = None;
        self.notify_observers(&mut None);
        self.context.end();
        for thread in &self.threads {
            thread.send(WorkerCommand::End);
        }
        let patience = if late.is_empty() {
            self.grace_period
        } else {
            NAP
        };
        let until = self.context.now() + patience;
        let handles = self.threads.iter().filter_map(|it| it.handle.as_ref());
        let handles = handles.chain(&self.ending);
        while handles.clone().any(|it| !it.is_finished()) && self.context.now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
