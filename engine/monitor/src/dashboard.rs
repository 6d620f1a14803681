//! The dashboard: a server of what its source tells.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use asmotion_http::{ListenError, Listener, ListenerSettings};

use crate::bus_link::BusLink;
use crate::catalogue::SystemDescription;
use crate::desk::{Desk, OrderBus};
use crate::feed::Feed;
use crate::handler::{DashboardHandler, SessionTable};
use crate::past::Past;
#[cfg(feature = "recording")]
use crate::recorded::RecordedRun;
use crate::settings::DashboardSettings;

/// Limit on the time in which a request's header must arrive, and on the idle time of a connection.
const REQUEST_TIMEOUT: std::time::Duration = std::time::Duration::from_secs(10);

/// A system as a dashboard knows it: its feed and the way to control it.
pub struct MonitorSource {
    feed: Feed,
    orders: Option<OrderBus>,
    past: Option<Arc<dyn Past>>,
}

impl MonitorSource {
    /// Creates a source, whose feed is empty. `orders` is the bus over which the system can be controlled; a recording has none.
    /// `links` are the connections to other processes.
    pub fn new(
        description: SystemDescription,
        orders: Option<OrderBus>,
        links: Vec<BusLink>,
    ) -> Self {
        Self {
            feed: Feed::new(description, links),
            orders,
            past: None,
        }
    }

    /// A run that was recorded, which tabs show at any time. It cannot be controlled.
    #[cfg(feature = "recording")]
    pub fn recorded(run: RecordedRun) -> Self {
        Self {
            past: Some(Arc::new(run.past)),
            ..Self::new(run.system, None, Vec::new())
        }
    }

    /// The feed, which receives the events of the system.
    pub fn feed(&self) -> Feed {
        self.feed.clone()
    }
}

/// A name that no other run of this machine has.
fn run_name() -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
    let nanos = since_1970.unwrap_or_default().as_nanos();
    format!("{nanos}-{}", std::process::id())
}

/// An open dashboard. Dropping this closes it, after the tabs have received what is new.
#[derive(Debug)]
pub struct Dashboard(Listener);

impl Dashboard {
    /// Opens a dashboard.
    ///
    /// # Errors
    /// An error if it cannot listen at the address, or if no thread can be started.
    pub fn open(settings: DashboardSettings, source: MonitorSource) -> Result<Self, ListenError> {
        let listener = ListenerSettings {
            address: settings.listen,
            max_connections: settings.max_connections,
            request_timeout: REQUEST_TIMEOUT,
            thread: "dashboard",
        };
        let token = settings.control.clone();
        let or_free_port = settings.or_free_port;
        let handler = DashboardHandler {
            feed: source.feed,
            desk: Arc::new(Desk::new(source.orders, token, settings.armed_for)),
            sessions: SessionTable::new(),
            viewers: SessionTable::new(),
            skipped: Arc::default(),
            run: run_name().into(),
            past: source.past,
            repeater: Arc::default(),
            settings,
        };
        let handler = Arc::new(handler);
        let opened = match Listener::open(listener, Arc::clone(&handler)) {
            Err(ListenError::Listen { .. }) if or_free_port => {
                let address = SocketAddr::new(listener.address.ip(), 0);
                Listener::open(
                    ListenerSettings {
                        address,
                        ..listener
                    },
                    handler,
                )
            }
            opened => opened,
        };
        opened.map(Self)
    }

    /// The address it listens at, with the selected port.
    pub fn address(&self) -> SocketAddr {
        self.0.address()
    }
}
