//! A unit: a component with its runtime state, taken through its life and its cycles. Executors drive units.

mod timing;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asmotion_datum::Datum;

use crate::body::Body;
use crate::face::{Face, Status};
use crate::fault::guarded;
use crate::outside::{Leaving, Outside};
use crate::property::PropertyError;
use crate::{
    Activity, Component, Cycle, Drive, Event, Fault, LifeCycleError, OnException, Setup, State,
    Time, Transition,
};

/// A component that an executor drives.
pub(crate) struct Unit {
    pub name: Arc<str>,
    /// Its place in the system.
    pub index: usize,
    pub activity: Activity,
    /// In whose thread, and after whom, it cycles.
    pub master: Option<usize>,
    pub body: Body,
    component: Box<dyn Component>,
    state: State,
    /// It has failed in the last cycle.
    fell: bool,
    /// How often it has been brought back.
    resets: u32,
    status: Arc<Status>,
}

impl Unit {
    pub(crate) fn new(
        name: Arc<str>,
        index: usize,
        activity: Activity,
        component: Box<dyn Component>,
        body: Body,
    ) -> Self {
        Self {
            name,
            index,
            activity,
            master: None,
            body,
            component,
            state: State::Init,
            fell: false,
            resets: 0,
            status: Arc::new(Status::new(State::Init)),
        }
    }

    /// Its system begins to run: an executor has it.
    pub(crate) fn take_up(&mut self) {
        self.state = State::PreOperational;
        self.status.enter(self.state);
        self.set_drive(self.activity.drive);
    }

    /// What everybody may know of it.
    pub(crate) fn face(&self, thread: usize) -> Face {
        let services = self.body.services.iter();
        Face {
            name: Arc::clone(&self.name),
            declaration: self.body.declaration.clone(),
            thread,
            inlets: (self.body.inputs.iter())
                .map(|input| input.inlet())
                .collect(),
            inboxes: services.map(|service| Arc::clone(&service.inbox)).collect(),
            configure_on_startup: self.activity.configure_on_startup,
            run_on_startup: self.activity.run_on_startup,
            may_interrupt: self.activity.may_interrupt,
            status: Arc::clone(&self.status),
        }
    }

    pub(crate) fn state(&self) -> State {
        self.state
    }

    /// One cycle: freeze, compute, commit all or nothing. A unit that is not running only takes in its properties.
    pub(crate) fn cycle(&mut self, now: Time, outside: &mut dyn Outside) {
        let mut leaving = leaving(&self.name, self.index, now, outside);
        self.body.apply(&mut leaving);
        if !self.state.is_running() {
            return;
        }
        self.body.freeze(&mut leaving);
        let number = self.status.cycles.fetch_add(1, Ordering::Relaxed) + 1;
        leaving.emit(&Event::Cycle {
            component: &self.name,
            number,
        });
        match self.compute(now, number) {
            Ok(error) => self.commit(error, now, outside),
            Err(fault) => self.fail(fault, now, outside),
        }
    }

    /// Runs the component's own code. `Ok` may carry an error that the component has reported.
    fn compute(&mut self, now: Time, number: u64) -> Result<Option<Fault>, Fault> {
        let Self {
            component,
            body,
            status,
            state,
            ..
        } = self;
        guarded(|| {
            let mut cycle = Cycle::new(body, now, number, status);
            if *state == State::RunTimeError {
                component.recover(&mut cycle)?;
            } else {
                component.update(&mut cycle)?;
            }
            cycle.finish()
        })
    }

    fn commit(&mut self, error: Option<Fault>, now: Time, outside: &mut dyn Outside) {
        let mut drive = self.activity.drive;
        let committed = self.body.commit(
            &mut leaving(&self.name, self.index, now, outside),
            |period| drive = drive.with_period(period),
        );
        self.set_drive(drive);
        match error.or(committed.err()) {
            Some(fault) => {
                self.note(fault, now, outside);
                self.enter(State::RunTimeError, now, outside);
            }
            None => self.enter(State::Running, now, outside),
        }
    }

    /// An exception (RTT `exception`): nothing of the cycle leaves, the component is stopped and cleaned up.
    pub(crate) fn fail(&mut self, fault: Fault, now: Time, outside: &mut dyn Outside) {
        if self.state == State::FatalError {
            return;
        }
        self.body.discard();
        self.note(fault, now, outside);
        let before = self.state;
        self.fell |= before.is_running();
        self.enter(State::Exception, now, outside);
        let component = &mut self.component;
        let tidied = guarded(|| {
            if before.is_running() {
                component.stop();
            }
            if before.is_configured() {
                component.cleanup();
            }
            component.exception();
            Ok(())
        });
        self.close(now, outside);
        if let Err(fault) = tidied {
            self.note(fault, now, outside);
            self.enter(State::FatalError, now, outside);
        }
    }

    /// After a cycle: a component that has failed is brought back, if its activity says so. Says whether it runs again.
    pub(crate) fn come_back(&mut self, now: Time, outside: &mut dyn Outside) -> bool {
        if !std::mem::take(&mut self.fell) {
            return false;
        }
        match self.activity.on_exception {
            OnException::Stop => false,
            OnException::Escalate => {
                outside.escalate(self.index);
                false
            }
            OnException::Reset
                if (self.activity.max_resets).is_some_and(|max| self.resets >= max) =>
            {
                false
            }
            OnException::Reset => {
                self.resets += 1;
                let way = [
                    Transition::ResetException,
                    Transition::Configure,
                    Transition::Start,
                ];
                // What fails on the way is in its state and told to the observers.
                way.iter()
                    .all(|step| self.transition(*step, now, outside).is_ok())
            }
        }
    }

    /// Takes the component through a transition, where RTT's guards allow it.
    pub(crate) fn transition(
        &mut self,
        transition: Transition,
        now: Time,
        outside: &mut dyn Outside,
    ) -> Result<(), LifeCycleError> {
        let Some(target) = transition.target(self.state) else {
            return Err(LifeCycleError::Refused {
                component: self.name.to_string(),
                transition,
                state: self.state,
            });
        };
        self.status.aim(target);
        match self.hook(transition, now, outside) {
            Ok(()) => {
                self.arrive(transition, target, now, outside);
                Ok(())
            }
            Err(fault) => {
                self.refuse(transition, &fault, now, outside);
                Err(LifeCycleError::Failed {
                    component: self.name.to_string(),
                    transition,
                    fault,
                })
            }
        }
    }

    /// Runs the component's hook of a transition.
    fn hook(
        &mut self,
        transition: Transition,
        now: Time,
        outside: &mut dyn Outside,
    ) -> Result<(), Fault> {
        let Self {
            component,
            body,
            name,
            ..
        } = self;
        body.apply(&mut leaving(name, self.index, now, outside));
        guarded(|| match transition {
            Transition::Configure => {
                let mut setup = Setup::new(body, name);
                component.configure(&mut setup)?;
                setup.finish()
            }
            Transition::Start => component.start(),
            Transition::Stop => {
                component.stop();
                Ok(())
            }
            Transition::Cleanup => {
                component.cleanup();
                Ok(())
            }
            Transition::Recover | Transition::ResetException => Ok(()),
        })
    }

    fn arrive(
        &mut self,
        transition: Transition,
        target: State,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        match transition {
            Transition::Start => {
                self.status.interrupt.store(false, Ordering::Relaxed);
                self.body.open();
            }
            Transition::Stop => self.close(now, outside),
            Transition::Configure
            | Transition::Cleanup
            | Transition::Recover
            | Transition::ResetException => {}
        }
        self.enter(target, now, outside);
    }

    /// A hook failed: a panic is an exception; otherwise the component stays where RTT leaves it.
    fn refuse(
        &mut self,
        transition: Transition,
        fault: &Fault,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        if matches!(fault, Fault::Panicked(_)) {
            return self.fail(fault.clone(), now, outside);
        }
        self.note(fault.clone(), now, outside);
        let to = match transition {
            Transition::Configure => State::PreOperational,
            Transition::Start
            | Transition::Stop
            | Transition::Cleanup
            | Transition::Recover
            | Transition::ResetException => self.state,
        };
        self.enter(to, now, outside);
    }

    /// Whoever waits for the component learns that it does not run.
    fn close(&mut self, now: Time, outside: &mut dyn Outside) {
        (self.body).close(&mut leaving(&self.name, self.index, now, outside));
    }

    fn enter(&mut self, to: State, now: Time, outside: &mut dyn Outside) {
        let from = std::mem::replace(&mut self.state, to);
        self.status.enter(to);
        if from != to {
            let component = &self.name;
            outside.emit(
                now,
                &Event::LifeCycle {
                    component,
                    from,
                    to,
                },
            );
        }
    }

    /// Remembers a fault and tells it, once.
    pub(crate) fn note(&mut self, fault: Fault, now: Time, outside: &mut dyn Outside) {
        outside.emit(
            now,
            &Event::Fault {
                component: &self.name,
                fault: &fault,
            },
        );
        *self.status.fault() = Some(fault);
    }

    /// Changes the period of a component that has one or is event-driven; zero means event-driven.
    pub(crate) fn set_period(&mut self, period: Duration) {
        self.set_drive(self.activity.drive.with_period(period));
    }

    fn set_drive(&mut self, drive: Drive) {
        self.activity.drive = drive;
        self.status.set_period(drive.period().unwrap_or_default());
    }

    /// Parts a reference from a service.
    pub(crate) fn unwire(
        &mut self,
        reference: usize,
        service: &str,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        let mut leaving = leaving(&self.name, self.index, now, outside);
        self.body.unwire(reference, service, &mut leaving);
    }

    /// Ends calls that have waited too long. Says whether anything waits for the next cycle.
    pub(crate) fn settle(&mut self, now: Time, outside: &mut dyn Outside) -> bool {
        let mut leaving = leaving(&self.name, self.index, now, outside);
        let body = &mut self.body;
        body.caller.settle(&body.references, &mut leaving)
    }

    /// Sets properties, all or none: at the next cycle's beginning, or at once if the component does not run.
    pub(crate) fn set_properties(
        &mut self,
        values: &[(String, Datum)],
        now: Time,
        outside: &mut dyn Outside,
    ) -> Result<(), PropertyError> {
        self.body.prepare(&self.name, values)?;
        if !self.state.is_running() {
            (self.body).apply(&mut leaving(&self.name, self.index, now, outside));
        }
        Ok(())
    }
}

fn leaving<'a>(
    name: &'a Arc<str>,
    me: usize,
    now: Time,
    outside: &'a mut dyn Outside,
) -> Leaving<'a> {
    Leaving {
        now,
        me,
        name,
        outside,
    }
}
