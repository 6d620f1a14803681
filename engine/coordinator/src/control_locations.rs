//! The control states of a machine, as far as observers of brief reports follow them.

use asmotion_lang::ir::Slot;
use asmotion_lang::machine::{Machine, Step};
use std::collections::BTreeSet;

/// Usual names of functions that contain a control state.
pub const CONTROL_STATES: &[&str] = &["mode", "ctl_state", "ctlState", "state"];

/// The locations with a control state that steps have written while only brief reports were used.
///
/// Observers await values of them: a value that is written again is news only if nobody has seen it before.
#[derive(Debug, Default)]
pub(crate) struct ControlLocations {
    written: BTreeSet<Slot>,
}

impl ControlLocations {
    /// Returns whether a step that the machine has just made changed a control state, or wrote one for the first time.
    pub fn note(&mut self, machine: &Machine, step: &Step<'_>) -> bool {
        let mut is_news = false;
        for (update, before) in step.updates().iter().zip(step.before()) {
            let (program, slot) = (machine.program(), update.slot);
            let function = machine.state().function(program, slot);
            let name = function.and_then(|it| program.symbols.functions.get(it.0 as usize));
            if name.is_some_and(|name| CONTROL_STATES.contains(&&**name)) {
                is_news |= self.written.insert(slot) | (update.value != *before);
            }
        }
        is_news
    }

    /// Forgets the locations, whose slots have other meanings in a machine that begins.
    pub fn clear(&mut self) {
        self.written.clear();
    }
}
