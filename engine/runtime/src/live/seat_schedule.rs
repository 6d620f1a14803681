//! The order in which executor threads run component groups: which are ready, when others are due, and who watches the clock.
//!
//! Plain data, which the executor threads share behind a lock. A group has a *seat* here. It rests until it is woken or its
//! timer expires, is ready until a thread takes it, and runs in that thread alone.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use asmotion_port::Time;

use super::group::NextStep;

/// Time for which a running group counts as one of the `width` that may run at once. One that takes longer is probably
/// waiting for something, and does not keep others from running.
const PATIENCE: Duration = Duration::from_millis(2);

/// Limit on the duration of a turn for which a thread needs no other one to watch the clock.
const BRIEF: Duration = Duration::from_micros(200);

/// Limit on the duration of a turn that runs in a thread which is lent.
const LENT: Duration = Duration::from_micros(500);

/// Delay of a group that is due while the thread that watched the clock is in a turn that was expected to be brief: the operating
/// system can give the processor to another process in it. A second thread wakes each time it passes.
const SLACK: Duration = Duration::from_millis(1);

/// Duration of a turn from which it is reported, if it made others wait.
const LONG: Duration = Duration::from_millis(100);

/// Groups and the threads that run them.
pub(super) struct SeatSchedule<G> {
    seats: Vec<Seat<G>>,
    /// Seats without a group, to be used again.
    vacant: Vec<usize>,
    /// Seats whose groups wait for a thread, in the order in which they became ready.
    ready: VecDeque<usize>,
    /// Times at which resting groups become ready, with their seats.
    timers: BTreeSet<(Time, usize)>,
    runs: Vec<SeatRun>,
    /// Threads that sleep until a time, by number.
    waits: Vec<(usize, Time)>,
    /// Number of groups that may run at once.
    width: usize,
}

struct Seat<G> {
    state: SeatState<G>,
    /// An estimate of the duration of the next turn: that of the longest of the last ones, halved with each later one.
    usual: Duration,
    is_reported: bool,
}

enum SeatState<G> {
    Vacant,
    Resting {
        group: G,
        timer: Option<Time>,
    },
    Ready(G),
    /// `woken`: ready again after the turn.
    Running {
        woken: bool,
    },
}

/// A turn that a thread has taken.
struct SeatRun {
    seat: usize,
    since: Time,
    /// Others had to wait until it no longer counted.
    is_hindrance: bool,
}

/// A group to run now.
pub(super) struct SeatTurn<G> {
    pub seat: usize,
    pub group: G,
    pub since: Time,
    /// Another thread is needed beside this one, for the next group or to watch the clock.
    pub needs_thread: bool,
}

/// What a thread without a group to run does.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum SeatWait {
    /// Sleep until the bell rings, at most until this time.
    Idle(Option<Time>),
    /// Sleep until this time: there are groups that are ready, but too many are running.
    Crowded(Time),
}

impl<G> SeatSchedule<G> {
    pub(super) fn new(width: usize) -> Self {
        Self {
            seats: Vec::new(),
            vacant: Vec::new(),
            ready: VecDeque::new(),
            timers: BTreeSet::new(),
            runs: Vec::new(),
            waits: Vec::new(),
            width,
        }
    }

    /// The seat of the next group that is added.
    pub(super) fn next_seat(&self) -> usize {
        self.vacant.last().copied().unwrap_or(self.seats.len())
    }

    /// Adds a group, which rests until it is woken.
    pub(super) fn add(&mut self, group: G) {
        let seat = Seat {
            state: SeatState::Resting { group, timer: None },
            usual: BRIEF * 8,
            is_reported: false,
        };
        match self.vacant.pop() {
            Some(index) => self.seats[index] = seat,
            None => self.seats.push(seat),
        }
    }

    /// Makes a group ready; one that runs becomes ready again after its turn.
    pub(super) fn wake(&mut self, index: usize) {
        let Some(seat) = self.seats.get_mut(index) else {
            return;
        };
        match std::mem::replace(&mut seat.state, SeatState::Vacant) {
            SeatState::Resting { group, timer } => {
                if let Some(at) = timer {
                    self.timers.remove(&(at, index));
                }
                seat.state = SeatState::Ready(group);
                self.ready.push_back(index);
            }
            SeatState::Running { .. } => seat.state = SeatState::Running { woken: true },
            state @ (SeatState::Ready(_) | SeatState::Vacant) => seat.state = state,
        }
    }

    /// Makes the groups ready whose time has come.
    pub(super) fn expire(&mut self, now: Time) {
        while let Some((at, seat)) = self.timers.first().copied()
            && at <= now
        {
            // removes the timer
            self.wake(seat);
        }
    }

    /// Takes the group that has been ready for the longest time, unless as many are running as may.
    pub(super) fn take(&mut self, now: Time) -> Option<SeatTurn<G>> {
        if !self.has_room(now) {
            return None;
        }
        let index = self.ready.pop_front()?;
        let seat = self.seats.get_mut(index)?;
        let running = SeatState::Running { woken: false };
        let SeatState::Ready(group) = std::mem::replace(&mut seat.state, running) else {
            return None;
        };
        let is_brief = seat.usual <= BRIEF;
        if self.runs.len() >= self.width {
            for run in &mut self.runs {
                run.is_hindrance |= now.since(run.since) >= PATIENCE;
            }
        }
        self.runs.push(SeatRun {
            seat: index,
            since: now,
            is_hindrance: false,
        });
        let slack = if is_brief { SLACK } else { Duration::ZERO };
        let has_more = !self.ready.is_empty() && self.has_room(now);
        Some(SeatTurn {
            seat: index,
            group,
            since: now,
            needs_thread: has_more || !self.is_watched(slack),
        })
    }

    /// As [`take`](Self::take), for a thread that is lent: only a group whose turn is expected to be brief.
    pub(super) fn take_lent(&mut self, now: Time) -> Option<SeatTurn<G>> {
        let first = self.ready.front()?;
        let is_brief = self.seats.get(*first).is_some_and(|it| it.usual <= LENT);
        is_brief.then(|| self.take(now)).flatten()
    }

    /// Returns whether a thread has to look after the groups when one that was lent leaves.
    pub(super) fn needs_thread(&self) -> bool {
        !self.ready.is_empty() || !self.is_watched(Duration::ZERO)
    }

    /// Takes a group back after its turn. Returns whether the turn is to be reported, because it was long and others had to wait
    /// for it; once for each seat.
    pub(super) fn put_back(&mut self, index: usize, group: G, next: NextStep, now: Time) -> bool {
        let run = self.end_run(index);
        let Some(seat) = self.seats.get_mut(index) else {
            return false;
        };
        let took = run
            .as_ref()
            .map_or(Duration::ZERO, |run| now.since(run.since));
        // few brief turns make up for a long one, which can be the time of other processes
        seat.usual = took.min(BRIEF * 16).max(seat.usual / 2);
        let is_woken = matches!(seat.state, SeatState::Running { woken: true });
        match next {
            NextStep::Cycle => {
                seat.state = SeatState::Ready(group);
                self.ready.push_back(index);
            }
            NextStep::Sleep | NextStep::SleepUntil(_) if is_woken => {
                seat.state = SeatState::Ready(group);
                self.ready.push_back(index);
            }
            NextStep::SleepUntil(at) => {
                let timer = Some(at);
                seat.state = SeatState::Resting { group, timer };
                self.timers.insert((at, index));
            }
            NextStep::Sleep => seat.state = SeatState::Resting { group, timer: None },
        }
        let is_hindrance = run.is_some_and(|run| run.is_hindrance) && took >= LONG;
        is_hindrance && !std::mem::replace(&mut seat.is_reported, true)
    }

    /// Vacates the seat of a group that has ended in its turn.
    pub(super) fn remove(&mut self, index: usize) {
        self.end_run(index);
        if let Some(seat) = self.seats.get_mut(index) {
            seat.state = SeatState::Vacant;
            self.vacant.push(index);
        }
    }

    fn end_run(&mut self, seat: usize) -> Option<SeatRun> {
        let position = self.runs.iter().position(|run| run.seat == seat)?;
        Some(self.runs.swap_remove(position))
    }

    /// Decides how long a thread sleeps that found no group to run. One of the threads wakes when the next group is due, and a
    /// second one [`SLACK`] later, in case the first one is in a turn then.
    pub(super) fn wait(&mut self, thread: usize, now: Time) -> SeatWait {
        if !self.ready.is_empty() {
            let ends = self.runs.iter().map(|run| run.since + PATIENCE);
            let until = ends.filter(|end| *end > now).min().unwrap_or(now);
            self.waits.push((thread, until));
            return SeatWait::Crowded(until);
        }
        let Some((next, _)) = self.timers.first().copied() else {
            return SeatWait::Idle(None);
        };
        let until = if !self.is_watched(Duration::ZERO) {
            next
        } else if self
            .waits
            .iter()
            .filter(|(_, it)| *it <= next + SLACK)
            .count()
            < 2
        {
            next + SLACK
        } else {
            return SeatWait::Idle(None);
        };
        self.waits.push((thread, until));
        SeatWait::Idle(Some(until))
    }

    /// Called by a thread that slept.
    pub(super) fn end_wait(&mut self, thread: usize) {
        self.waits.retain(|(it, _)| *it != thread);
    }

    /// Returns whether a sleeping thread wakes at the latest this long after the next group is due.
    fn is_watched(&self, slack: Duration) -> bool {
        let next = self.timers.first();
        next.is_none_or(|(at, _)| self.waits.iter().any(|(_, until)| *until <= *at + slack))
    }

    /// Returns whether another group may run.
    fn has_room(&self, now: Time) -> bool {
        let counts = |run: &&SeatRun| now.since(run.since) < PATIENCE;
        self.runs.len() < self.width || self.runs.iter().filter(counts).count() < self.width
    }

    /// Number of groups that are running.
    pub(super) fn running(&self) -> usize {
        self.runs.len()
    }

    /// Returns whether no group is left to run at once.
    pub(super) fn is_idle(&self) -> bool {
        self.ready.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use asmotion_component::Span;

    use super::*;

    fn at(ms: u64) -> Time {
        Time::ZERO + ms.ms()
    }

    fn schedule(groups: &[char], width: usize) -> SeatSchedule<char> {
        let mut schedule = SeatSchedule::new(width);
        for (seat, group) in groups.iter().enumerate() {
            assert_eq!(schedule.next_seat(), seat);
            schedule.add(*group);
            schedule.wake(seat);
        }
        schedule
    }

    /// Runs ready groups until none is left, each for no time and then resting; returns their order.
    fn order(schedule: &mut SeatSchedule<char>, now: Time) -> String {
        let mut order = String::new();
        while let Some(turn) = schedule.take(now) {
            order.push(turn.group);
            assert!(!schedule.put_back(turn.seat, turn.group, NextStep::Sleep, now));
        }
        order
    }

    #[test]
    fn groups_take_turns_in_the_order_in_which_they_became_ready() {
        let mut schedule = schedule(&['a', 'b', 'c'], 1);
        let first = schedule.take(at(0)).unwrap();
        // another cycle is due at once, and comes after the others
        schedule.put_back(first.seat, first.group, NextStep::Cycle, at(0));
        assert_eq!(order(&mut schedule, at(0)), "bca");
        schedule.wake(2);
        schedule.wake(0);
        schedule.wake(2);
        assert_eq!(order(&mut schedule, at(1)), "ca");
    }

    #[test]
    fn a_group_that_is_woken_while_it_runs_runs_again() {
        let mut schedule = schedule(&['a'], 2);
        let turn = schedule.take(at(0)).unwrap();
        schedule.wake(0);
        assert!(schedule.take(at(0)).is_none(), "one thread at a time");
        schedule.put_back(turn.seat, turn.group, NextStep::SleepUntil(at(50)), at(1));
        assert_eq!(order(&mut schedule, at(1)), "a");
    }

    #[test]
    fn a_timer_makes_its_group_ready_unless_it_was_woken_before() {
        let mut schedule = schedule(&['a', 'b'], 1);
        for until in [at(10), at(20)] {
            let turn = schedule.take(at(0)).unwrap();
            schedule.put_back(turn.seat, turn.group, NextStep::SleepUntil(until), at(0));
        }
        assert_eq!(schedule.wait(0, at(0)), SeatWait::Idle(Some(at(10))));
        schedule.end_wait(0);
        schedule.expire(at(9));
        assert_eq!(order(&mut schedule, at(9)), "");
        schedule.wake(1);
        assert_eq!(order(&mut schedule, at(9)), "b");
        schedule.expire(at(30));
        assert_eq!(order(&mut schedule, at(30)), "a");
    }

    #[test]
    fn a_long_turn_no_longer_keeps_others_waiting_and_is_reported_once() {
        let mut schedule = schedule(&['a', 'b'], 1);
        for expected in [true, false] {
            let long = schedule.take(at(0)).unwrap();
            assert!(schedule.take(at(1)).is_none());
            assert_eq!(schedule.wait(1, at(1)), SeatWait::Crowded(at(2)));
            schedule.end_wait(1);
            let other = schedule.take(at(2)).unwrap();
            assert_eq!(schedule.running(), 2);
            assert!(!schedule.put_back(other.seat, other.group, NextStep::Cycle, at(3)));
            let is_reported = schedule.put_back(long.seat, long.group, NextStep::Cycle, at(200));
            assert_eq!(is_reported, expected && long.group == 'a');
            // the other one takes the next turn, for no time
            let other = schedule.take(at(200)).unwrap();
            schedule.put_back(other.seat, other.group, NextStep::Cycle, at(200));
        }
    }

    #[test]
    fn a_thread_leaves_the_clock_to_another_one_unless_its_turn_is_brief() {
        let mut schedule = schedule(&['a', 'b'], 2);
        let turn = schedule.take(at(0)).unwrap();
        assert!(turn.needs_thread, "for the second group");
        schedule.put_back(turn.seat, turn.group, NextStep::SleepUntil(at(100)), at(0));
        let turn = schedule.take(at(0)).unwrap();
        assert!(
            turn.needs_thread,
            "nobody watches, and its turn can be long"
        );
        // as threads 0 and 1 do: the second one comes later, in case the first one is in a turn
        assert_eq!(schedule.wait(1, at(0)), SeatWait::Idle(Some(at(100))));
        assert_eq!(schedule.wait(2, at(0)), SeatWait::Idle(Some(at(101))));
        assert_eq!(schedule.wait(3, at(0)), SeatWait::Idle(None));
        schedule.put_back(turn.seat, turn.group, NextStep::Cycle, at(0));
        for _ in 0..5 {
            let turn = schedule.take(at(0)).unwrap();
            schedule.put_back(turn.seat, turn.group, NextStep::Cycle, at(0));
        }
        schedule.end_wait(1);
        assert!(!schedule.take(at(0)).unwrap().needs_thread, "brief so far");
    }

    #[test]
    fn the_seat_of_a_removed_group_is_used_again() {
        let mut schedule = schedule(&['a', 'b'], 1);
        let turn = schedule.take(at(0)).unwrap();
        schedule.wake(turn.seat);
        schedule.remove(turn.seat);
        assert_eq!(schedule.next_seat(), 0);
        schedule.wake(0);
        schedule.add('c');
        schedule.wake(0);
        assert_eq!(order(&mut schedule, at(1)), "bc");
        assert!(schedule.is_idle());
    }
}
