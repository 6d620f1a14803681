//! A call on the bus as a future: dropping it cancels the call.

use std::sync::Arc;

use asmotion_bus::{Bus, CallFailure, Notifier, Payload, Request, deadline_after};
use tokio::sync::Notify;
use tokio::time::timeout_at;

/// Calls an operation and waits for the response or, for a one-way call, for the provider to take the request.
///
/// # Errors
/// The failure of the call.
pub async fn call(
    bus: &dyn Bus,
    address: &str,
    request: Request,
    one_way: bool,
) -> Result<Payload, CallFailure> {
    let completion = Arc::new(Notify::new());
    let ring = Arc::clone(&completion);
    let notifier = Arc::new(Notifier::calling(move || ring.notify_one()));
    let until = deadline_after(request.timeout).into();
    let pending = if one_way {
        bus.call_one_way(address, request, notifier)
    } else {
        bus.call(address, request, notifier)
    };
    let pending = pending.map_err(|_| CallFailure::Unavailable)?;
    loop {
        if let Some(end) = pending.try_take() {
            return end;
        }
        // the call itself tells a reply from a timeout
        let _ = timeout_at(until, completion.notified()).await;
    }
}
