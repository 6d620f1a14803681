//! Executor threads: a few threads that run the cycles of all components without a thread of their own.
//!
//! A component group runs in one thread at a time, one cycle in a turn, in the order in which groups become ready. As many
//! groups run at once as there are processors. One whose cycle takes longer than a few milliseconds no longer counts, and
//! another thread takes its place, so that a component that blocks delays others by no more than that; there are at most as many
//! threads as groups that block at once, and `width + 1`. A thread that finds nothing to do sleeps until the next group is due
//! or the bell rings.
//!
//! A thread that brings data can be lent to them ([`LentTurns`]): it runs the cycle that takes the data and those that follow, as
//! long as they are expected to be brief, so that no thread has to be woken. Commands are left to the executor threads: they may
//! take long, or end the lent thread.

use std::num::NonZeroU64;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_component::NOTICE_REPORT;
use asmotion_datum::Datum;
use asmotion_port::Time;

use super::group::{ComponentGroup, NextStep};
use super::seat_schedule::{SeatSchedule, SeatTurn, SeatWait};
use crate::context::{ExecutorBell, LentTurns, LiveContext, WakeTarget};
use crate::effects::Effects;
use crate::event::Event;

/// Delay by which the operating system may wake an executor thread late, to save power, in nanoseconds.
const TIMER_SLACK: u64 = 1_000;

/// Most turns of a lent thread before it goes back to what it was doing.
const LENT_TURNS: usize = 16;

/// The executor threads of a system. Owned by the run; the threads share `shared`.
pub(super) struct ExecutorThreads {
    shared: Arc<SharedExecutor>,
}

struct SharedExecutor {
    bell: Arc<ExecutorBell>,
    /// Locked between turns only, never during a cycle; components and the threads of others wake seats by the bell.
    state: Mutex<ExecutorState>,
    context: LiveContext,
    width: usize,
}

struct ExecutorState {
    schedule: SeatSchedule<Box<ComponentGroup>>,
    threads: Vec<JoinHandle<()>>,
    /// Turns in lent threads.
    lent: usize,
    /// The threads end once no group is ready.
    ended: bool,
}

impl ExecutorThreads {
    pub(super) fn new(context: LiveContext) -> Self {
        // a second thread watches the clock, also where there is one processor
        let width = std::thread::available_parallelism().map_or(2, |width| width.get().max(2));
        let state = ExecutorState {
            schedule: SeatSchedule::new(width),
            threads: Vec::new(),
            lent: 0,
            ended: false,
        };
        Self {
            shared: Arc::new(SharedExecutor {
                bell: Arc::default(),
                state: Mutex::new(state),
                context,
                width,
            }),
        }
    }

    /// Adds a group, which has its first turn when it is woken. Returns its seat.
    pub(super) fn add(&self, group: ComponentGroup) -> usize {
        let mut state = self.shared.lock();
        let seat = state.schedule.next_seat();
        self.shared.bell.add_seat(seat);
        state.schedule.add(Box::new(group));
        while state.threads.len() < 2 && self.shared.spawn(&mut state) {}
        seat
    }

    pub(super) fn target(&self, seat: usize) -> WakeTarget {
        let shared: Weak<SharedExecutor> = Arc::downgrade(&self.shared);
        WakeTarget::Seat {
            bell: Arc::clone(&self.shared.bell),
            seat,
            turns: shared,
        }
    }

    /// Ends the threads, each after its turn and what is ready.
    pub(super) fn end(&self) {
        let mut state = self.shared.lock();
        state.ended = true;
        let threads = state.threads.len();
        drop(state);
        for number in 0..threads {
            self.shared.bell.unpark(number);
        }
    }

    pub(super) fn are_finished(&self) -> bool {
        let state = self.shared.lock();
        state.threads.iter().all(JoinHandle::is_finished)
    }
}

impl SharedExecutor {
    fn lock(&self) -> MutexGuard<'_, ExecutorState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts a thread. Returns `false` if the operating system refuses it.
    fn spawn(self: &Arc<Self>, state: &mut ExecutorState) -> bool {
        let number = state.threads.len();
        self.bell.add_thread(number);
        let shared = Arc::clone(self);
        let builder = std::thread::Builder::new().name(format!("executor-{number}"));
        let thread = builder.spawn(move || shared.run(number));
        thread.is_ok_and(|thread| {
            state.threads.push(thread);
            true
        })
    }

    /// The loop of a thread.
    fn run(self: Arc<Self>, number: usize) {
        // a system that does not know it, or refuses it, wakes the thread up to 50 µs late
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(TIMER_SLACK));
        self.bell.set_thread(number, std::thread::current());
        let mut context = self.context.clone();
        let mut state = self.lock();
        loop {
            state.schedule.end_wait(number);
            self.bell.take_woken(|seat| state.schedule.wake(seat));
            let now = context.now();
            state.schedule.expire(now);
            match state.schedule.take(now) {
                Some(turn) => {
                    drop(state);
                    if turn.needs_thread {
                        self.call_thread();
                    }
                    state = self.turn(turn, &mut context);
                }
                None if state.ended && state.schedule.is_idle() => return,
                None => {
                    let wait = state.schedule.wait(number, now);
                    drop(state);
                    self.sleep(number, wait, &context);
                    state = self.lock();
                }
            }
        }
    }

    fn sleep(&self, number: usize, wait: SeatWait, context: &LiveContext) {
        let park_until = |at: Time| std::thread::park_timeout(at.since(context.now()));
        match wait {
            SeatWait::Idle(Some(at)) => self.bell.while_idle(number, || park_until(at)),
            SeatWait::Idle(None) => self.bell.while_idle(number, std::thread::park),
            SeatWait::Crowded(at) => park_until(at),
        }
    }

    /// Lets another thread look at the schedule: an idle one, or a new one if all others are in turns.
    fn call_thread(self: &Arc<Self>) {
        if self.bell.ring() {
            return;
        }
        let mut state = self.lock();
        if state.threads.len() + state.lent <= state.schedule.running() {
            self.spawn(&mut state);
        }
    }

    /// Runs one turn of a group and puts it back.
    fn turn(
        &self,
        turn: SeatTurn<Box<ComponentGroup>>,
        context: &mut LiveContext,
    ) -> MutexGuard<'_, ExecutorState> {
        let SeatTurn {
            seat,
            mut group,
            since,
            ..
        } = turn;
        let next = self.bell.during_turn(|| take_turn(&mut group));
        let Some(next) = next else {
            // a component takes its time to be dropped, so without the lock
            drop(group);
            let mut state = self.lock();
            state.schedule.remove(seat);
            return state;
        };
        self.put_back((seat, since), group, next, context)
    }

    /// Runs one turn of a group in a lent thread. Returns `false` as well if it is left to the executor threads: with commands.
    fn lent_turn(
        &self,
        turn: SeatTurn<Box<ComponentGroup>>,
        context: &mut LiveContext,
    ) -> (MutexGuard<'_, ExecutorState>, bool) {
        let SeatTurn {
            seat,
            mut group,
            since,
            ..
        } = turn;
        let advance = || (!group.has_command()).then(|| group.advance());
        // components are guarded one by one; after a panic elsewhere, an executor thread goes on
        let advance = || catch_unwind(AssertUnwindSafe(advance)).unwrap_or_default();
        let next = self.bell.during_turn(advance);
        let step = next.unwrap_or(NextStep::Cycle);
        let mut state = self.put_back((seat, since), group, step, context);
        state.lent -= 1;
        (state, next.is_some())
    }

    /// Puts a group back after its turn, which began at a time.
    fn put_back(
        &self,
        (seat, since): (usize, Time),
        group: Box<ComponentGroup>,
        next: NextStep,
        context: &mut LiveContext,
    ) -> MutexGuard<'_, ExecutorState> {
        let now = context.now();
        let leader = group.leader().map(|unit| Arc::clone(&unit.name));
        let mut state = self.lock();
        let is_reported = state.schedule.put_back(seat, group, next, now);
        if is_reported && let Some(component) = leader {
            drop(state);
            self.report(&component, now.since(since), context);
            state = self.lock();
        }
        state
    }

    /// Reports a component that made others wait.
    fn report(&self, component: &str, took: Duration, context: &mut LiveContext) {
        let text = format!(
            "a cycle took {} ms in one of {} executor threads, while others were due; `thread = \"own\"` in its `task` or `activity` gives it \
             a thread of its own",
            took.as_millis(),
            self.width
        );
        let kind = NOTICE_REPORT;
        let data = &Datum::text(text);
        let report = Event::Report {
            component,
            kind,
            data,
        };
        context.emit(context.now(), &report);
    }
}

impl LentTurns for SharedExecutor {
    fn run_lent(self: Arc<Self>) {
        let mut context = self.context.clone();
        let mut state = self.lock();
        let mut goes_on = !state.ended;
        for _ in 0..LENT_TURNS {
            self.bell.take_woken(|seat| state.schedule.wake(seat));
            if !goes_on {
                break;
            }
            let Some(turn) = state.schedule.take_lent(context.now()) else {
                break;
            };
            state.lent += 1;
            drop(state);
            if turn.needs_thread {
                self.call_thread();
            }
            (state, goes_on) = self.lent_turn(turn, &mut context);
        }
        self.bell.take_woken(|seat| state.schedule.wake(seat));
        let needs_thread = state.schedule.needs_thread();
        drop(state);
        if needs_thread {
            self.call_thread();
        }
    }
}

/// Carries out a group's commands and runs a cycle if one is due. Returns `None` if the group has ended. Components are guarded
/// one by one; a panic elsewhere ends the group and leaves the thread to the others.
fn take_turn(group: &mut ComponentGroup) -> Option<NextStep> {
    let turn = || group.process_commands().then(|| group.advance());
    catch_unwind(AssertUnwindSafe(turn)).unwrap_or_default()
}
