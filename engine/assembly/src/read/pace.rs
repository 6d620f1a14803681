//! `task`, `activity` and `lifecycle`.

use super::endpoint::DAY_MS;
use super::keys::Keys;
use crate::model::{Lifecycle, Pace};

/// TCA's periodic task.
pub(crate) fn task(mut keys: Keys<'_, '_, '_>) -> Pace {
    Pace {
        is_task: true,
        id: keys.text("id", "\"planner\""),
        may_interrupt_if_running: keys.flag("may_interrupt_if_running"),
        broker: keys.text("broker", "\"main\""),
        ..common(&mut keys)
    }
}

/// RTT's activity.
pub(crate) fn activity(mut keys: Keys<'_, '_, '_>) -> Pace {
    Pace {
        scheduler: keys.word("scheduler"),
        priority: keys.whole("priority", 1..=99),
        cpu: keys.wholes("cpu", 0..=1023, "[1]"),
        deadline_ms: keys.amount("deadline_ms", 1..=DAY_MS),
        on_deadline: keys.word("on_deadline"),
        master: keys.text("master", "\"RoverDriver\""),
        ..common(&mut keys)
    }
}

/// What both have.
fn common(keys: &mut Keys<'_, '_, '_>) -> Pace {
    Pace {
        span: keys.span,
        is_task: false,
        id: None,
        period_ms: keys.amount("period_ms", 0..=DAY_MS),
        delay_ms: keys.amount("delay_ms", 0..=DAY_MS),
        run_on_startup: keys.flag("run_on_startup"),
        may_interrupt_if_running: None,
        broker: None,
        overrun: keys.word("overrun"),
        scheduler: None,
        priority: None,
        cpu: Vec::new(),
        deadline_ms: None,
        on_deadline: None,
        master: None,
    }
}

pub(crate) fn lifecycle(mut keys: Keys<'_, '_, '_>) -> Lifecycle {
    Lifecycle {
        autoconf: keys.flag("autoconf"),
        autostart: keys.flag("autostart"),
        on_exception: keys.word("on_exception"),
        max_resets: keys.whole("max_resets", 0..=1_000_000),
    }
}
