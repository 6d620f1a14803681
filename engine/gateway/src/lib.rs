//! Services over HTTP and JSON, for clients without access to the bus. Any HTTP client, such as `curl`, can call the
//! operations that a composite promotes.
//!
//! A [`Gateway`] translates between HTTP and any [`Bus`](asmotion_bus::Bus): a `POST` becomes a call with a deadline
//! and a typed result, and closing the connection cancels the call. `GET /services` lists the services with the JSON
//! Schemas of all types, and `GET /components` the components with their states. `docs/wire.md` is the specification for clients.
//!
//! An [`HttpClient`] calls services of other systems in the same form, as a [`ServiceClient`](asmotion_bus::ServiceClient).

mod access;
mod client;
mod components;
mod gateway;
mod handler;
mod listing;
mod parameters;
mod problem;
mod response;
mod service;
mod settings;

pub use asmotion_http::BearerToken;
pub use client::{HttpClient, HttpClientError};
pub use gateway::{Gateway, GatewayCheckError};
pub use service::{GatewayOperation, GatewayService};
pub use settings::GatewaySettings;
