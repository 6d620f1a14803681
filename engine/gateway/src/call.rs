//! A call on the bus as a future: dropping it cancels the call.

use std::sync::Arc;

use asmotion_bus::{Bus, CallFailure, Notifier, Payload, Request, later};
use tokio::sync::Notify;
use tokio::time::timeout_at;

/// Calls an operation and waits for the response or, for a one-way call, for the provider to take the request.
pub(crate) async fn call(
    bus: &dyn Bus,
    address: &str,
    request: Request,
    one_way: bool,
) -> Result<Payload, CallFailure> {
    let news = Arc::new(Notify::new());
    let ring = Arc::clone(&news);
    let notifier = Arc::new(Notifier::calling(move || ring.notify_one()));
    let until = later(request.timeout).into();
    let begun = if one_way {
        bus.tell(address, request, notifier)
    } else {
        bus.call(address, request, notifier)
    };
    let pending = begun.map_err(|_| CallFailure::Unavailable)?;
    loop {
        if let Some(end) = pending.try_take() {
            return end;
        }
        // the call itself tells a reply from a timeout
        let _ = timeout_at(until, news.notified()).await;
    }
}
