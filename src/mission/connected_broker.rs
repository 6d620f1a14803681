//! Connections to brokers.

use std::sync::Arc;

use asmotion_bus::Bus;

/// A connection to a broker.
pub(super) struct ConnectedBroker {
    /// Name of the broker in the composite; `None` if it carries everything.
    pub name: Option<String>,
    /// Address of the broker, without credentials.
    pub location: String,
    /// Why its login is dangerous.
    #[cfg_attr(
        not(feature = "dashboard"),
        allow(dead_code, reason = "only the dashboard shows it")
    )]
    pub warning: Option<String>,
    pub bus: Arc<dyn Bus>,
}
