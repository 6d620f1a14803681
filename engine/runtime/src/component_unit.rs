//! A unit: a component with its runtime state, its life cycle and its cycles. Executors drive units.

mod freeze;
mod remove;
mod replace;
mod timing;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asmotion_component::{
    Activity, AwaitedWriters, Component, Cycle, Drive, Fault, LifeCycleError, OnException,
    PropertyError, Setup, State, Transition, guarded,
};
use asmotion_datum::Datum;
use asmotion_port::{Time, prefetch};

pub(crate) use self::freeze::FrozenUnit;
pub use self::remove::REMOVAL_REPORT;
pub(crate) use self::replace::NewComponent;
pub use self::replace::REPLACEMENT_REPORT;
use crate::component_body::{ComponentBody, CycleBody};
use crate::descriptor::{ComponentDescriptor, ComponentStatus};
use crate::effects::{ComponentEffects, Effects};
use crate::event::Event;
use crate::peers::PeerTable;
use crate::service::Admission;

/// Time from the reset of an event-driven component after a fault to its next cycle.
const RESET_PAUSE: Duration = Duration::from_millis(100);

/// A component that an executor drives.
pub(crate) struct ComponentUnit {
    pub name: Arc<str>,
    /// Position in the system.
    pub index: usize,
    pub activity: Activity,
    /// Position of the component in whose thread, and after which, this one cycles; `None` unless it is a slave.
    pub master: Option<usize>,
    pub body: ComponentBody,
    component: Box<dyn Component>,
    state: State,
    /// The last cycle failed; cleared by `restart_after_fault`.
    has_faulted: bool,
    /// Number of restarts after a fault.
    resets: u32,
    status: Arc<ComponentStatus>,
}

impl ComponentUnit {
    pub(crate) fn new(
        name: Arc<str>,
        index: usize,
        activity: Activity,
        component: Box<dyn Component>,
        body: ComponentBody,
    ) -> Self {
        Self {
            name,
            index,
            activity,
            master: None,
            body,
            component,
            state: State::Init,
            has_faulted: false,
            resets: 0,
            status: Arc::new(ComponentStatus::new(State::Init)),
        }
    }

    /// Called when an executor takes over the system.
    pub(crate) fn begin_run(&mut self) {
        self.state = State::PreOperational;
        self.status.set_state(self.state);
        self.set_drive(self.activity.drive);
    }

    /// The part of the component that other threads see.
    pub(crate) fn descriptor(&self, thread: usize) -> ComponentDescriptor {
        let services = self.body.services.iter();
        let references = self.body.references.iter();
        let wired = references.map(|reference| {
            let wirings = reference.wirings.iter();
            wirings.map(|it| (it.to.clone(), it.wire)).collect()
        });
        ComponentDescriptor {
            name: Arc::clone(&self.name),
            declaration: Arc::clone(&self.body.declaration),
            thread,
            master: self.master,
            openers: self
                .body
                .inputs
                .iter()
                .map(|input| input.opener())
                .collect(),
            queues: services.map(|service| Arc::clone(&service.queue)).collect(),
            wired: wired.collect(),
            configure_on_startup: self.activity.configure_on_startup,
            run_on_startup: self.activity.run_on_startup,
            may_interrupt: self.activity.may_interrupt,
            thread_use: self.activity.thread_use(),
            awaited_writers: self.component.awaited_writers(),
            status: Arc::clone(&self.status),
            cause: Arc::clone(&self.body.cause),
        }
    }

    /// Adds the component to the table of its system, which its cycles read from now on.
    pub(crate) fn join(&mut self, peers: &PeerTable) {
        let (name, status) = (Arc::clone(&self.name), Arc::clone(&self.status));
        peers.insert(self.index, name, status);
        self.body.peers = peers.clone();
    }

    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// Prefetches memory that the next cycle uses. Called with `depth` 0 to 4, each one or more cycles of other components after
    /// the one before, so that the pointers that it follows are in the caches.
    pub(crate) fn prefetch(&self, depth: usize) {
        match depth {
            0 => prefetch(self),
            1 => {
                prefetch(&*self.component);
                prefetch(&*self.status);
                self.body.prefetch_lists();
            }
            _ => {
                self.component.prefetch(depth - 1);
                self.body.prefetch_ports(depth - 2);
            }
        }
    }

    /// The component's description of its internal state; empty before it is configured, or if the description fails.
    pub(crate) fn inspect(&self) -> Vec<(String, Datum)> {
        if !self.state.is_configured() {
            return Vec::new();
        }
        guarded(|| Ok(self.component.inspect())).unwrap_or_default()
    }

    /// Runs one cycle: freeze, compute, commit all or nothing. A component that does not run only applies changed
    /// properties.
    pub(crate) fn cycle(&mut self, now: Time, effects: &mut dyn Effects) {
        let mut own = component_effects(&self.name, self.index, now, effects);
        self.body.apply(&mut own);
        if !self.state.is_running() {
            return self.serve(now, effects);
        }
        let refused = self.body.freeze(&mut own);
        self.status.add_refused(refused);
        self.run_frozen(now, effects);
    }

    /// Runs one cycle with the inputs that have been frozen.
    fn run_frozen(&mut self, now: Time, effects: &mut dyn Effects) {
        let number = self.status.cycles.fetch_add(1, Ordering::Relaxed) + 1;
        let mut own = component_effects(&self.name, self.index, now, effects);
        own.emit(&Event::Cycle {
            component: &self.name,
            number,
        });
        match self.compute(now, number, effects) {
            Ok(error) => self.commit(error, now, effects),
            Err(fault) => self.fail(fault, now, effects),
        }
    }

    /// Runs the component's own code. `Ok` contains an error that the component has reported, if any.
    fn compute(
        &mut self,
        now: Time,
        number: u64,
        effects: &dyn Effects,
    ) -> Result<Option<Fault>, Fault> {
        let Self {
            component,
            body,
            status,
            state,
            ..
        } = self;
        guarded(|| {
            let mut host = CycleBody {
                body,
                status,
                observers: effects,
            };
            let mut cycle = Cycle::new(&mut host, now, number);
            if *state == State::RunTimeError {
                component.recover(&mut cycle)?;
            } else {
                component.update(&mut cycle)?;
            }
            cycle.finish()
        })
    }

    /// Runs one more cycle of a component that passes on the last samples of [others](Component::awaited_writers), if any have
    /// arrived since its last cycle.
    fn take_last_samples(&mut self, now: Time, effects: &mut dyn Effects) {
        match self.component.awaited_writers() {
            AwaitedWriters::None => return,
            AwaitedWriters::Safe | AwaitedWriters::All => {}
        }
        let mut own = component_effects(&self.name, self.index, now, effects);
        let refused = self.body.freeze(&mut own);
        self.status.add_refused(refused);
        if self.body.has_new_inputs() {
            self.run_frozen(now, effects);
            // a component that stops is not restarted
            self.has_faulted = false;
        }
    }

    /// Answers the requests that a stopped component takes. Not a cycle: neither counted nor reported as one.
    fn serve(&mut self, now: Time, effects: &mut dyn Effects) {
        let mut own = component_effects(&self.name, self.index, now, effects);
        if self.state != State::Stopped || !self.body.freeze_requests(&mut own) {
            return;
        }
        let Self {
            component,
            body,
            status,
            ..
        } = self;
        let number = status.cycles.load(Ordering::Relaxed);
        let observers: &dyn Effects = effects;
        let served = guarded(|| {
            let mut host = CycleBody {
                body,
                status,
                observers,
            };
            let mut cycle = Cycle::stopped(&mut host, now, number);
            component.serve(&mut cycle)?;
            cycle.finish()
        });
        let allowed = self.body.refuse_commands();
        match served.and_then(|error| error.map_or(allowed, Err)) {
            Err(fault) => self.fail(fault, now, effects),
            Ok(()) => {
                let mut drive = self.activity.drive;
                let mut own = component_effects(&self.name, self.index, now, effects);
                let set_period = |period| drive = drive.with_period(period);
                // cannot fail: nothing is written
                let _ = self.body.commit(&mut own, set_period);
                self.status
                    .add_refused(std::mem::take(&mut self.body.refused));
                self.body.later.forget();
                self.set_drive(drive);
            }
        }
    }

    /// Returns whether the component is stopped and answers operations nevertheless.
    pub(crate) fn serves_while_stopped(&self) -> bool {
        self.state == State::Stopped && self.body.serves_while_stopped()
    }

    fn commit(&mut self, error: Option<Fault>, now: Time, effects: &mut dyn Effects) {
        let mut drive = self.activity.drive;
        let committed = self.body.commit(
            &mut component_effects(&self.name, self.index, now, effects),
            |period| drive = drive.with_period(period),
        );
        self.status
            .add_refused(std::mem::take(&mut self.body.refused));
        self.set_drive(drive);
        match error.or(committed.err()) {
            Some(fault) => {
                self.record_fault(fault, now, effects);
                self.set_state(State::RunTimeError, now, effects);
            }
            None => self.set_state(State::Running, now, effects),
        }
    }

    /// Handles an exception (RTT `exception`): discards the cycle, stops the component and cleans it up.
    pub(crate) fn fail(&mut self, fault: Fault, now: Time, effects: &mut dyn Effects) {
        if self.state == State::FatalError {
            return;
        }
        let mut own = component_effects(&self.name, self.index, now, effects);
        self.body.discard(&mut own);
        self.record_fault(fault, now, effects);
        let before = self.state;
        self.has_faulted |= before.is_running();
        self.set_state(State::Exception, now, effects);
        let stopped = if before.is_running() {
            self.last_cycle(now, effects)
        } else {
            Ok(())
        };
        let component = &mut self.component;
        let tidied = guarded(|| {
            if before.is_configured() {
                component.cleanup();
            }
            component.exception();
            Ok(())
        });
        self.close(now, effects);
        if let Err(fault) = stopped.and(tidied) {
            self.record_fault(fault, now, effects);
            self.set_state(State::FatalError, now, effects);
        }
    }

    /// Runs the component's `stop` hook as its last cycle, then writes the safe samples of its outputs. If the hook
    /// panics, only the safe samples leave.
    fn last_cycle(&mut self, now: Time, effects: &mut dyn Effects) -> Result<(), Fault> {
        let Self {
            component,
            body,
            status,
            name,
            ..
        } = self;
        let number = status.cycles.load(Ordering::Relaxed);
        let observers: &dyn Effects = effects;
        let stopped = guarded(|| {
            let mut host = CycleBody {
                body,
                status,
                observers,
            };
            let mut cycle = Cycle::new(&mut host, now, number);
            component.stop(&mut cycle);
            cycle.finish()
        });
        let mut own = component_effects(name, self.index, now, effects);
        if stopped.is_err() {
            body.discard(&mut own);
        }
        body.write_safe_samples();
        // a period set here would have no effect
        let committed = body.commit(&mut own, |_| {});
        status.add_refused(std::mem::take(&mut body.refused));
        let reported = stopped?;
        reported.map_or(committed, Err)
    }

    /// Restarts the component after a failed cycle if its activity says so. Returns whether it runs again.
    pub(crate) fn restart_after_fault(&mut self, now: Time, effects: &mut dyn Effects) -> bool {
        if !std::mem::take(&mut self.has_faulted) {
            return false;
        }
        match self.activity.on_exception {
            OnException::Stop => false,
            OnException::Escalate => {
                effects.escalate(self.index);
                false
            }
            OnException::Reset
                if self
                    .activity
                    .max_resets
                    .is_some_and(|max| self.resets >= max) =>
            {
                false
            }
            OnException::Reset => {
                self.resets += 1;
                let transitions = [
                    Transition::ResetException,
                    Transition::Configure,
                    Transition::Start,
                ];
                // a failure on the way shows in the state and in events
                transitions
                    .iter()
                    .all(|step| self.transition(*step, now, effects).is_ok())
            }
        }
    }

    /// Time from a reset after a fault to the next cycle. What made the cycle fail may still be there, and would use up all
    /// resets in one instant.
    pub(crate) fn reset_pause(&self) -> Duration {
        self.activity.drive.period().unwrap_or(RESET_PAUSE)
    }

    /// Makes a transition of the life cycle, if RTT's guards allow it.
    pub(crate) fn transition(
        &mut self,
        transition: Transition,
        now: Time,
        effects: &mut dyn Effects,
    ) -> Result<(), LifeCycleError> {
        if transition == Transition::Stop && self.state.is_running() {
            self.take_last_samples(now, effects);
        }
        let Some(target) = transition.target(self.state) else {
            return Err(LifeCycleError::Refused {
                component: self.name.to_string(),
                transition,
                state: self.state,
            });
        };
        self.status.set_target(target);
        match self.run_hook(transition, now, effects) {
            Ok(()) => {
                if transition == Transition::Start {
                    let mut own = component_effects(&self.name, self.index, now, effects);
                    self.body.discard_commands(&mut own);
                }
                self.complete_transition(transition, target, now, effects);
                Ok(())
            }
            Err(fault) => {
                self.handle_failed_hook(transition, &fault, now, effects);
                Err(LifeCycleError::Failed {
                    component: self.name.to_string(),
                    transition,
                    fault,
                })
            }
        }
    }

    /// Runs the component's hook of a transition.
    fn run_hook(
        &mut self,
        transition: Transition,
        now: Time,
        effects: &mut dyn Effects,
    ) -> Result<(), Fault> {
        let Self {
            component,
            body,
            name,
            ..
        } = self;
        body.apply(&mut component_effects(name, self.index, now, effects));
        if transition == Transition::Stop {
            return self.last_cycle(now, effects);
        }
        guarded(|| match transition {
            Transition::Configure => {
                let work_place = body.work_place.clone();
                let mut setup = Setup::new(body, name).with_work_place(work_place);
                component.configure(&mut setup)?;
                setup.finish()
            }
            Transition::Start => component.start(),
            Transition::Cleanup => {
                component.cleanup();
                Ok(())
            }
            Transition::Stop | Transition::Recover | Transition::ResetException => Ok(()),
        })
    }

    fn complete_transition(
        &mut self,
        transition: Transition,
        target: State,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        if transition == Transition::Start {
            self.status.interrupt.store(false, Ordering::Relaxed);
        }
        let admission = if target.is_running() {
            Admission::All
        } else if target.is_configured() {
            Admission::WhileStopped
        } else {
            Admission::None
        };
        let mut own = component_effects(&self.name, self.index, now, effects);
        self.body.admit(admission, &mut own);
        if transition == Transition::Stop {
            self.body.abandon_calls(&mut own);
            self.body.later.forget();
        }
        self.set_state(target, now, effects);
        if transition == Transition::Stop {
            // requests that waited for a cycle
            self.serve(now, effects);
        }
    }

    /// Handles a hook that failed: a panic is an exception; after an error the component stays in the state that RTT
    /// prescribes.
    fn handle_failed_hook(
        &mut self,
        transition: Transition,
        fault: &Fault,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        if matches!(fault, Fault::Panicked(_)) {
            return self.fail(fault.clone(), now, effects);
        }
        self.record_fault(fault.clone(), now, effects);
        let to = match transition {
            Transition::Configure => State::PreOperational,
            Transition::Start
            | Transition::Stop
            | Transition::Cleanup
            | Transition::Recover
            | Transition::ResetException => self.state,
        };
        if !to.is_configured() {
            let mut own = component_effects(&self.name, self.index, now, effects);
            self.body.admit(Admission::None, &mut own);
        }
        self.set_state(to, now, effects);
    }

    /// Closes the services and cancels the calls of a component that has failed.
    fn close(&mut self, now: Time, effects: &mut dyn Effects) {
        let mut own = component_effects(&self.name, self.index, now, effects);
        self.body.admit(Admission::None, &mut own);
        self.body.abandon_calls(&mut own);
        self.body.later.forget();
    }

    fn set_state(&mut self, to: State, now: Time, effects: &mut dyn Effects) {
        let from = std::mem::replace(&mut self.state, to);
        self.status.set_state(to);
        if from != to {
            let component = &self.name;
            effects.emit(
                now,
                &Event::LifeCycle {
                    component,
                    from,
                    to,
                },
            );
        }
    }

    /// Stores a fault and reports it to the observers.
    pub(crate) fn record_fault(&mut self, fault: Fault, now: Time, effects: &mut dyn Effects) {
        effects.emit(
            now,
            &Event::Fault {
                component: &self.name,
                fault: &fault,
            },
        );
        *self.status.fault() = Some(fault);
    }

    /// Changes the period of a periodic or event-driven component; zero makes it event-driven.
    pub(crate) fn set_period(&mut self, period: Duration) {
        self.set_drive(self.activity.drive.with_period(period));
    }

    fn set_drive(&mut self, drive: Drive) {
        self.activity.drive = drive;
        self.status.set_period(drive.period().unwrap_or_default());
    }

    /// Removes a service from a reference.
    pub(crate) fn unwire(
        &mut self,
        reference: usize,
        service: &str,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        let mut effects = component_effects(&self.name, self.index, now, effects);
        self.body.unwire(reference, service, &mut effects);
    }

    /// Ends calls that have timed out, and triggers the component if the cycle that it has requested is due. Returns whether
    /// any result waits for the next cycle.
    pub(crate) fn process_replies(&mut self, now: Time, effects: &mut dyn Effects) -> bool {
        let mut effects = component_effects(&self.name, self.index, now, effects);
        let body = &mut self.body;
        body.trigger_later(&mut effects);
        body.caller.process_replies(&body.references, &mut effects)
    }

    /// Sets properties, all or none: at the beginning of the next cycle, or at once if the component does not run.
    pub(crate) fn set_properties(
        &mut self,
        values: &[(String, Datum)],
        now: Time,
        effects: &mut dyn Effects,
    ) -> Result<(), PropertyError> {
        self.body.prepare(&self.name, values)?;
        if !self.state.is_running() {
            self.body
                .apply(&mut component_effects(&self.name, self.index, now, effects));
        }
        Ok(())
    }
}

fn component_effects<'a>(
    name: &'a Arc<str>,
    component: usize,
    now: Time,
    effects: &'a mut dyn Effects,
) -> ComponentEffects<'a> {
    ComponentEffects {
        now,
        component,
        name,
        effects,
    }
}
