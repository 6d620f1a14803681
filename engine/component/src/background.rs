//! Background work: what takes too long for a cycle runs beside it, and its result comes to a later cycle.
//!
//! A cycle neither blocks nor waits, so a component that reads files or solves something long hands that to
//! [`Cycle::spawn`](crate::Cycle::spawn) and looks for the result in the cycles that follow. Where the work runs is the
//! executor's affair:
//!
//! - Live: in a thread of its own. The component's thread goes on; when the work is done, the component gets a cycle,
//!   whatever drives it.
//! - Simulated: at once, in the caller's thread. A cycle takes no virtual time, so neither does
//!   the work: its result is there before the call returns, in the same cycle in each run, and traces stay equal.
//!
//! A component is written for the first case and is right in the second: it asks
//! [`BackgroundWork::take`] after it has spawned.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};

use crate::fault::Fault;
use crate::guard::guarded;

/// Where the work of a component runs; set by its executor.
#[derive(Clone, Default)]
pub enum WorkPlace {
    /// In the cycle.
    #[default]
    InCycle,
    /// In a thread of its own, which calls this when it has finished: a notification of the component.
    Thread(Arc<dyn Fn() + Send + Sync>),
}

/// Work under way beside the cycle. Dropping it forgets the result; the work itself runs to its end.
#[derive(Debug)]
pub struct BackgroundWork<T> {
    /// Written once by the work's thread. None once the result has been taken.
    result: Option<Receiver<Result<T, Fault>>>,
}

impl<T: Send + 'static> BackgroundWork<T> {
    pub(crate) fn spawn(place: &WorkPlace, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (sender, receiver) = mpsc::channel();
        let work = move || {
            // the receiver is gone if the component has forgotten the work
            let _ = sender.send(guarded(|| Ok(work())));
        };
        match place {
            WorkPlace::InCycle => work(),
            WorkPlace::Thread(finished) => {
                let finished = Arc::clone(finished);
                let builder = std::thread::Builder::new().name("background".to_owned());
                let spawned = builder.spawn(move || {
                    work();
                    finished();
                });
                // without a thread the sender is dropped, which `take` reports; a cycle must not do the work instead
                drop(spawned);
            }
        }
        Self {
            result: Some(receiver),
        }
    }

    /// The result, if it has come; handed over once. Does not wait.
    ///
    /// # Errors
    /// The fault of work that panicked, or that the system had no thread for.
    pub fn take(&mut self) -> Option<Result<T, Fault>> {
        let result = match self.result.as_ref()?.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(Fault::new("no thread for background work")),
        };
        self.result = None;
        Some(result)
    }
}
