//! Topics between processes: publish and subscribe, request and reply, behind one trait.
//!
//! [`Bus`] is the seam; [`Local`] is the bus inside one process. Every back end passes the same suite,
//! [`contract::violations`]. Inside a process components are joined directly; the bus carries their topics to tools
//! and to other processes.

mod bus;
pub mod contract;
mod deadline;
mod envelope;
mod health;
mod local;
mod pattern;
mod queue;
mod request;
mod sending;
mod trace;

pub use asmotion_connection::Notifier;
pub use bus::{Bus, BusError, Origin, Publisher};
pub use deadline::later;
pub use envelope::{Envelope, Payload};
pub use health::{Health, Link};
pub use local::Local;
pub use pattern::Pattern;
pub use queue::{Inlet, Overflow, Queue, Received, Subscription};
pub use request::{Call, CallFailure, Delivered, Desk, Pending, Refusal, Request, Serving};
pub use sending::{Assurance, Outage, Sending, Sent};
pub use trace::{NoTrace, Spans, Trace};
