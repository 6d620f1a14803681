//! The protocol of Foxglove and Lichtblick: a viewer reads topics, outputs, specifications and the log of a running system.
//!
//! The client subscribes to channels and acknowledges nothing. So each batch of messages ends with a ping, and the server has at
//! most two batches under way that no pong has answered: a viewer that cannot follow receives the newest samples when it continues,
//! and not those that have waited in the socket meanwhile. It can change nothing.
//!
//! Specification: <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>. `foxglove.sdk.v1` is a later name of the same
//! messages, as far as they are used here.

mod channels;
mod messages;
mod viewer;

use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;

use hyper::header::{SEC_WEBSOCKET_PROTOCOL, UPGRADE};
use hyper::upgrade::Upgraded;
use hyper::{HeaderMap, Uri};
use serde_json::{Value, json};
use tokio::sync::watch;
use tokio_tungstenite::tungstenite::protocol::frame::coding::CloseCode;
use tokio_tungstenite::tungstenite::{Error, Message};

use crate::feed::Feed;
use crate::settings::DashboardSettings;
use crate::socket::{self, ClientSocket, closed, next, refuse, send, send_all, ticks};
use viewer::Viewer;

/// Path of the WebSocket. Viewers also find it at the root, where browsers find the page.
pub(crate) const PATH: &str = "/foxglove";

/// The names of the protocol that the server speaks.
pub(crate) const PROTOCOLS: &[&str] = &["foxglove.websocket.v1", "foxglove.sdk.v1"];

/// Interval between batches of messages.
const INTERVAL: Duration = Duration::from_micros(16_667);

/// Returns whether a request addresses this protocol.
pub(crate) fn is_addressed(uri: &Uri, headers: &HeaderMap) -> bool {
    uri.path() == PATH || uri.path() == "/" && headers.contains_key(UPGRADE)
}

/// The first name of the protocol that the client offers and the server speaks.
pub(crate) fn protocol(headers: &HeaderMap) -> Option<&'static str> {
    let lists = headers.get_all(SEC_WEBSOCKET_PROTOCOL).iter();
    let offered = lists.filter_map(|list| list.to_str().ok());
    let mut offered = offered.flat_map(|list| list.split(',').map(str::trim));
    offered.find_map(|name| PROTOCOLS.iter().copied().find(|known| *known == name))
}

/// A session with a viewer.
pub(crate) struct FoxgloveSession {
    pub settings: DashboardSettings,
    pub feed: Feed,
    /// Identifies the run, so that a viewer does not mix it with the next one.
    pub run: Arc<str>,
    /// Number of messages that no viewer could follow.
    pub skipped: Arc<AtomicU64>,
}

impl FoxgloveSession {
    /// Runs the session until the viewer or the dashboard closes it.
    pub(crate) async fn run(self, upgraded: Upgraded, closing: watch::Receiver<bool>) {
        let mut socket = socket::open(upgraded, self.settings.max_message).await;
        let _ = self.serve(&mut socket, closing).await;
        socket::end(&mut socket).await;
    }

    /// Serves the viewer. Returns an error if the connection is broken.
    async fn serve(
        &self,
        socket: &mut ClientSocket,
        mut closing: watch::Receiver<bool>,
    ) -> Result<(), Error> {
        send(socket, self.server_info().to_string()).await?;
        let mut viewer = Viewer::new(self.settings.max_channels, Arc::clone(&self.skipped));
        let mut ticks = ticks(INTERVAL);
        loop {
            tokio::select! {
                message = next(socket) => match message {
                    Some(Ok(Message::Text(text))) => {
                        for problem in viewer.request(&text, &self.feed) {
                            send(socket, problem.to_string()).await?;
                        }
                    }
                    Some(Ok(Message::Pong(batch))) => viewer.acknowledge(&batch),
                    Some(Ok(Message::Close(_))) | None => return Ok(()),
                    Some(Ok(Message::Ping(_) | Message::Frame(_))) => {}
                    Some(Ok(Message::Binary(_))) => return refuse(socket, CloseCode::Unsupported).await,
                    Some(Err(Error::Capacity(_))) => return refuse(socket, CloseCode::Size).await,
                    Some(Err(error)) => return Err(error),
                },
                _ = ticks.tick() => {
                    if viewer.is_gone() {
                        return Err(Error::ConnectionClosed);
                    }
                    let batch = viewer.batch(&self.feed);
                    if !batch.is_empty() {
                        send_all(socket, batch).await?;
                    }
                }
                () = closed(&mut closing) => {
                    let batch = viewer.batch(&self.feed);
                    send_all(socket, batch).await?;
                    return refuse(socket, CloseCode::Away).await;
                }
            }
        }
    }

    /// The first message.
    fn server_info(&self) -> Value {
        let system = self.feed.system();
        let profile = system.profile.as_deref().unwrap_or_default();
        json!({
            "op": "serverInfo", "name": format!("asmotion: {}", system.name), "capabilities": ["time"],
            "metadata": { "composite": system.name, "profile": profile, "clock": system.clock },
            "sessionId": &*self.run,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::protocol;
    use hyper::HeaderMap;
    use hyper::header::{HeaderValue, SEC_WEBSOCKET_PROTOCOL};

    #[test]
    fn the_clients_first_choice_among_the_known_names_is_spoken() {
        let chosen = |lists: &[&'static str]| {
            let mut headers = HeaderMap::new();
            for list in lists {
                headers.append(SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(list));
            }
            protocol(&headers)
        };
        assert_eq!(
            chosen(&["foxglove.sdk.v1, foxglove.websocket.v1"]),
            Some("foxglove.sdk.v1")
        );
        assert_eq!(
            chosen(&["foxglove.sdk.v2", "foxglove.websocket.v1"]),
            Some("foxglove.websocket.v1")
        );
        assert_eq!(chosen(&["foxglove.sdk.v2,chat"]), None);
        assert_eq!(chosen(&[]), None);
    }
}
