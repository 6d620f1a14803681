//! The bus thread calls the adapters of a live system.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use asmotion_port::Notifier;

use crate::adapter::Adapter;
use crate::context::LiveContext;

/// Longest sleep between two deliveries.
const NAP: Duration = Duration::from_millis(100);

/// The thread that owns the adapters. Dropping this sets `ended`, notifies the thread and joins it; the thread delivers once more.
pub(crate) struct BusThread {
    /// Set by the owner, read by the thread before each delivery; the one that sees it is the last.
    ended: Arc<AtomicBool>,
    notifier: Arc<Notifier>,
    thread: Option<JoinHandle<()>>,
}

impl BusThread {
    pub(crate) fn new(
        mut adapters: Vec<Box<dyn Adapter>>,
        notifier: Arc<Notifier>,
        mut context: LiveContext,
    ) -> Self {
        for adapter in &mut adapters {
            adapter.start_live(&context);
        }
        let ended = Arc::new(AtomicBool::new(false));
        let (ending, notified) = (Arc::clone(&ended), Arc::clone(&notifier));
        let work = move || {
            loop {
                // read first: what components sent before the end is delivered below
                let is_last = ending.load(Ordering::Acquire);
                for adapter in &mut adapters {
                    adapter.deliver(context.now(), &mut context);
                }
                if is_last {
                    return;
                }
                notified.wait(NAP);
            }
        };
        let thread = std::thread::Builder::new().name("bus".to_owned());
        Self {
            ended,
            notifier,
            thread: thread.spawn(work).ok(),
        }
    }
}

impl Drop for BusThread {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Release);
        self.notifier.notify();
        if let Some(thread) = self.thread.take() {
            // returns soon: the thread runs only adapters, which do not block
            let _ = thread.join();
        }
    }
}
