//! The protocol of Foxglove and Lichtblick: a viewer reads topics, outputs, specifications and the log of a running system.
//!
//! The client subscribes to channels and acknowledges nothing. So batches of messages end with a ping, and the server has at most
//! two pings under way that no pong has answered: a viewer that cannot follow receives the newest samples when it continues, and not
//! those that have waited in the socket meanwhile. It can change nothing.
//!
//! Specification: <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>. `foxglove.sdk.v1` is a later name of the same
//! messages, as far as they are used here.

mod channels;
mod messages;
mod shared_messages;
mod viewer;

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use hyper::header::{SEC_WEBSOCKET_PROTOCOL, UPGRADE};
use hyper::upgrade::Upgraded;
use hyper::{HeaderMap, Uri};
use serde_json::{Value, json};
use tokio::sync::{mpsc, watch};

use crate::client::serve;
use crate::feed::Feed;
use crate::settings::DashboardSettings;
use crate::ticker::Ticker;
pub(crate) use shared_messages::SharedMessages;
use viewer::Viewer;

/// Path of the WebSocket. Viewers also find it at the root, where browsers find the page.
pub(crate) const PATH: &str = "/foxglove";

/// The names of the protocol that the server speaks.
pub(crate) const PROTOCOLS: &[&str] = &["foxglove.websocket.v1", "foxglove.sdk.v1"];

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
    pub(crate) async fn run(
        self,
        upgraded: Upgraded,
        ticker: Arc<Ticker<SharedMessages>>,
        closing: watch::Receiver<bool>,
    ) {
        let info = self.server_info().to_string();
        let max_message = self.settings.max_message;
        let viewer = Viewer::new(info, self.feed, self.settings.max_channels, self.skipped);
        // what it sends is answered at once
        let (_, replied) = mpsc::channel(1);
        serve((upgraded, max_message), viewer, &ticker, replied, closing).await;
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
