//! The trait of everything that carries calls to services.

use std::sync::Arc;

use crate::bus::BusError;
use crate::request::{PendingCall, Request};
use asmotion_connection::Notifier;

/// Calls services: over a bus, or over a protocol that carries nothing else.
pub trait ServiceClient: Send + Sync {
    /// Sends a request to an address. A call ends with a reply or a [`CallFailure`](crate::CallFailure), a one-way call
    /// when the provider has taken the request; both end at the deadline at the latest. Never blocks.
    ///
    /// # Errors
    /// [`BusError::InvalidName`] if the address is invalid; failures of the call itself arrive in the [`PendingCall`].
    fn call(
        &self,
        address: &str,
        request: Request,
        one_way: bool,
        notifier: Arc<Notifier>,
    ) -> Result<PendingCall, BusError>;
}
