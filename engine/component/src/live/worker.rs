//! A component's thread: commands, then the cycle that is due, then sleep.

use std::sync::{Arc, mpsc};
use std::time::Duration;

use datum::Datum;

use super::wake::{Wake, World};
use crate::activity::{Drive, Overrun};
use crate::run::RunError;
use crate::unit::Unit;
use crate::{Fault, LifeCycleError, Time, Transition};

/// What the run's owner wants of a component.
pub(crate) enum Command {
    Transition(Transition, mpsc::Sender<Result<(), RunError>>),
    SetProperties(Vec<(String, Datum)>, mpsc::Sender<Result<(), RunError>>),
    SetPeriod(Duration, mpsc::Sender<()>),
    Properties(mpsc::Sender<Vec<(String, Datum)>>),
    Fault(mpsc::Sender<Option<Fault>>),
    End,
}

/// What a thread does next.
enum Next {
    Cycle,
    /// Until woken.
    Sleep,
    /// Until woken, or until then.
    SleepUntil(Time),
}

/// A component and its thread.
pub(crate) struct Worker {
    unit: Unit,
    wake: Arc<Wake>,
    inbox: mpsc::Receiver<Command>,
    world: World,
    /// When the next periodic cycle is due, or the first of an event-driven component.
    due: Time,
}

impl Worker {
    pub(crate) fn new(
        unit: Unit,
        wake: Arc<Wake>,
        inbox: mpsc::Receiver<Command>,
        world: World,
    ) -> Self {
        Self {
            unit,
            wake,
            inbox,
            world,
            due: Time::ZERO,
        }
    }

    pub(crate) fn run(mut self) {
        while self.attend() {
            match self.next() {
                Next::Cycle => self.cycle(),
                Next::Sleep => std::thread::park(),
                Next::SleepUntil(at) => {
                    std::thread::park_timeout(at.since(self.world.now()));
                }
            }
        }
    }

    /// Carries out what is asked. Says whether to go on.
    fn attend(&mut self) -> bool {
        loop {
            // An owner who has gone does not read answers.
            match self.inbox.try_recv() {
                Err(mpsc::TryRecvError::Empty) => return true,
                Err(mpsc::TryRecvError::Disconnected) | Ok(Command::End) => return false,
                Ok(Command::Transition(transition, answer)) => {
                    let taken = self.take_through(transition);
                    let _ = answer.send(taken.map_err(RunError::from));
                }
                Ok(Command::SetProperties(values, answer)) => {
                    let now = self.world.now();
                    let set = (self.unit).set_properties(&values, now, &mut self.world);
                    let _ = answer.send(set.map_err(RunError::from));
                }
                Ok(Command::SetPeriod(period, answer)) => {
                    self.set_drive(Drive::of_period(period));
                    let _ = answer.send(());
                }
                Ok(Command::Properties(answer)) => {
                    let _ = answer.send(self.unit.body.values());
                }
                Ok(Command::Fault(answer)) => {
                    let _ = answer.send(self.unit.fault.clone());
                }
            }
        }
    }

    fn take_through(&mut self, transition: Transition) -> Result<(), LifeCycleError> {
        let now = self.world.now();
        let result = self.unit.transition(transition, now, &mut self.world);
        if result.is_ok() && transition == Transition::Start {
            self.due = now + self.unit.activity.delay;
            let event_driven = self.unit.activity.drive == Drive::Event;
            self.wake.set_event_driven(event_driven);
            if event_driven {
                // RTT triggers on start.
                self.wake.news();
            }
        }
        result
    }

    /// The next cycle is a new period after the last one.
    fn set_drive(&mut self, drive: Drive) {
        let before = std::mem::replace(&mut self.unit.activity.drive, drive);
        let now = self.world.now();
        self.adopt(before.period().map_or(now, |period| self.due - period));
    }

    /// Plans by a drive that is new since the last cycle.
    fn adopt(&mut self, last: Time) {
        let drive = self.unit.activity.drive;
        self.wake.set_event_driven(drive == Drive::Event);
        if let Some(period) = drive.period() {
            self.due = (last + period).max(self.world.now());
        }
    }

    fn next(&mut self) -> Next {
        if !self.unit.state().is_running() {
            return Next::Sleep;
        }
        if self.wake.take_call() {
            return Next::Cycle;
        }
        let now = self.world.now();
        match self.unit.activity.drive {
            _ if now < self.due => Next::SleepUntil(self.due),
            Drive::Period(_) => Next::Cycle,
            Drive::Event if self.wake.take_news() => Next::Cycle,
            Drive::Event | Drive::Manual => self.await_replies(now),
        }
    }

    /// Nothing to do but to wait, for news or for the end of a call.
    fn await_replies(&mut self, now: Time) -> Next {
        match self.unit.body.caller.deadline() {
            None => Next::Sleep,
            Some(deadline) if now < deadline => Next::SleepUntil(deadline),
            Some(_) => {
                // Ends the call, which is news to an event-driven component.
                self.unit.settle(now, &mut self.world);
                Next::SleepUntil(now)
            }
        }
    }

    fn cycle(&mut self) {
        let begin = self.world.now();
        let before = self.unit.activity.drive;
        self.unit.cycle(begin, &mut self.world);
        if self.unit.activity.drive != before {
            return self.adopt(begin);
        }
        if let Drive::Period(period) = before
            && begin >= self.due
        {
            self.plan(begin, period);
        }
    }

    /// Plans the next periodic cycle; counts the periods this one has missed.
    fn plan(&mut self, begin: Time, period: Duration) {
        let end = self.world.now();
        let overrun = self.unit.activity.overrun;
        let (missed, next) = overrun.after_cycle(self.due, period, begin, end);
        self.due = next;
        if missed == 0 {
            return;
        }
        self.unit.overrun(missed, end, &mut self.world);
        if overrun == Overrun::Fail {
            let fault = Fault::Overrun { missed };
            self.unit.fail(fault, end, &mut self.world);
        }
    }
}
