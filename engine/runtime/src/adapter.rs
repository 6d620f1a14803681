//! Adapters join a running system to the outside, such as a bus.

use asmotion_port::Time;

use crate::context::LiveContext;
use crate::effects::Effects;

/// Moves messages into and out of a system, between cycles.
///
/// In a simulation the executor calls [`deliver`](Self::deliver) before each step. In a live system one thread, the bus
/// thread, calls it whenever the system's notifier ([`System::notifier`](crate::System::notifier)) is notified.
pub trait Adapter: Send {
    /// Prepares for live execution; called once, before the bus thread starts.
    ///
    /// From then on, the adapter's own threads may put samples into ports, with a clone of the context as their
    /// effects. The default does nothing.
    fn start_live(&mut self, context: &LiveContext) {
        let _ = context;
    }

    /// Moves messages that have arrived into the system, and waiting ones out of it. Must not block.
    fn deliver(&mut self, now: Time, effects: &mut dyn Effects);
}
