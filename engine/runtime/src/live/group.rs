//! A component and its slaves, whose cycles one thread runs at a time: commands, then the cycle that is due.

use std::sync::{Arc, mpsc};

use asmotion_component::Drive;
use asmotion_port::Time;

use crate::component_unit::ComponentUnit;
use crate::context::{LiveContext, ThreadWaker, ring_for_noted};
use crate::run::Act;

/// A command from the run's owner.
pub(crate) enum WorkerCommand {
    /// Runs a function on the component at this position of the system.
    Act(usize, Act),
    /// Runs work for a new component, which is not among the thread's components yet.
    Work(Box<dyn FnOnce() + Send>),
    /// Takes over a new component.
    Adopt(Box<ComponentUnit>),
    /// Begins the cycles of the running components, at this time.
    Release(Time),
    /// Drops the component at this position of the system. The thread ends with the last one.
    Remove(usize),
    End,
}

/// A component's next step. The smallest of a group's components decides what its thread does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum NextStep {
    Cycle,
    /// Check again at this time, unless woken before.
    SleepUntil(Time),
    /// Nothing until woken.
    Sleep,
}

/// A component that is not a slave, and its slaves.
pub(super) struct ComponentGroup {
    members: Vec<GroupMember>,
    commands: mpsc::Receiver<WorkerCommand>,
    /// A command that has been received and not carried out.
    received: Option<WorkerCommand>,
    context: LiveContext,
    /// Cycles may run. Set once all components of the system have been started, so that a call in a first cycle finds
    /// its provider running, whatever the order of the components.
    released: bool,
    /// Position of the component whose cycle is due, and whose wake-up has been taken.
    pending: Option<usize>,
}

/// One component of a group.
struct GroupMember {
    unit: ComponentUnit,
    waker: Arc<ThreadWaker>,
    /// Time of the next periodic cycle; for an event-driven component, of its first cycle.
    due: Time,
}

impl ComponentGroup {
    pub(super) fn new(
        units: Vec<ComponentUnit>,
        commands: mpsc::Receiver<WorkerCommand>,
        context: LiveContext,
    ) -> Self {
        let members = units.into_iter().map(|unit| {
            let waker = context.waker(unit.index);
            GroupMember::new(unit, waker)
        });
        Self {
            members: members.collect(),
            commands,
            received: None,
            context,
            released: false,
            pending: None,
        }
    }

    /// Runs a cycle if one is due. Returns the next step; if that is a cycle, the next call runs it.
    pub(super) fn advance(&mut self) -> NextStep {
        // the component can have been removed since
        let pending = self.pending.take();
        let pending =
            pending.and_then(|it| self.members.iter().position(|one| one.unit.index == it));
        let step = pending.map_or_else(|| self.next_step(), |index| (NextStep::Cycle, index));
        match step {
            (NextStep::Cycle, index) => self.cycle(index),
            (step @ (NextStep::SleepUntil(_) | NextStep::Sleep), _) => return step,
        }
        let (step, index) = self.next_step();
        if step == NextStep::Cycle {
            self.pending = self.members.get(index).map(|member| member.unit.index);
        }
        step
    }

    /// The component that is not a slave.
    pub(super) fn leader(&self) -> Option<&ComponentUnit> {
        let mut units = self.members.iter().map(|member| &member.unit);
        units.find(|unit| unit.master.is_none())
    }

    /// The soonest step of the components, and its member. A cycle takes the wake-up of this member only.
    fn next_step(&mut self) -> (NextStep, usize) {
        let mut soonest = (NextStep::Sleep, 0);
        if self.released {
            for (index, member) in self.members.iter_mut().enumerate() {
                soonest = soonest.min((member.next_step(&mut self.context), index));
                if soonest.0 == NextStep::Cycle {
                    break;
                }
            }
        }
        soonest
    }

    /// Returns whether a command waits, or the owner of the run is gone.
    pub(super) fn has_command(&mut self) -> bool {
        if self.received.is_none() {
            match self.commands.try_recv() {
                Ok(command) => self.received = Some(command),
                Err(mpsc::TryRecvError::Empty) => return false,
                Err(mpsc::TryRecvError::Disconnected) => return true,
            }
        }
        true
    }

    /// Carries out waiting commands. Returns whether to continue.
    pub(super) fn process_commands(&mut self) -> bool {
        loop {
            let received = self.received.take();
            match received.map_or_else(|| self.commands.try_recv(), Ok) {
                Err(mpsc::TryRecvError::Empty) => return true,
                Err(mpsc::TryRecvError::Disconnected) | Ok(WorkerCommand::End) => return false,
                Ok(WorkerCommand::Act(component, act)) => {
                    let mut members = self.members.iter_mut();
                    if let Some(member) = members.find(|one| one.unit.index == component) {
                        member.run_act(act, self.released, &mut self.context);
                        // planned anew: only a waiting message or request is left of a cycle that was due
                        if self.pending.take_if(|it| *it == component).is_some() {
                            member.waker.trigger();
                        }
                    }
                }
                Ok(WorkerCommand::Work(work)) => work(),
                Ok(WorkerCommand::Adopt(unit)) => {
                    let waker = self.context.waker(unit.index);
                    self.members.push(GroupMember::new(*unit, waker));
                }
                Ok(WorkerCommand::Release(at)) => {
                    self.released = true;
                    for member in &mut self.members {
                        if member.unit.state().is_running() {
                            member.schedule_first(at);
                        } else {
                            member.await_requests();
                        }
                    }
                }
                Ok(WorkerCommand::Remove(component)) => {
                    self.members.retain(|one| one.unit.index != component);
                    if self.members.is_empty() {
                        return false;
                    }
                }
            }
        }
    }

    /// Runs one cycle of a component, then one of each of its slaves, recursively.
    fn cycle(&mut self, index: usize) {
        if !self.members[index].unit.state().is_running() {
            return self.members[index].serve(&mut self.context);
        }
        self.members[index].cycle(&mut self.context);
        let master = Some(self.members[index].unit.index);
        for slave in 0..self.members.len() {
            let unit = &self.members[slave].unit;
            if unit.master == master && unit.state().is_running() {
                // a slave may take its time
                ring_for_noted();
                self.cycle(slave);
            }
        }
    }
}

impl GroupMember {
    fn new(unit: ComponentUnit, waker: Arc<ThreadWaker>) -> Self {
        Self {
            unit,
            waker,
            due: Time::ZERO,
        }
    }

    /// Runs a function on the component and, once cycles are `released`, plans its next one by its new state.
    fn run_act(&mut self, act: Act, released: bool, context: &mut LiveContext) {
        let (drive, ran) = (self.unit.activity.drive, self.unit.state().is_running());
        let now = context.now();
        act(&mut self.unit, now, context);
        self.await_requests();
        if !released {
            return;
        }
        if !ran && self.unit.state().is_running() {
            self.schedule_first(now);
        } else if self.unit.activity.drive != drive {
            // the next cycle is one new period after the last one
            let last = drive.period().map_or(now, |period| self.due - period);
            self.reschedule(last, context);
        }
    }

    /// Plans the first cycle after a start. An event-driven component has one too: RTT triggers on start.
    fn schedule_first(&mut self, now: Time) {
        self.due = now + self.unit.activity.delay;
        let event_driven = self.unit.activity.drive == Drive::Event;
        self.waker.set_event_driven(event_driven);
        if event_driven {
            self.waker.trigger();
        }
    }

    /// Applies a drive that has changed since the last cycle.
    fn reschedule(&mut self, last: Time, context: &LiveContext) {
        let drive = self.unit.activity.drive;
        self.waker.set_event_driven(drive == Drive::Event);
        if let Some(period) = drive.period() {
            self.due = (last + period).max(context.now());
        }
    }

    /// Lets requests wake a stopped component that answers operations, whatever its drive.
    fn await_requests(&self) {
        if !self.unit.state().is_running() {
            self.waker
                .set_event_driven(self.unit.serves_while_stopped());
        }
    }

    fn next_step(&mut self, context: &mut LiveContext) -> NextStep {
        if !self.unit.state().is_running() {
            // a request, or the end of background work
            let serves = self.unit.serves_while_stopped()
                && (self.waker.take_trigger() | self.waker.take_cycle_request());
            return if serves {
                NextStep::Cycle
            } else {
                NextStep::Sleep
            };
        }
        if self.waker.take_cycle_request() {
            return NextStep::Cycle;
        }
        let now = context.now();
        match self.unit.activity.drive {
            Drive::Slave => self.await_replies(now, context),
            Drive::Period(_) | Drive::Event | Drive::Manual if now < self.due => {
                NextStep::SleepUntil(self.due)
            }
            Drive::Period(_) => NextStep::Cycle,
            Drive::Event if self.waker.take_trigger() => NextStep::Cycle,
            Drive::Event | Drive::Manual => self.await_replies(now, context),
        }
    }

    /// Nothing is due: sleeps until new data arrive, a call reaches its deadline, or the cycle that the component has
    /// requested is due.
    fn await_replies(&mut self, now: Time, context: &mut LiveContext) -> NextStep {
        let body = &self.unit.body;
        let times = [body.caller.deadline(), body.later.time()];
        match times.into_iter().flatten().min() {
            None => NextStep::Sleep,
            Some(deadline) if now < deadline => NextStep::SleepUntil(deadline),
            Some(_) => {
                // ends the call, whose result triggers an event-driven component, as does a requested cycle
                self.unit.process_replies(now, context);
                NextStep::SleepUntil(now)
            }
        }
    }

    /// Answers the requests of a stopped component.
    fn serve(&mut self, context: &mut LiveContext) {
        self.unit.cycle(context.now(), context);
        self.await_requests();
    }

    fn cycle(&mut self, context: &mut LiveContext) {
        let begin = context.now();
        let before = self.unit.activity.drive;
        self.unit.cycle(begin, context);
        let now = context.now();
        self.unit.check_deadline(now.since(begin), now, context);
        if self.unit.activity.drive != before {
            self.reschedule(begin, context);
        } else if let Drive::Period(period) = before
            && begin >= self.due
        {
            let end = context.now();
            self.due = self.unit.next_due(self.due, period, (begin, end), context);
        }
        if self.unit.restart_after_fault(context.now(), context) {
            self.schedule_first(context.now() + self.unit.reset_pause());
        }
        self.await_requests();
    }
}
