//! Services and publishers of the nodes of components.

use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use asmotion_datum::Datum;
use asmotion_ros2::{Node, Publisher, Qos, ReplyTo, Server, ServiceMapping};

use crate::wake::Wake;

/// Requests that wait for the bridge, for each service.
const WAITING: usize = 64;

/// A service of a node, such as `~/get_parameters`.
pub(crate) fn server(node: &Node, name: &str, of: &str, wake: &Wake) -> Result<Server, String> {
    let of = of.parse().map_err(|error| format!("{error}"))?;
    let name = format!("~/{name}");
    let server = node.server(&name, &of, ServiceMapping::OfPeer, WAITING);
    let server = server.map_err(|error| error.to_string())?;
    server.wake_with(Arc::clone(wake));
    Ok(server)
}

/// A publisher of a node, reliable and volatile.
pub(crate) fn publisher(
    node: &Node,
    topic: &str,
    of: &str,
    depth: usize,
) -> Result<Publisher, String> {
    let of = of.parse().map_err(|error| format!("{error}"))?;
    let publisher = node.publisher(topic, &of, Qos::default().depth(depth));
    publisher.map_err(|error| error.to_string())
}

/// Answers a request. The client gets no response if it does not fit the type, which would be a mistake here.
pub(crate) fn reply(server: &Server, to: &ReplyTo, response: &Datum) {
    let _ = server.reply(to, response);
}

/// Time since 1970, by the clock of the system.
pub(crate) fn since_1970() -> Duration {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap_or_default()
}
