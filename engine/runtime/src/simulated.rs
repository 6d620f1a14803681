//! Simulated time: one thread, a virtual clock, a queue ordered by (time, declaration order).
//!
//! Runs of the same system are identical: only the pacer reads the real clock, and it only sleeps. Committed outputs
//! are delivered at once; a component they trigger runs at the same instant, after the writer.

mod cycle_order;
mod freeze;
mod handle;
mod pacer;
mod queue;
mod timeline;

use std::sync::Arc;
use std::time::Duration;

use asmotion_component::WorkPlace;
use asmotion_datum::Sample;
use asmotion_port::Time;

pub use self::pacer::Pace;
use self::pacer::Pacer;
use self::queue::{Due, DueWork};
use self::timeline::Timeline;
use crate::adapter::Adapter;
use crate::component_unit::ComponentUnit;
use crate::connections::ConnectionTable;
use crate::descriptor::ComponentDescriptor;
use crate::effects::Effects;
use crate::event::{Event, Observer};
use crate::handle::RunHandle;
use crate::health;
use crate::injection::{InjectionPorts, InjectionTarget};
use crate::peers::PeerTable;
use crate::run::{Act, Executor, Watch};
use crate::system::System;

/// A system in simulated time.
pub struct Simulation {
    units: Vec<ComponentUnit>,
    descriptors: Vec<ComponentDescriptor>,
    connections: ConnectionTable,
    peers: PeerTable,
    timeline: Timeline,
    injections: InjectionPorts,
    adapters: Vec<Box<dyn Adapter>>,
    pacer: Option<Pacer>,
}

impl System {
    /// Starts the system in simulated time: at time zero, configures every component, then starts those with
    /// `run_on_startup`. A component that fails is left as it is; its state and an
    /// [`Event::Fault`](crate::Event::Fault) show it.
    pub fn simulate(self) -> Simulation {
        Simulation::new(self)
    }
}

impl Simulation {
    fn new(mut system: System) -> Self {
        let descriptors = system.begin_run();
        let System {
            mut units,
            observers,
            topics,
            adapters,
            mut connections,
            peers,
            topics_outside,
            ..
        } = system;
        let injections = InjectionPorts::new(&mut units, &topics, &mut connections);
        let mut simulation = Self {
            timeline: Timeline::new(&units, observers),
            units,
            descriptors,
            connections,
            peers,
            injections,
            adapters,
            pacer: None,
        };
        simulation.start_up();
        if simulation.adapters.is_empty() {
            let now = simulation.timeline.now;
            let mut effects = simulation.timeline.effects(None);
            health::publish_without_bus(&topics, &mut simulation.injections, now, &mut effects);
        }
        simulation.connections.topics = topics;
        simulation.connections.topics_outside = topics_outside;
        simulation
    }

    /// Ties virtual time to real time from now on.
    pub fn set_pace(&mut self, pace: Pace) {
        self.pacer = match pace {
            Pace::Unlimited => None,
            Pace::Factor(factor) => Some(Pacer::new(self.timeline.now, factor)),
        };
    }

    /// Adds an observer, which receives all events from now on.
    pub fn observe(&mut self, observer: impl Observer + 'static) {
        self.timeline.observe(Box::new(observer));
    }

    /// Handles the next due item: a cycle, a deadline or an injected sample. Returns the new time, or `None` if nothing
    /// is due any more.
    pub fn step(&mut self) -> Option<Time> {
        self.take_external_input();
        let due = self.timeline.queue.pop()?;
        self.perform(due, None);
        Some(self.timeline.now)
    }

    /// Time of the next due item.
    pub fn next_due(&self) -> Option<Time> {
        self.timeline.queue.next()
    }

    /// Calls the adapters, and triggers the components that other threads have written to.
    fn take_external_input(&mut self) {
        let now = self.timeline.now;
        let mut effects = self.timeline.effects(None);
        effects.take_external_triggers();
        for adapter in &mut self.adapters {
            adapter.deliver(now, &mut effects);
        }
    }

    fn set_time(&mut self, at: Time) {
        if at <= self.timeline.now {
            return;
        }
        if let Some(pacer) = &self.pacer {
            pacer.wait(at);
        }
        self.timeline.set_now(at);
    }

    /// Handles one due item. Returns whether an event satisfied `watch`.
    fn perform(&mut self, due: Due, watch: Option<Watch<'_>>) -> bool {
        self.set_time(due.at);
        let mut effects = self.timeline.effects(watch);
        match due.work {
            DueWork::Sample { target, sample } => {
                self.injections
                    .inject(target, &sample, due.at, &mut effects);
            }
            DueWork::Deadline { component } => {
                self.units[component].process_replies(due.at, &mut effects);
            }
            DueWork::Trigger {
                component,
                generation,
            } => {
                let driven = &mut effects.timeline.schedules[component];
                if driven.generation == generation {
                    driven.triggered = false;
                    effects.cycle(&mut self.units, component);
                }
            }
            DueWork::Period {
                component,
                generation,
            } => {
                if effects.timeline.schedules[component].generation == generation {
                    effects.cycle(&mut self.units, component);
                    effects.schedule_next_period(&self.units[component], due.at, generation);
                }
            }
        }
        let seen = effects.seen;
        if std::mem::take(&mut self.timeline.escalated) {
            self.stop_all();
        }
        seen
    }
}

impl Executor for Simulation {
    fn clock(&self) -> Time {
        self.timeline.now
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

    /// Background work runs within the cycle.
    fn prepare(&mut self, _: usize) -> WorkPlace {
        WorkPlace::default()
    }

    fn run_for_new<R: Send + 'static>(
        &mut self,
        _: (usize, &str),
        work: impl FnOnce() -> R + Send + 'static,
        _: impl FnOnce(R) + Send + 'static,
    ) -> Option<R> {
        Some(work())
    }

    fn abandon_new(&mut self) {}

    fn has_threads(&self) -> bool {
        false
    }

    fn adopt(&mut self, mut unit: ComponentUnit) {
        unit.join(&self.peers);
        self.timeline.add(&unit);
        if unit.state().is_running() {
            self.timeline.schedule_first(&unit, Duration::ZERO);
        } else {
            self.timeline.apply_drive_change(&unit);
        }
        self.units.push(unit);
    }

    fn vacate(&mut self, component: usize) {
        self.peers.remove(component);
        self.units[component] = ComponentUnit::vacant(component);
        self.timeline.vacate(component);
    }

    fn emit(&mut self, at: Time, event: &Event<'_>) {
        self.timeline.effects(None).emit(at, event);
    }

    fn handle(&self) -> Arc<dyn RunHandle> {
        self.timeline.run_handle()
    }

    fn schedule_injection(&mut self, at: Time, target: InjectionTarget, sample: Arc<dyn Sample>) {
        let at = at.max(self.timeline.now);
        self.timeline
            .queue
            .push(at, DueWork::Sample { target, sample });
    }

    /// Handles all items due up to a time. Returns whether an event satisfied `watch`.
    fn advance(&mut self, until: Time, mut watch: Option<Watch<'_>>) -> bool {
        loop {
            self.take_external_input();
            let Some(due) = self.timeline.queue.pop_until(until) else {
                break;
            };
            let watch = watch.as_mut().map(Watch::reborrow);
            if self.perform(due, watch) {
                return true;
            }
        }
        self.set_time(until);
        false
    }

    fn request_cycle(&mut self, component: usize) {
        let now = self.timeline.now;
        self.timeline.trigger(component, now);
    }

    /// Unlimited: no cycle is ever under way between two steps.
    fn change_timeout(&self) -> Duration {
        Duration::MAX
    }

    fn inspect_timeout(&self) -> Duration {
        Duration::MAX
    }

    fn submit(&mut self, component: usize, act: Act) {
        let now = self.timeline.now;
        let mut effects = self.timeline.effects(None);
        let unit = &mut self.units[component];
        let ran = unit.state().is_running();
        act(unit, now, &mut effects);
        if !ran && unit.state().is_running() {
            self.timeline.schedule_first(unit, Duration::ZERO)
        } else {
            self.timeline.apply_drive_change(unit)
        }
    }
}

/// Marks the run as ended for readers and writers on other threads.
impl Drop for Simulation {
    fn drop(&mut self) {
        self.timeline.end();
    }
}
