//! The queues of an input port.

use std::sync::{Arc, Mutex, PoisonError};

use asmotion_connection::QueueGauge;

/// The queues of the connections into an input port, by which any thread learns how many samples wait there. Shared by the port and
/// those who open connections into it; neither end of a connection uses it.
#[derive(Clone, Default)]
pub(crate) struct QueueGauges(Arc<Mutex<Vec<QueueGauge>>>);

impl QueueGauges {
    /// Adds the queue of a connection, unless another connection has the same one.
    pub(crate) fn add(&self, gauge: QueueGauge) {
        let mut gauges = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        gauges.retain(|it| !it.is_gone());
        if !gauges.iter().any(|it| it.is_same(&gauge)) {
            gauges.push(gauge);
        }
    }

    /// Number of samples that wait in all queues.
    pub(crate) fn waiting(&self) -> u64 {
        let gauges = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        gauges.iter().map(|it| it.waiting() as u64).sum()
    }
}
