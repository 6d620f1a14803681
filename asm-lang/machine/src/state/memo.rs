//! What is remembered of a state for speed; a machine without it does the same.

use crate::windows::Near;
use asmotion_ir::Program;
use asmotion_value::Value;

/// What need not be computed, found or asked again.
#[derive(Clone)]
pub(crate) struct Memo {
    /// In which round each slot was last asked of the environment.
    pub asked: Vec<u64>,
    /// Values of closed static terms: the same in every state of a program.
    pub caches: Vec<Option<Value>>,
    /// Shortcuts to interned locations.
    pub near: Near,
}

impl Memo {
    pub fn new(program: &Program) -> Self {
        Self {
            asked: vec![0; program.slots as usize],
            caches: vec![None; program.caches as usize],
            near: Near::default(),
        }
    }
}
