//! Background work: runs beside the cycles of a component, and returns its result to a later cycle.
//!
//! A cycle neither blocks nor waits, so a component that reads files or computes for long passes that work to
//! [`Cycle::spawn`](crate::Cycle::spawn) and checks for the result in the following cycles. The executor decides where
//! the work runs:
//!
//! - Live: in a thread of its own. The component's thread continues; when the work is done, the component gets a cycle,
//!   whatever drives it.
//! - Simulated: at once, in the caller's thread. A cycle takes no virtual time, so neither does
//!   the work: its result is there before the call returns, in the same cycle in each run, and traces stay equal.
//!
//! A component written for the first case is correct in the second, if it calls [`BackgroundWork::take`] in the cycle
//! that spawns the work too.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, TryRecvError};

use crate::fault::Fault;
use crate::guard::guarded;

/// The thread in which a component's background work runs; set by its executor.
#[derive(Clone, Default)]
pub enum WorkPlace {
    /// The component's own thread, within the cycle.
    #[default]
    InCycle,
    /// A new thread, which requests a cycle of the component at its end.
    Thread(CycleRequests),
}

/// Functions that request a cycle of a component, whatever drives it, from any thread and at any time.
#[derive(Clone)]
pub struct CycleRequests {
    /// Wakes the component's thread.
    pub wake: Arc<dyn Fn() + Send + Sync>,
    /// Lends the calling thread to the cycle ([`Setup::thread_lender`](crate::Setup::thread_lender)).
    pub lend_thread: Arc<dyn Fn() + Send + Sync>,
}

/// Work under way beside the cycles. Dropping it discards the result; the work itself runs to its end.
#[derive(Debug)]
pub struct BackgroundWork<T> {
    /// Receives one result from the work's thread. `None` once the result has been taken.
    result: Option<Receiver<Result<T, Fault>>>,
}

impl<T: Send + 'static> BackgroundWork<T> {
    pub(crate) fn spawn(place: &WorkPlace, work: impl FnOnce() -> T + Send + 'static) -> Self {
        let (sender, receiver) = mpsc::channel();
        let work = move || {
            // fails if the component has dropped the work
            let _ = sender.send(guarded(|| Ok(work())));
        };
        match place {
            WorkPlace::InCycle => work(),
            WorkPlace::Thread(requests) => {
                let finished = Arc::clone(&requests.wake);
                let builder = std::thread::Builder::new().name("background".to_owned());
                let spawned = builder.spawn(move || {
                    work();
                    finished();
                });
                // without a thread the sender is dropped, which `take` reports; running the work here would block the
                // cycle
                drop(spawned);
            }
        }
        Self {
            result: Some(receiver),
        }
    }

    /// Returns the result once it is available, and `None` before and afterwards. Does not block.
    ///
    /// # Errors
    /// A fault, if the work panicked or no thread could be started.
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
