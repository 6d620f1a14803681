//! Limits while properties are decided in the states that were explored.

use crate::explore::{Exploration, Incomplete, Progress};
use std::cell::{Cell, RefCell};

/// Asks the caller whether to go on, and compares the memory with its limit.
pub(crate) struct Deciding<'a> {
    /// Called with the progress; returns `false` to end.
    proceed: RefCell<&'a mut dyn FnMut(Progress) -> bool>,
    /// The progress at the end of the exploration.
    explored: Progress,
    /// Limit for the memory, in bytes.
    memory: Option<u64>,
    /// The limit that was reached.
    ended: Cell<Option<Incomplete>>,
}

impl<'a> Deciding<'a> {
    pub fn new(
        exploration: &Exploration,
        memory: Option<u64>,
        proceed: &'a mut dyn FnMut(Progress) -> bool,
    ) -> Self {
        let explored = Progress {
            states: exploration.state_count(),
            explored: exploration.state_count(),
            transitions: exploration.transitions,
            depth: exploration.depth(),
            memory: exploration.memory(),
        };
        Self {
            proceed: RefCell::new(proceed),
            explored,
            memory,
            ended: Cell::new(None),
        }
    }

    /// Returns `false` if no more can be decided. `bytes` are in use besides those of the exploration.
    pub fn goes_on(&self, bytes: usize) -> bool {
        if self.ended.get().is_some() {
            return false;
        }
        let memory = self.explored.memory.saturating_add(bytes as u64);
        let progress = Progress {
            memory,
            ..self.explored
        };
        if self.memory.is_some_and(|limit| memory > limit) {
            self.ended.set(Some(Incomplete::Memory));
        } else if let Ok(mut proceed) = self.proceed.try_borrow_mut()
            && !proceed(progress)
        {
            self.ended.set(Some(Incomplete::Stopped));
        }
        self.ended.get().is_none()
    }

    /// Returns the limit that was reached.
    pub fn ended(&self) -> Option<Incomplete> {
        self.ended.get()
    }
}
