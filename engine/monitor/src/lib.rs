//! Shows a running system in a web browser, and exports its figures to Prometheus.
//!
//! ```text
//! source ── events ──→ Feed: newest samples, rings of steps and log entries, presence
//!   │                   │ read by cursors, never waited for
//!   │                   ├─→ /live: one WebSocket for each tab, a frame for each tick
//!   │                   ├─→ /foxglove: one WebSocket for each viewer, in the protocol of Foxglove
//!   │                   └─→ /metrics, /api
//!   └── Desk ←── orders of the tab that is armed
//! ```
//!
//! A [`MonitorSource`] is all that the server knows of a system: a description, a [`Feed`], the connections to
//! buses and, if it can be controlled, a bus for orders. A running system writes to its feed as an [`Observer`](asmotion_runtime::Observer).

mod assets;
mod bus_link;
mod catalogue;
mod client;
mod command_log;
mod dashboard;
mod desk;
mod feed;
mod foxglove;
mod frame;
mod guard;
mod handler;
mod log_entry;
mod login;
mod metrics;
mod output_slot;
mod page_request;
mod past;
#[cfg(feature = "recording")]
mod recorded;
#[cfg(feature = "recording")]
mod recording_description;
mod rendering;
mod ring;
mod session;
mod settings;
mod socket;
mod specification_state;
mod step_guards;
mod subscriptions;
mod ticker;
mod under_way;

pub use asmotion_http::BearerToken;
pub use bus_link::BusLink;
pub use catalogue::SystemDescription;
pub use dashboard::{Dashboard, MonitorSource};
pub use desk::OrderBus;
pub use feed::Feed;
#[cfg(feature = "recording")]
pub use recorded::RecordedRun;
pub use settings::{DashboardSettings, RandomError};
