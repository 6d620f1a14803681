//! The connection of a request that has been upgraded to another protocol.

use hyper::body::Bytes;
use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::net::TcpStream;

/// The stream of an upgraded connection of a [`Listener`](crate::Listener), and the bytes that were read from it already; `None` for the
/// connection of another server.
pub fn upgraded_stream(upgraded: Upgraded) -> Option<(TcpStream, Bytes)> {
    let parts = upgraded.downcast::<TokioIo<TcpStream>>().ok()?;
    Some((parts.io.into_inner(), parts.read_buf))
}
