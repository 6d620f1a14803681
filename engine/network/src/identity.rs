//! A bus, and the process's identity on it.

use std::sync::Arc;

use asmotion_bus::{Bus, Notifier};

/// A bus that a system is attached to.
pub(crate) struct BusIdentity {
    pub bus: Arc<dyn Bus>,
    /// Numbers the lives of this process; no two processes share one. Messages that carry it are the process's own.
    pub incarnation: u64,
    /// The system's notifier, which wakes the thread that delivers.
    pub notifier: Arc<Notifier>,
}
