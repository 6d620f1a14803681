//! Who decides where a rule leaves a choice.

use asmotion_ir::Origin;
use asmotion_value::Value;

/// Decides for `choose` and `chooseone`. The same decisions give the same run.
pub trait Chooser {
    /// Which of `count` candidates, in ascending order of the values; `count` is at least 1. An
    /// answer beyond the last candidate means the last.
    fn choose(&mut self, count: usize) -> usize;

    /// Whether the first candidate is always taken. Then candidates are not counted, and no choice is
    /// noted.
    fn takes_first(&self) -> bool {
        false
    }

    /// The value that the variable of a `choose` must take whose range stands here. It must be a
    /// candidate. Without an answer, every candidate is one.
    fn picked(&self, _range: Origin) -> Option<Value> {
        None
    }
}

/// Takes the first candidate.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstChoice;

impl Chooser for FirstChoice {
    fn choose(&mut self, _count: usize) -> usize {
        0
    }

    fn takes_first(&self) -> bool {
        true
    }
}
