//! Who decides where a rule leaves a choice.

use ir::Origin;
use std::sync::Arc;
use value::Value;

/// Decides for `choose` and `chooseone`. The same decisions give the same run.
pub trait Chooser {
    /// Which of `count` candidates, in ascending order of the values; `count` is at least 1. An
    /// answer beyond the last candidate means the last.
    fn choose(&mut self, count: usize) -> usize;

    /// Whether the first candidate is always taken. Then candidates are not counted.
    fn takes_first(&self) -> bool {
        false
    }

    /// The values that the variables of a `choose` must take, in their order; `None` where any will
    /// do. They must be candidates. Without an answer, every candidate is one.
    fn picked(&self, _choose: Origin) -> Option<Arc<[Option<Value>]>> {
        None
    }
}

/// Takes the first candidate.
#[derive(Clone, Copy, Debug, Default)]
pub struct First;

impl Chooser for First {
    fn choose(&mut self, _count: usize) -> usize {
        0
    }

    fn takes_first(&self) -> bool {
        true
    }
}
