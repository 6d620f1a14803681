//! The gateway: a listener whose handler calls services on a bus.

use std::net::SocketAddr;
use std::sync::Arc;

use asmotion_bus::{Bus, BusError};
use asmotion_http::{ListenError, Listener, ListenerSettings};

use crate::components::ComponentListing;
use crate::handler::RequestHandler;
use crate::service::GatewayService;
use crate::settings::GatewaySettings;

/// An error when a gateway opens.
#[derive(Debug, thiserror::Error)]
pub enum GatewayCheckError {
    /// The gateway cannot listen.
    #[error(transparent)]
    Listen(ListenError),
    /// The bus refuses the subscription to the descriptions of components.
    #[error("cannot subscribe to the components: {0}")]
    Components(BusError),
}

/// An open gateway. Dropping this closes it: new connections are refused, and calls under way have two seconds to end.
#[derive(Debug)]
pub struct Gateway(Listener);

impl Gateway {
    /// Opens a gateway to services on a bus, each operation of which has the address `SERVICE.OPERATION`. The components
    /// are those that the process describes on this bus.
    ///
    /// # Errors
    /// An error if the gateway cannot listen at the address, if the bus refuses it, or if no thread can be started.
    pub fn open(
        settings: GatewaySettings,
        services: Vec<GatewayService>,
        bus: Arc<dyn Bus>,
    ) -> Result<Self, GatewayCheckError> {
        let components = ComponentListing::new(&*bus).map_err(GatewayCheckError::Components)?;
        let listener = ListenerSettings {
            address: settings.listen,
            max_connections: settings.max_connections,
            request_timeout: settings.request_timeout,
            thread: "http",
        };
        let handler = RequestHandler {
            services,
            components,
            bus,
            settings,
        };
        let opened = Listener::open(listener, Arc::new(handler));
        opened.map(Self).map_err(GatewayCheckError::Listen)
    }

    /// The address it listens at, with the selected port.
    pub fn address(&self) -> SocketAddr {
        self.0.address()
    }
}
