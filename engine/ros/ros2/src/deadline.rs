//! Deadlines of subscriptions: DDS announces them and matches by them, and here the gaps are noticed.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::gid::Gid;
use crate::graph::SharedGraph;
use crate::notice::Notice;
use crate::reactor::Chore;

/// Notices when a subscription with a matched publisher receives no message within its deadline. The thread of the node looks
/// at least every 200 ms.
pub(crate) struct DeadlineWatch {
    graph: Arc<SharedGraph>,
    reader: Gid,
    /// Topic of DDS.
    topic: String,
    deadline: Duration,
    state: Mutex<WatchState>,
}

#[derive(Default)]
struct WatchState {
    /// Arrival of the newest message.
    last: Option<Instant>,
    /// The present gap has been noticed.
    is_late: bool,
    missed: u64,
}

impl DeadlineWatch {
    pub(crate) fn new(
        graph: Arc<SharedGraph>,
        reader: Gid,
        topic: &str,
        deadline: Duration,
    ) -> Self {
        Self {
            graph,
            reader,
            topic: topic.to_owned(),
            deadline,
            state: Mutex::default(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, WatchState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A message came.
    pub(crate) fn arrived(&self) {
        let mut state = self.lock();
        state.last = Some(Instant::now());
        state.is_late = false;
    }

    /// Number of gaps that were longer than the deadline.
    pub(crate) fn missed(&self) -> u64 {
        self.lock().missed
    }
}

impl Chore for DeadlineWatch {
    fn run(&self) -> bool {
        // the lock of the graph ends here: `notice` takes it again
        let matched = self.graph.lock().matched_since(self.reader);
        let mut state = self.lock();
        let Some(since) = matched else {
            // without a publisher there is nothing to wait for
            state.is_late = false;
            return false;
        };
        let last = state.last.map_or(since, |last| last.max(since));
        if state.is_late || last.elapsed() <= self.deadline {
            return false;
        }
        state.is_late = true;
        state.missed += 1;
        drop(state);
        self.graph.notice(Notice::Deadline {
            topic: self.topic.clone(),
            deadline: self.deadline,
        });
        false
    }
}
