//! The connections of a process to its buses, as tabs and `/metrics` show them.

use std::sync::Arc;
use std::time::Instant;

use asmotion_bus::{Bus, LinkState};
use serde_json::{Value, json};

/// A connection to a bus over which the system talks to others.
#[derive(Clone)]
pub struct BusLink {
    /// The address of the broker, without credentials.
    pub name: String,
    /// Warning about its login, with a way out; `None` if there is none.
    pub warning: Option<String>,
    /// The bus, which is asked for its [health](Bus::health).
    pub bus: Arc<dyn Bus>,
}

/// State of a connection at a moment.
pub(crate) struct LinkSummary<'l> {
    pub name: &'l str,
    pub state: LinkState,
    /// Seconds since the state began.
    pub for_s: f64,
}

impl BusLink {
    /// The state at a time.
    pub(crate) fn summary(&self, now: Instant) -> LinkSummary<'_> {
        let health = self.bus.health();
        LinkSummary {
            name: &self.name,
            state: health.link,
            for_s: now.saturating_duration_since(health.since).as_secs_f64(),
        }
    }
}

impl LinkSummary<'_> {
    /// Returns whether messages flow in both directions.
    pub(crate) fn is_up(&self) -> bool {
        self.state == LinkState::Up
    }

    /// As JSON: `name`, `state` (`up`, `blocked` or `down`), `reason` and `for_s`.
    pub(crate) fn json(&self) -> Value {
        let (state, reason) = match &self.state {
            LinkState::Up => ("up", ""),
            LinkState::Blocked { reason } => ("blocked", &**reason),
            LinkState::Down { reason } => ("down", &**reason),
        };
        json!({ "name": self.name, "state": state, "reason": reason, "for_s": self.for_s })
    }
}
