//! Adapters: what joins a running system to something outside of it, such as a bus.

use asmotion_port::Time;

use crate::context::LiveContext;
use crate::effects::Effects;

/// Brings messages into a system and out of it, between cycles.
///
/// In a simulation the executor calls [`deliver`](Self::deliver) before each step. In a live system one thread, the bus
/// thread, calls it whenever the system's notifier ([`System::notifier`](crate::System::notifier)) is notified.
pub trait Adapter: Send {
    /// The system goes live; called once, before the bus thread starts. From now on threads of the adapter's own may put
    /// samples into ports, with a clone of the context as their effects.
    fn go_live(&mut self, context: &LiveContext) {
        let _ = context;
    }

    /// Lets in what has come, and lets out what waits. Must not block.
    fn deliver(&mut self, now: Time, effects: &mut dyn Effects);
}
