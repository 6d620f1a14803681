//! HTTP servers of a process: gateway and dashboard.
//!
//! A [`Listener`] accepts connections for an [`HttpHandler`] in a thread of its own, limits their number, and shuts down in order.
//! [`host_of`] and [`is_host_allowed`] tell requests that address this server from those that a web page has redirected;
//! [`BearerToken`] identifies clients. [`call`] is a call on a [`Bus`](asmotion_bus::Bus) as a future.

mod call;
mod connections;
mod host;
mod listener;
mod token;
mod upgrade;

pub use call::call;
pub use connections::{CallGuard, ConnectionPlace};
pub use host::{host_of, is_host_allowed};
pub use listener::{
    HttpHandler, HttpRequest, HttpResponse, ListenError, Listener, ListenerSettings,
};
pub use token::BearerToken;
pub use upgrade::upgraded_stream;
