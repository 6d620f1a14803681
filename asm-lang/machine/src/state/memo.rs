//! Caches of a state: they affect the speed of a machine, not its behaviour.

use super::range_index::RangeIndices;
use crate::windows::Near;
use asmotion_ir::Program;
use asmotion_value::Value;

/// Cached results of queries and computations.
#[derive(Clone)]
pub(crate) struct Memo {
    /// For each slot, the round in which the environment was last asked.
    pub read_in: Vec<u64>,
    /// Values of closed static terms; valid in every state of a program.
    pub caches: Vec<Option<Value>>,
    /// Slots of interned locations with small arguments.
    pub windows: Near,
    /// Elements of ranges by their value under a function.
    pub indices: RangeIndices,
}

impl Memo {
    pub fn new(program: &Program) -> Self {
        Self {
            read_in: vec![0; program.slots as usize],
            caches: vec![None; program.caches as usize],
            windows: Near::default(),
            indices: RangeIndices::default(),
        }
    }
}
