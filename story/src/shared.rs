//! A story that an observer of a run tells, and others read.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asmotion_component::Time;
use asmotion_plan::Plan;
use asmotion_runtime::Event;

use crate::story::Story;
use crate::summary::Summary;

/// A story that an observer of a run tells, and others read. Clones share it.
#[derive(Clone, Debug)]
pub struct SharedStory(Arc<Mutex<Story>>);

impl SharedStory {
    /// Shares a story.
    pub fn new(story: Story) -> Self {
        Self(Arc::new(Mutex::new(story)))
    }

    /// Handles an event, as [`Story::report`].
    pub fn report(&self, at: Time, event: &Event<'_>) -> Option<String> {
        self.lock().report(at, event)
    }

    /// Tells the story of another version of the system from now on.
    pub fn follow(&self, plan: &Plan) {
        self.lock().follow(plan);
    }

    /// The summary of all events so far.
    pub fn summary(&self) -> Summary {
        self.lock().summary().clone()
    }

    /// The last changes and numbers of losses, as [`Story::last_changes`].
    pub fn last_changes(&self) -> Vec<String> {
        self.lock().last_changes()
    }

    /// Locks the story; it is consistent even if an observer panicked while it held the lock.
    fn lock(&self) -> MutexGuard<'_, Story> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
