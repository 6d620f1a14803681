//! The control states of a machine, as far as observers of brief reports follow them.

use asmotion_lang::ir::{FunctionId, Program, Slot, Storage};
use asmotion_lang::machine::{Machine, Step};
use std::collections::BTreeSet;
use std::ops::Range;

/// Usual names of functions that contain a control state.
pub const CONTROL_STATES: &[&str] = &["mode", "ctl_state", "ctlState", "state"];

/// The locations with a control state that steps have written while only brief reports were used.
///
/// Observers await values of them: a value that is written again is news only if nobody has seen it before.
#[derive(Debug, Default)]
pub(crate) struct ControlLocations {
    /// The locations of control states that the program lays out; determined by the first step.
    fixed: Option<Vec<Range<Slot>>>,
    written: BTreeSet<Slot>,
}

impl ControlLocations {
    /// Returns whether a step that the machine has just made changed a control state, or wrote one for the first time.
    pub fn note(&mut self, machine: &Machine, step: &Step<'_>) -> bool {
        let program = machine.program();
        let fixed = self.fixed.get_or_insert_with(|| fixed(program));
        let mut is_news = false;
        for (update, before) in step.updates().iter().zip(step.before()) {
            let slot = update.slot;
            let is_control = if slot < program.slots {
                fixed.iter().any(|it| it.contains(&slot))
            } else {
                let function = machine.state().function(program, slot);
                function.is_some_and(|it| is_control_state(program, it))
            };
            if is_control {
                is_news |= self.written.insert(slot) | (update.value != *before);
            }
        }
        is_news
    }

    /// Forgets the locations, whose slots have other meanings in a machine that begins.
    pub fn clear(&mut self) {
        *self = Self::default();
    }
}

/// The locations of control states that a program lays out.
fn fixed(program: &Program) -> Vec<Range<Slot>> {
    let functions = program.dense.iter();
    let control = functions.filter(|it| is_control_state(program, **it));
    let slots = control.filter_map(|it| match program.functions.get(it.0 as usize)?.storage {
        Storage::Dense { base, count, .. } => Some(base..base.saturating_add(count)),
        Storage::None | Storage::Interned => None,
    });
    slots.collect()
}

fn is_control_state(program: &Program, function: FunctionId) -> bool {
    let name = program.symbols.functions.get(function.0 as usize);
    name.is_some_and(|name| CONTROL_STATES.contains(&&**name))
}
