//! Handles the requests of browsers and other programs.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use asmotion_http::{ConnectionPlace, HttpHandler, HttpRequest, HttpResponse};
use hyper::header::{
    CONNECTION, HeaderValue, SEC_WEBSOCKET_ACCEPT, SEC_WEBSOCKET_KEY, SEC_WEBSOCKET_PROTOCOL,
    SEC_WEBSOCKET_VERSION, SET_COOKIE, UPGRADE,
};
use hyper::upgrade::Upgraded;
use hyper::{Method, StatusCode};
use tokio::sync::watch;
use tungstenite::handshake::derive_accept_key;

use crate::desk::Desk;
use crate::feed::Feed;
use crate::foxglove::{FoxgloveSession, SharedMessages};
use crate::frame::SharedFrames;
use crate::metrics::ConnectionFigures;
use crate::past::Past;
use crate::session::Session;
use crate::settings::DashboardSettings;
use crate::step_guards::StepRepeater;
use crate::ticker::{Shared, Ticker};
use crate::{assets, foxglove, frame, guard, login, metrics};

const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// Handles the requests of all connections.
pub(crate) struct DashboardHandler {
    pub settings: DashboardSettings,
    pub feed: Feed,
    pub desk: Arc<Desk>,
    /// The open tabs.
    pub sessions: SessionTable<SharedFrames>,
    /// The connected viewers.
    pub viewers: SessionTable<SharedMessages>,
    /// Number of messages that viewers could not follow.
    pub skipped: Arc<AtomicU64>,
    /// Name of the run for viewers.
    pub run: Arc<str>,
    /// The run, if it is over and was recorded.
    pub past: Option<Arc<dyn Past>>,
    /// Repeats steps for tabs that ask how they came about.
    pub repeater: Arc<StepRepeater>,
}

/// The open WebSockets.
pub(crate) struct SessionTable<S> {
    /// Number of the next one.
    next: AtomicU64,
    /// Their clock.
    ticker: Arc<Ticker<S>>,
    /// Each session holds a receiver, by which they are counted; the value is set when all have to end.
    pub closing: watch::Sender<bool>,
}

impl<S: Shared> SessionTable<S> {
    pub(crate) fn new() -> Self {
        Self {
            next: AtomicU64::new(1),
            ticker: Ticker::new(),
            closing: watch::Sender::new(false),
        }
    }

    /// Number of open WebSockets.
    pub(crate) fn count(&self) -> usize {
        self.closing.receiver_count()
    }
}

impl HttpHandler for DashboardHandler {
    async fn respond(
        &self,
        request: HttpRequest,
        from: SocketAddr,
        place: &Arc<ConnectionPlace>,
    ) -> HttpResponse {
        let is_viewer = foxglove::is_addressed(request.uri(), request.headers());
        let allowed: &[String] = if is_viewer {
            &self.settings.allowed_origins
        } else {
            &[]
        };
        if let Err((status, text)) = guard::check(request.uri(), request.headers(), allowed) {
            return guard::response(status, TEXT, text + "\n");
        }
        let path = request.uri().path().to_owned();
        if path == "/live" {
            return self.tab(request, from, place);
        }
        if is_viewer {
            return self.viewer(request, place);
        }
        if path == "/login" {
            return self.log_in(&request);
        }
        if request.method() != Method::GET && request.method() != Method::HEAD {
            return guard::response(StatusCode::METHOD_NOT_ALLOWED, TEXT, "use `GET`\n");
        }
        self.read(&path)
    }

    fn busy(&self) -> HttpResponse {
        let text = "too many connections: close a tab\n";
        guard::response(StatusCode::SERVICE_UNAVAILABLE, TEXT, text)
    }

    async fn close(&self) {
        self.sessions.closing.send_replace(true);
        self.viewers.closing.send_replace(true);
        self.sessions.closing.closed().await;
        self.viewers.closing.closed().await;
    }
}

impl DashboardHandler {
    /// Responds to a request that changes nothing.
    fn read(&self, path: &str) -> HttpResponse {
        let json = |body: String| guard::response(StatusCode::OK, JSON, body + "\n");
        let is_live = path == "/metrics" || path.starts_with("/api/") && path != "/api/system";
        if self.past.is_some() && is_live {
            return not_found("a recording has no present: `/api/system` describes it\n");
        }
        match path {
            "/metrics" => {
                let text = metrics::text(&self.feed, &self.connections());
                guard::response(StatusCode::OK, metrics::CONTENT_TYPE, text)
            }
            "/api/system" => json(serde_json::to_string(&*self.feed.system()).unwrap_or_default()),
            "/api/outputs" => json(frame::outputs_json(&self.feed)),
            "/api/components" => {
                let presence = self.feed.state().presence.clone();
                json(presence.map_or_else(|| "null".to_owned(), |it| it.json.to_string()))
            }
            "/api/states" => {
                let states = serde_json::to_string(&self.feed.state().specifications);
                json(states.unwrap_or_default())
            }
            path => {
                if let Some(name) = path.strip_prefix("/api/output/") {
                    let newest = self.feed.output(name).and_then(|slot| slot.newer_than(0));
                    return match newest {
                        Some(newest) => json(newest.json().to_string()),
                        None => not_found("no such output has written: `/api/outputs` lists all\n"),
                    };
                }
                match assets::find(path) {
                    Some((kind, text)) => guard::response(StatusCode::OK, kind, text),
                    None => not_found("no such page\n"),
                }
            }
        }
    }

    fn connections(&self) -> ConnectionFigures {
        ConnectionFigures {
            tabs: self.sessions.count(),
            viewers: self.viewers.count(),
            skipped: self.skipped.load(Ordering::Relaxed),
        }
    }

    /// Opens the WebSocket of a tab.
    fn tab(
        &self,
        request: HttpRequest,
        from: SocketAddr,
        place: &Arc<ConnectionPlace>,
    ) -> HttpResponse {
        let session = Session {
            client: self.sessions.next.fetch_add(1, Ordering::Relaxed),
            name: from.to_string(),
            has_logged_in: login::has_logged_in(request.headers(), &self.desk),
            settings: self.settings.clone(),
            feed: self.feed.clone(),
            desk: Arc::clone(&self.desk),
            past: self.past.clone(),
            repeater: Arc::clone(&self.repeater),
        };
        let closing = self.sessions.closing.subscribe();
        let ticker = Arc::clone(&self.sessions.ticker);
        upgrade(request, place, None, |upgraded| {
            session.run(upgraded, ticker, closing)
        })
    }

    /// Lets a browser log in, whose page presents the token.
    fn log_in(&self, request: &HttpRequest) -> HttpResponse {
        if request.method() != Method::POST {
            return guard::response(StatusCode::METHOD_NOT_ALLOWED, TEXT, "use `POST`\n");
        }
        match login::log_in(request.headers(), &self.desk) {
            Ok(cookie) => {
                let mut response = guard::response(StatusCode::NO_CONTENT, TEXT, "");
                response.headers_mut().insert(SET_COOKIE, cookie);
                response
            }
            Err(reason) => guard::response(StatusCode::UNAUTHORIZED, TEXT, format!("{reason}\n")),
        }
    }

    /// Opens the WebSocket of a viewer.
    fn viewer(&self, request: HttpRequest, place: &Arc<ConnectionPlace>) -> HttpResponse {
        if self.past.is_some() {
            return not_found(
                "a recording has no present: open its file in Foxglove or Lichtblick\n",
            );
        }
        let Some(protocol) = foxglove::protocol(request.headers()) else {
            let known = foxglove::PROTOCOLS.join("` or `");
            let text = format!("a WebSocket with the subprotocol `{known}` is expected here\n");
            return guard::response(StatusCode::BAD_REQUEST, TEXT, text);
        };
        let session = FoxgloveSession {
            settings: self.settings.clone(),
            feed: self.feed.clone(),
            run: Arc::clone(&self.run),
            skipped: Arc::clone(&self.skipped),
        };
        let closing = self.viewers.closing.subscribe();
        let ticker = Arc::clone(&self.viewers.ticker);
        upgrade(request, place, Some(protocol), |upgraded| {
            session.run(upgraded, ticker, closing)
        })
    }
}

/// Opens a WebSocket, which is served until it closes. `protocol` is the selected subprotocol.
fn upgrade<S: Future<Output = ()> + Send>(
    mut request: HttpRequest,
    place: &Arc<ConnectionPlace>,
    protocol: Option<&'static str>,
    serve: impl FnOnce(Upgraded) -> S + Send + 'static,
) -> HttpResponse {
    let headers = request.headers();
    let is = |name, value: &str| {
        headers
            .get(name)
            .is_some_and(|it| it.as_bytes().eq_ignore_ascii_case(value.as_bytes()))
    };
    let key = headers.get(SEC_WEBSOCKET_KEY).cloned();
    let (true, true, Some(key)) = (
        is(UPGRADE, "websocket"),
        is(SEC_WEBSOCKET_VERSION, "13"),
        key,
    ) else {
        let text = "a WebSocket of version 13 is expected here\n";
        return guard::response(StatusCode::UPGRADE_REQUIRED, TEXT, text);
    };
    let place = Arc::clone(place);
    let upgraded = hyper::upgrade::on(&mut request);
    tokio::spawn(async move {
        // keeps its place, and is not idle, as long as it is open
        let _open = place.begin_call();
        if let Ok(upgraded) = upgraded.await {
            serve(upgraded).await;
        }
    });
    let mut response = guard::response(StatusCode::SWITCHING_PROTOCOLS, TEXT, "");
    let accept = HeaderValue::try_from(derive_accept_key(key.as_bytes()));
    let headers = response.headers_mut();
    headers.insert(CONNECTION, HeaderValue::from_static("Upgrade"));
    headers.insert(UPGRADE, HeaderValue::from_static("websocket"));
    if let Ok(accept) = accept {
        headers.insert(SEC_WEBSOCKET_ACCEPT, accept);
    }
    if let Some(protocol) = protocol {
        headers.insert(SEC_WEBSOCKET_PROTOCOL, HeaderValue::from_static(protocol));
    }
    response
}

fn not_found(text: &'static str) -> HttpResponse {
    guard::response(StatusCode::NOT_FOUND, TEXT, text)
}
