//! Services over HTTP and JSON, for those who are on no bus: `curl` calls what a composite promotes.
//!
//! A [`Gateway`] stands between HTTP and a [`Bus`](asmotion_bus::Bus), whichever: a `POST` is a request on it, with its deadline
//! and its typed end; who hangs up has taken the call back. What can be called it says itself, with the JSON Schema of
//! everything (`GET /services`). `docs/wire.md` describes all of it for callers.

mod answer;
mod call;
mod gateway;
mod problem;
mod question;
mod reception;
mod service;
mod shown;

pub use gateway::{Gateway, GatewayError, Settings};
pub use service::{Operation, Service};
