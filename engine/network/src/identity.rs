//! A bus, and the process's identity on it.

use std::sync::Arc;

use asmotion_bus::{Bus, Notifier};

/// A bus that a system is attached to.
pub(crate) struct BusIdentity {
    pub bus: Arc<dyn Bus>,
    /// Number of this process' incarnation, unique among all processes. Messages that carry it were sent by this
    /// process.
    pub incarnation: u64,
    /// The system's notifier, which wakes the thread that delivers.
    pub notifier: Arc<Notifier>,
}
