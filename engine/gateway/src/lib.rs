//! Services over HTTP and JSON, for those who are on no bus: `curl` calls what a composite promotes.
//!
//! A [`Gateway`] stands between HTTP and a [`Bus`](asmotion_bus::Bus), whichever: a `POST` is a request on it, with its deadline
//! and its typed end; who hangs up has taken the call back. What can be called it says itself, with the JSON Schema of
//! everything (`GET /services`). `docs/wire.md` describes all of it for callers.

mod call;
mod gateway;
mod handler;
mod listing;
mod parameters;
mod problem;
mod response;
mod service;

pub use gateway::{Gateway, GatewayCheckError, GatewaySettings};
pub use service::{GatewayOperation, GatewayService};
