//! The dashboard of a mission.

#[cfg(not(feature = "dashboard"))]
mod left_out;
#[cfg(feature = "dashboard")]
mod open;

#[cfg(not(feature = "dashboard"))]
pub(super) use left_out::OpenDashboard;
#[cfg(feature = "dashboard")]
pub(super) use open::OpenDashboard;
#[cfg(all(feature = "dashboard", feature = "mcap"))]
pub(crate) use open::dashboard_settings;

use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

/// The dashboard of a mission.
#[derive(Clone, Debug, Default)]
pub enum MissionDashboard {
    /// No dashboard is opened.
    #[default]
    Closed,
    /// A dashboard listens while the mission runs.
    Open {
        /// Address to listen at; `None` selects port 7070 of 127.0.0.1, or a free port if it is in use.
        listen: Option<SocketAddr>,
        /// Whether a tab with the token can control the system.
        control: bool,
        /// Pages of other servers that may read over the protocol of Foxglove, as origins.
        allowed_origins: Vec<String>,
        /// Called with the address.
        on_open: DashboardCallback,
    },
}

/// Callback for the opened dashboard: receives its URL.
#[derive(Clone)]
pub struct DashboardCallback(
    #[cfg_attr(
        not(feature = "dashboard"),
        allow(dead_code, reason = "nothing listens")
    )]
    Arc<dyn Fn(&str) + Send + Sync>,
);

impl DashboardCallback {
    /// Wraps a function.
    pub fn new(callback: impl Fn(&str) + Send + Sync + 'static) -> Self {
        Self(Arc::new(callback))
    }
}

impl fmt::Debug for DashboardCallback {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("DashboardCallback")
    }
}

impl MissionDashboard {
    /// Returns `true` if a dashboard is opened.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Open { .. })
    }
}
