//! Live: absolute deadlines on a monotonic clock, with threads for components that need one, and executor threads for the others.
//!
//! A component and its slaves form a group. A group with real-time demands ([`Activity::thread_use`]) has a thread of its own; all
//! others take turns in a few [executor threads](executor_threads). A group sleeps until its period has passed or new data
//! arrive; it never waits for another component.
//!
//! [`Activity::thread_use`]: asmotion_component::Activity::thread_use
//! Events reach the observers through a bounded queue, which is drained while the owner of the run lets time pass.

mod bus_thread;
mod executor_threads;
mod group;
mod schedule;
mod seat_schedule;
mod worker;

use std::collections::BTreeMap;
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_component::{CycleRequests, ThreadUse, WorkPlace};
use asmotion_datum::Sample;
use asmotion_port::Time;

use self::bus_thread::BusThread;
use self::executor_threads::ExecutorThreads;
use self::group::{ComponentGroup, WorkerCommand};
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::context::{EventQueue, LiveContext, WakeTarget};
use crate::descriptor::ComponentDescriptor;
use crate::event::{Event, Observer};
use crate::handle::RunHandle;
use crate::health;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::peers::PeerTable;
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
    peers: PeerTable,
    /// The groups, each with the component that is not a slave.
    groups: Vec<LiveGroup>,
    /// Run the groups without a thread of their own.
    executor: ExecutorThreads,
    /// Threads of components whose addition is not certain yet.
    new_threads: Vec<LiveGroup>,
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

/// A component and its slaves, as the run's owner sees them.
struct LiveGroup {
    /// Position of the component that is not a slave.
    component: usize,
    commands: mpsc::Sender<WorkerCommand>,
    /// What receives the commands; `None` if its thread could not be started.
    target: Option<WakeTarget>,
    /// The group's own thread; `None` among the executor threads.
    thread: Option<JoinHandle<()>>,
}

impl System {
    /// Starts the system in real time. Components without real-time demands share a few executor threads; each of the others has a
    /// thread, as its [`thread_use`](asmotion_component::Activity::thread_use) says.
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
        let mut descriptors = system.begin_run();
        let System {
            mut units,
            observers,
            topics,
            adapters,
            notifier,
            sinks,
            streams,
            mut connections,
            peers,
            topics_outside,
            ..
        } = system;
        let injections = InjectionPorts::new(&mut units, &topics, &mut connections);
        let events = Arc::new(EventQueue::new());
        for observer in &observers {
            events.observe(observer.reports());
        }
        let context = LiveContext::new(Instant::now(), units.len(), Arc::clone(&events));
        for unit in &mut units {
            unit.body.work_place = work_place(&context, unit.index);
            unit.body.inputs.iter_mut().for_each(|it| it.reserve());
        }
        let executor = ExecutorThreads::new(context.clone());
        let mut live = Self {
            groups: start_groups(units, &mut descriptors, &context, &executor),
            executor,
            new_threads: Vec::new(),
            ending: Vec::new(),
            context,
            events,
            observers,
            descriptors,
            connections,
            peers,
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
        live.connections.topics = topics;
        live.connections.topics_outside = topics_outside;
        live.release();
        live
    }

    /// Begins the cycles of all components at the same time.
    fn release(&mut self) {
        let now = self.context.now();
        for group in &self.groups {
            group.send(WorkerCommand::Release(now));
        }
    }

    /// Adds an observer, which receives all events from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.events.observe(observer.reports());
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
                seen |= (watch.predicate)(at, event);
            }
        });
        seen
    }
}

/// The threads of a component's background work.
fn work_place(context: &LiveContext, component: usize) -> WorkPlace {
    let waker = context.waker(component);
    // request a cycle whatever drives the component: a periodic one would otherwise pass the result on a period late
    let lender = Arc::clone(&waker);
    WorkPlace::Thread(CycleRequests {
        wake: Arc::new(move || waker.request_cycle()),
        lend_thread: Arc::new(move || lender.lend_thread()),
    })
}

/// Starts the group of each component that is not a slave; its slaves follow in order of addition.
fn start_groups(
    units: Vec<ComponentUnit>,
    descriptors: &mut [ComponentDescriptor],
    context: &LiveContext,
    executor: &ExecutorThreads,
) -> Vec<LiveGroup> {
    let mut groups: BTreeMap<usize, Vec<ComponentUnit>> = BTreeMap::new();
    for unit in units {
        let component = descriptors[unit.index].thread;
        groups.entry(component).or_default().push(unit);
    }
    let start = |(component, group): (usize, Vec<ComponentUnit>)| {
        let needs = |it: &ComponentUnit| it.activity.thread_use() == ThreadUse::Own;
        if !group.iter().any(needs) {
            return LiveGroup::shared(component, group, context, executor);
        }
        for unit in &group {
            descriptors[unit.index].thread_use = ThreadUse::Own;
        }
        let name = Arc::clone(&descriptors[component].name);
        LiveGroup::alone(component, group, &name, context)
    };
    groups.into_iter().map(start).collect()
}

impl LiveGroup {
    /// Starts a group in a thread of its own. Without components, it waits for one to be adopted.
    fn alone(
        component: usize,
        units: Vec<ComponentUnit>,
        name: &str,
        context: &LiveContext,
    ) -> Self {
        let (commands, queue) = mpsc::channel();
        let members: Vec<usize> = units.iter().map(|unit| unit.index).collect();
        let group = ComponentGroup::new(units, queue, context.clone());
        let builder = std::thread::Builder::new().name(name.to_owned());
        let in_thread = context.clone();
        let thread = builder.spawn(move || worker::run(group, in_thread)).ok();
        let handle = thread.as_ref().map(JoinHandle::thread);
        let target = |thread: &std::thread::Thread| WakeTarget::Thread(thread.clone());
        for member in members {
            if let Some(thread) = handle {
                context.waker(member).set_target(target(thread));
            }
        }
        Self {
            component,
            commands,
            target: handle.map(target),
            thread,
        }
    }

    /// Starts a group among the executor threads.
    fn shared(
        component: usize,
        units: Vec<ComponentUnit>,
        context: &LiveContext,
        executor: &ExecutorThreads,
    ) -> Self {
        let (commands, queue) = mpsc::channel();
        let members: Vec<usize> = units.iter().map(|unit| unit.index).collect();
        let seat = executor.add(ComponentGroup::new(units, queue, context.clone()));
        for member in members {
            context.waker(member).set_target(executor.target(seat));
        }
        Self {
            component,
            commands,
            target: Some(executor.target(seat)),
            thread: None,
        }
    }

    fn send(&self, command: WorkerCommand) {
        // fails if the group has ended, in which case there is nothing left to do
        let _ = self.commands.send(command);
        if let Some(target) = &self.target {
            target.wake();
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

    fn peers(&self) -> &PeerTable {
        &self.peers
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
                let thread = LiveGroup::alone(component, Vec::new(), name, &self.context);
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
            self.ending.extend(thread.thread);
        }
    }

    fn adopt(&mut self, mut unit: ComponentUnit) {
        unit.join(&self.peers);
        unit.body.inputs.iter_mut().for_each(|it| it.reserve());
        let (component, name) = (unit.index, Arc::clone(&unit.name));
        let mut threads = self.new_threads.iter();
        let prepared = threads.position(|it| it.component == component);
        let prepared = prepared.map(|it| self.new_threads.remove(it));
        let group = match (unit.activity.thread_use(), prepared) {
            (ThreadUse::Own, Some(group)) => {
                if let Some(handle) = &group.thread {
                    let target = WakeTarget::Thread(handle.thread().clone());
                    self.context.waker(component).set_target(target);
                }
                group.send(WorkerCommand::Adopt(Box::new(unit)));
                group
            }
            (ThreadUse::Own, None) => LiveGroup::alone(component, vec![unit], &name, &self.context),
            (ThreadUse::Shared, prepared) => {
                if let Some(prepared) = prepared {
                    prepared.send(WorkerCommand::End);
                    self.ending.extend(prepared.thread);
                }
                LiveGroup::shared(component, vec![unit], &self.context, &self.executor)
            }
        };
        group.send(WorkerCommand::Release(self.context.now()));
        self.groups.push(group);
    }

    fn vacate(&mut self, component: usize) {
        self.peers.remove(component);
        let thread = self.descriptors[component].thread;
        let Some(index) = self.groups.iter().position(|it| it.component == thread) else {
            return;
        };
        self.groups[index].send(WorkerCommand::Remove(component));
        if thread == component {
            let group = self.groups.remove(index);
            self.ending.retain(|ending| !ending.is_finished());
            self.ending.extend(group.thread);
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
        if let Some(watch) = &watch {
            self.events.observe(watch.reports);
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
        // in order of addition
        let found = self.groups.binary_search_by_key(&thread, |it| it.component);
        if let Ok(group) = found {
            self.groups[group].send(WorkerCommand::Act(component, act));
        }
    }

    fn has_threads(&self) -> bool {
        true
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
        for group in &self.groups {
            group.send(WorkerCommand::End);
        }
        self.executor.end();
        let patience = if late.is_empty() {
            self.grace_period
        } else {
            NAP
        };
        let until = self.context.now() + patience;
        let handles = self.groups.iter().filter_map(|it| it.thread.as_ref());
        let handles = handles.chain(&self.ending);
        let are_finished =
            || handles.clone().all(JoinHandle::is_finished) && self.executor.are_finished();
        while !are_finished() && self.context.now() < until {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
