//! A thread for a component and its slaves: commands, then the cycle that is due, then sleep.

use std::sync::{Arc, mpsc};

use super::schedule;
use super::wake::{Wake, World};
use crate::activity::Drive;
use crate::outside::Outside;
use crate::run::Act;
use crate::unit::Unit;
use crate::{Event, Time};

/// What the run's owner wants.
pub(crate) enum Command {
    /// Something to be done to the component at this place of the system.
    Act(usize, Act),
    End,
}

/// What a component needs next.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Next {
    Cycle,
    /// Look again then, unless woken before.
    SleepUntil(Time),
    /// Nothing, until woken.
    Sleep,
}

/// A thread's components.
pub(crate) struct Worker {
    members: Vec<Member>,
    inbox: mpsc::Receiver<Command>,
    world: World,
}

/// A component of a thread.
struct Member {
    unit: Unit,
    wake: Arc<Wake>,
    /// When the next periodic cycle is due, or the first of an event-driven component.
    due: Time,
}

impl Worker {
    pub(crate) fn new(
        units: Vec<Unit>,
        wakes: &[Arc<Wake>],
        inbox: mpsc::Receiver<Command>,
        world: World,
    ) -> Self {
        let member = |(unit, wake): (Unit, &Arc<Wake>)| Member {
            unit,
            wake: Arc::clone(wake),
            due: Time::ZERO,
        };
        Self {
            members: units.into_iter().zip(wakes).map(member).collect(),
            inbox,
            world,
        }
    }

    pub(crate) fn run(mut self) {
        self.adopt_schedule();
        while self.attend() {
            let mut soonest = (Next::Sleep, 0);
            for (index, member) in self.members.iter_mut().enumerate() {
                soonest = soonest.min((member.next(&mut self.world), index));
            }
            match soonest {
                (Next::Cycle, index) => self.cycle(index),
                (Next::SleepUntil(at), _) => {
                    std::thread::park_timeout(at.since(self.world.now()));
                }
                (Next::Sleep, _) => std::thread::park(),
            }
        }
    }

    /// Takes the scheduling class and the processors of the first component: the others are its slaves.
    fn adopt_schedule(&mut self) {
        let masters = |member: &&Member| member.unit.master.is_none();
        let Some(Member { unit, .. }) = self.members.iter().find(masters) else {
            return;
        };
        for denied in schedule::adopt(&unit.activity) {
            let component = &*unit.name;
            let denied = &denied;
            let event = Event::Denied { component, denied };
            self.world.emit(self.world.now(), &event);
        }
    }

    /// Carries out what is asked. Says whether to go on.
    fn attend(&mut self) -> bool {
        loop {
            match self.inbox.try_recv() {
                Err(mpsc::TryRecvError::Empty) => return true,
                Err(mpsc::TryRecvError::Disconnected) | Ok(Command::End) => return false,
                Ok(Command::Act(component, act)) => {
                    let mut members = self.members.iter_mut();
                    if let Some(member) = members.find(|one| one.unit.index == component) {
                        member.attend(act, &mut self.world);
                    }
                }
            }
        }
    }

    /// One cycle of a component; then its slaves cycle, and theirs.
    fn cycle(&mut self, index: usize) {
        self.members[index].cycle(&mut self.world);
        let master = Some(self.members[index].unit.index);
        for slave in 0..self.members.len() {
            let unit = &self.members[slave].unit;
            if unit.master == master && unit.state().is_running() {
                self.cycle(slave);
            }
        }
    }
}

impl Member {
    /// Has something done, and plans by what has become of the component.
    fn attend(&mut self, act: Act, world: &mut World) {
        let (drive, ran) = (self.unit.activity.drive, self.unit.state().is_running());
        let now = world.now();
        act(&mut self.unit, now, world);
        if !ran && self.unit.state().is_running() {
            self.begin(now);
        } else if self.unit.activity.drive != drive {
            // The next cycle is a new period after the last one.
            let last = drive.period().map_or(now, |period| self.due - period);
            self.adopt(last, world);
        }
    }

    /// Plans the first cycle after a start; an event-driven component has one too (RTT triggers on start).
    fn begin(&mut self, now: Time) {
        self.due = now + self.unit.activity.delay;
        let event_driven = self.unit.activity.drive == Drive::Event;
        self.wake.set_event_driven(event_driven);
        if event_driven {
            self.wake.news();
        }
    }

    /// Plans by a drive that is new since the last cycle.
    fn adopt(&mut self, last: Time, world: &World) {
        let drive = self.unit.activity.drive;
        self.wake.set_event_driven(drive == Drive::Event);
        if let Some(period) = drive.period() {
            self.due = (last + period).max(world.now());
        }
    }

    fn next(&mut self, world: &mut World) -> Next {
        if !self.unit.state().is_running() {
            return Next::Sleep;
        }
        if self.wake.take_call() {
            return Next::Cycle;
        }
        let now = world.now();
        match self.unit.activity.drive {
            Drive::Slave => self.await_replies(now, world),
            _ if now < self.due => Next::SleepUntil(self.due),
            Drive::Period(_) => Next::Cycle,
            Drive::Event if self.wake.take_news() => Next::Cycle,
            Drive::Event | Drive::Manual => self.await_replies(now, world),
        }
    }

    /// Nothing to do but to wait, for news or for the end of a call.
    fn await_replies(&mut self, now: Time, world: &mut World) -> Next {
        match self.unit.body.caller.deadline() {
            None => Next::Sleep,
            Some(deadline) if now < deadline => Next::SleepUntil(deadline),
            Some(_) => {
                // Ends the call, which is news to an event-driven component.
                self.unit.settle(now, world);
                Next::SleepUntil(now)
            }
        }
    }

    fn cycle(&mut self, world: &mut World) {
        let begin = world.now();
        let before = self.unit.activity.drive;
        self.unit.cycle(begin, world);
        let now = world.now();
        self.unit.hold_to_deadline(now.since(begin), now, world);
        if self.unit.activity.drive != before {
            self.adopt(begin, world);
        } else if let Drive::Period(period) = before
            && begin >= self.due
        {
            let end = world.now();
            self.due = (self.unit).after_period(self.due, period, (begin, end), world);
        }
        if self.unit.come_back(world.now(), world) {
            self.begin(world.now());
        }
    }
}
