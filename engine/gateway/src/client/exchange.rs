//! One request and its response.

use std::time::Instant;

use asmotion_bus::{CallFailure, Payload, TraceContext};
use asmotion_datum::{Codec, Datum, Message};
use http_body_util::{BodyExt, Full, LengthLimitError, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::client::conn::TrySendError;
use hyper::header::{ACCEPT, AUTHORIZATION, CONTENT_TYPE, HOST, HeaderValue, USER_AGENT};
use hyper::{Method, Request, Response};
use tokio::time::timeout_at;

use super::connection::{Connection, ConnectionPool};
use super::outcome::{self, FailedExchange, refusal, unavailable};
use super::target::Target;
use asmotion_http::BearerToken;

/// Limit on the size of a response, in bytes.
const MAX_BODY: usize = 16 << 20;

/// A request to be made, and the limits of its response.
pub(super) struct Exchange {
    pub target: Target,
    pub token: Option<BearerToken>,
    pub argument: Payload,
    pub deadline: Instant,
    pub trace: Option<TraceContext>,
    pub one_way: bool,
}

impl Exchange {
    /// Sends the request and waits for the response, until the deadline.
    pub(super) async fn run(&self, pool: &ConnectionPool) -> Result<Payload, FailedExchange> {
        let exchange = self.exchange(pool);
        let result = timeout_at(self.deadline.into(), exchange).await;
        result.unwrap_or(Err(CallFailure::Timeout.into()))
    }

    async fn exchange(&self, pool: &ConnectionPool) -> Result<Payload, FailedExchange> {
        let request = self.request()?;
        let (mut connection, response) = self.send(request, pool).await?;
        let (head, body) = response.into_parts();
        // the length that the server announces, which may never arrive
        if body.size_hint().lower() > MAX_BODY as u64 {
            return Err(too_large().into());
        }
        let body = Limited::new(body, MAX_BODY).collect().await;
        let body = body.map_err(|error| {
            if error.is::<LengthLimitError>() {
                too_large()
            } else {
                refusal("NO_REPLY", format!("the response ended early: {error}"))
            }
        })?;
        if connection.sender.ready().await.is_ok() {
            pool.put(&self.target.server, connection);
        }
        outcome::of(&head, &body.to_bytes(), self.one_way)
    }

    fn request(&self) -> Result<Request<Full<Bytes>>, CallFailure> {
        let argument = self.argument.encode(Codec::Json, Datum::schema());
        let argument = argument.map_err(|error| refusal("BAD_REQUEST", error.to_string()))?;
        let left = self.deadline.saturating_duration_since(Instant::now());
        let one_way = if self.one_way { "&oneway=true" } else { "" };
        let timeout_ms = left.as_millis().clamp(1, 86_400_000);
        let uri = format!("{}?timeout_ms={timeout_ms}{one_way}", self.target.path);
        let json = HeaderValue::from_static(Codec::Json.content_type());
        let mut request = Request::builder()
            .method(Method::POST)
            .uri(uri)
            .header(HOST, self.target.host.clone())
            .header(CONTENT_TYPE, json.clone())
            .header(ACCEPT, json)
            .header(USER_AGENT, concat!("asmotion/", env!("CARGO_PKG_VERSION")));
        if let Some(trace) = self.trace {
            request = request.header("traceparent", trace.to_string());
        }
        if let Some(token) = &self.token {
            let credentials = token.credentials();
            let credentials = credentials
                .ok_or_else(|| refusal("BAD_REQUEST", "a header cannot contain the token"))?;
            request = request.header(AUTHORIZATION, credentials);
        }
        let body = Full::new(Bytes::copy_from_slice(&argument));
        let request = request.body(body);
        request.map_err(|error| refusal("BAD_REQUEST", error.to_string()))
    }

    /// Sends the request over an idle connection, or over a new one if there is none or the server has closed it.
    async fn send(
        &self,
        request: Request<Full<Bytes>>,
        pool: &ConnectionPool,
    ) -> Result<(Connection, Response<Incoming>), FailedExchange> {
        let mut request = request;
        while let Some(mut connection) = pool.take(&self.target.server) {
            match connection.sender.try_send_request(request).await {
                Ok(response) => return Ok((connection, response)),
                // a request that has not been sent is returned
                Err(error) => request = unsent(error)?,
            }
        }
        let mut connection = self.connect(pool).await?;
        match connection.sender.try_send_request(request).await {
            Ok(response) => Ok((connection, response)),
            Err(error) => Err(match unsent(error) {
                Err(failure) => failure.into(),
                Ok(_) => unavailable("the server closes new connections"),
            }),
        }
    }

    /// Opens a connection within half of the time that is left: a server that cannot be reached is unavailable, which the
    /// caller learns before its deadline.
    async fn connect(&self, pool: &ConnectionPool) -> Result<Connection, FailedExchange> {
        let now = Instant::now();
        let until = now + self.deadline.saturating_duration_since(now) / 2;
        let opened = timeout_at(until.into(), pool.open(&self.target.server)).await;
        opened.unwrap_or_else(|_| {
            let passed = until.saturating_duration_since(now).as_millis();
            Err(unavailable(format!(
                "no connection within {passed} ms, half of the time left"
            )))
        })
    }
}

fn too_large() -> CallFailure {
    let detail = format!("the response is longer than {MAX_BODY} bytes");
    refusal("TOO_LARGE", detail)
}

/// Returns the request if no byte of it has been sent, otherwise the failure of its call.
fn unsent(
    mut error: TrySendError<Request<Full<Bytes>>>,
) -> Result<Request<Full<Bytes>>, CallFailure> {
    if let Some(request) = error.take_message() {
        return Ok(request);
    }
    let error = error.into_error();
    let code = if error.is_parse() {
        "BAD_REPLY"
    } else {
        "NO_REPLY"
    };
    Err(refusal(code, error.to_string()))
}
