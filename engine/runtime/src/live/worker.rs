//! The thread of one component and its slaves: turns of its group, with sleep between them.

use super::group::{ComponentGroup, NextStep};
use super::schedule;
use crate::context::LiveContext;
use crate::effects::Effects;
use crate::event::Event;

/// Runs a group in the current thread until its last component is removed.
pub(super) fn run(mut group: ComponentGroup, mut context: LiveContext) {
    // a new component is constructed in its thread, which has no component until then
    let mut is_scheduled = apply_schedule(&group, &mut context);
    while group.process_commands() {
        is_scheduled = is_scheduled || apply_schedule(&group, &mut context);
        match group.advance() {
            NextStep::Cycle => {}
            NextStep::SleepUntil(at) => std::thread::park_timeout(at.since(context.now())),
            NextStep::Sleep => std::thread::park(),
        }
    }
}

/// Applies the scheduling class and the processors of the component that is not a slave to the thread. Returns `false` if there
/// is no component yet.
fn apply_schedule(group: &ComponentGroup, context: &mut LiveContext) -> bool {
    let Some(unit) = group.leader() else {
        return false;
    };
    for denied in schedule::apply(&unit.activity) {
        let component = &*unit.name;
        let denied = &denied;
        let event = Event::Denied { component, denied };
        context.emit(context.now(), &event);
    }
    true
}
