//! What the clock says of a cycle: which periods it has missed, and whether it kept its deadline.

use std::sync::atomic::Ordering;
use std::time::Duration;

use super::Unit;
use crate::outside::Outside;
use crate::{Event, Fault, OnDeadline, Overrun, Time, Transition};

impl Unit {
    /// After a periodic cycle: counts the periods it has missed, and says when the next one is due.
    pub(crate) fn after_period(
        &mut self,
        due: Time,
        period: Duration,
        (begin, end): (Time, Time),
        outside: &mut dyn Outside,
    ) -> Time {
        let overrun = self.activity.overrun;
        let (missed, next) = overrun.after_cycle(due, period, begin, end);
        if missed > 0 {
            self.status.overruns.fetch_add(missed, Ordering::Relaxed);
            let component = &self.name;
            outside.emit(end, &Event::Overrun { component, missed });
            if overrun == Overrun::Fail && self.state.is_running() {
                self.fail(Fault::Overrun { missed }, end, outside);
            }
        }
        next
    }

    /// After a cycle that took so long: counts it, and holds it against its deadline, if it has one.
    pub(crate) fn hold_to_deadline(
        &mut self,
        took: Duration,
        now: Time,
        outside: &mut dyn Outside,
    ) {
        self.status.spend(took);
        let late = |it: &crate::Deadline| took > it.within;
        let Some(held) = self.activity.deadline.filter(late) else {
            return;
        };
        let deadline = held.within;
        self.status.late.fetch_add(1, Ordering::Relaxed);
        let event = Event::Late {
            component: &self.name,
            took,
            deadline,
        };
        outside.emit(now, &event);
        match held.on_deadline {
            // It does not run any more, for another reason.
            _ if !self.state.is_running() => {}
            OnDeadline::Report => {}
            OnDeadline::Stop => {
                // What goes wrong in stopping is in its state, and told.
                let _ = self.transition(Transition::Stop, now, outside);
            }
            OnDeadline::Fail => self.fail(Fault::Late { took, deadline }, now, outside),
        }
    }
}
