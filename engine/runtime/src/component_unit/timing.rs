//! Measures cycles: counts missed periods and checks deadlines.

use std::sync::atomic::Ordering;
use std::time::Duration;

use asmotion_component::{Deadline, Fault, OnDeadline, Overrun, Transition};
use asmotion_port::Time;

use super::ComponentUnit;
use crate::effects::Effects;
use crate::event::Event;

impl ComponentUnit {
    /// Called after a periodic cycle: counts the missed periods and returns when the next cycle is due.
    pub(crate) fn next_due(
        &mut self,
        due: Time,
        period: Duration,
        (begin, end): (Time, Time),
        effects: &mut dyn Effects,
    ) -> Time {
        let overrun = self.activity.overrun;
        let (missed, next) = overrun.after_cycle(due, period, begin, end);
        if missed > 0 {
            self.status.overruns.fetch_add(missed, Ordering::Relaxed);
            let component = &self.name;
            effects.emit(end, &Event::Overrun { component, missed });
            if overrun == Overrun::Fail && self.state.is_running() {
                self.fail(Fault::Overrun { missed }, end, effects);
            }
        }
        next
    }

    /// Called after a cycle: records its duration and, if it exceeded the deadline, reports it and takes the configured
    /// action.
    pub(crate) fn check_deadline(&mut self, took: Duration, now: Time, effects: &mut dyn Effects) {
        self.status.record_cycle_time(took);
        let late = |it: &Deadline| took > it.within;
        let Some(missed) = self.activity.deadline.filter(late) else {
            return;
        };
        let deadline = missed.within;
        self.status.late.fetch_add(1, Ordering::Relaxed);
        let event = Event::Late {
            component: &self.name,
            took,
            deadline,
        };
        effects.emit(now, &event);
        match missed.on_deadline {
            // stopped already, for another reason
            OnDeadline::Report | OnDeadline::Stop | OnDeadline::Fail
                if !self.state.is_running() => {}
            OnDeadline::Report => {}
            OnDeadline::Stop => {
                // a failure shows in the state and in events
                let _ = self.transition(Transition::Stop, now, effects);
            }
            OnDeadline::Fail => self.fail(Fault::Late { took, deadline }, now, effects),
        }
    }
}
