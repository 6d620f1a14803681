//! What the clock says of a cycle: which periods it has missed, and whether it kept its deadline.

use std::sync::atomic::Ordering;
use std::time::Duration;

use asmotion_component::{Deadline, Fault, OnDeadline, Overrun, Transition};
use asmotion_port::Time;

use super::ComponentUnit;
use crate::effects::Effects;
use crate::event::Event;

impl ComponentUnit {
    /// After a periodic cycle: counts the periods it has missed, and says when the next one is due.
    pub(crate) fn after_period(
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

    /// After a cycle that took so long: counts it, and holds it against its deadline, if it has one.
    pub(crate) fn hold_to_deadline(
        &mut self,
        took: Duration,
        now: Time,
        effects: &mut dyn Effects,
    ) {
        self.status.spend(took);
        let late = |it: &Deadline| took > it.within;
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
        effects.emit(now, &event);
        match held.on_deadline {
            // It does not run any more, for another reason.
            OnDeadline::Report | OnDeadline::Stop | OnDeadline::Fail
                if !self.state.is_running() => {}
            OnDeadline::Report => {}
            OnDeadline::Stop => {
                // What goes wrong in stopping is in its state, and told.
                let _ = self.transition(Transition::Stop, now, effects);
            }
            OnDeadline::Fail => self.fail(Fault::Late { took, deadline }, now, effects),
        }
    }
}
