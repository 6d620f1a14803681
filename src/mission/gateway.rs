//! HTTP gateways of a mission.

#[cfg(not(feature = "http"))]
mod left_out;
#[cfg(feature = "http")]
mod open;

use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

use asmotion_plan::Part;

use super::Mission;

/// Gateways of a mission.
#[derive(Clone, Debug, Default)]
pub enum MissionGateways {
    /// No gateway is opened.
    #[default]
    Closed,
    /// Gateways listen at the addresses in the composite.
    Open {
        /// Overriding addresses, as pairs of gateway and address.
        address_overrides: Vec<(String, SocketAddr)>,
        /// Called with each gateway.
        on_listen: ListenCallback,
    },
}

/// A gateway that has been opened.
#[derive(Clone, Copy, Debug)]
pub struct ListeningGateway<'a> {
    /// Name in the composite.
    pub name: &'a str,
    /// The address it listens at, with the port that the system chose for port 0.
    pub address: SocketAddr,
    /// Whether callers need a token.
    pub needs_token: bool,
}

/// Callback for each opened gateway.
#[derive(Clone)]
pub struct ListenCallback(
    #[cfg_attr(not(feature = "http"), allow(dead_code, reason = "nothing listens"))]
    Arc<ListenFunction>,
);

type ListenFunction = dyn Fn(ListeningGateway<'_>) + Send + Sync;

impl ListenCallback {
    /// Wraps a function.
    pub fn new(callback: impl Fn(ListeningGateway<'_>) + Send + Sync + 'static) -> Self {
        Self(Arc::new(callback))
    }
}

impl fmt::Debug for ListenCallback {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str("Told")
    }
}

impl MissionGateways {
    /// Returns `true` if gateways are opened.
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Open { .. })
    }
}

impl Mission {
    /// Names of the composite's gateways for this process; empty if the composite has errors, which the run reports.
    pub fn named_gateways(&self) -> Vec<String> {
        let names = self.with_plan(|plan| {
            let requested = self.process.as_ref();
            let process = plan.processes.iter().find(|it| Some(&it.name) == requested);
            let part = process.map_or(Part::Whole, Part::of);
            let gateways = plan.gateways_of(&part).into_iter();
            gateways.map(|(gateway, _)| gateway.name.clone()).collect()
        });
        names.unwrap_or_default()
    }
}
