//! Errors of requests as problem details (RFC 9457), with a code for programs and a remedy for human readers.

use std::time::Duration;

use asmotion_bus::Refusal;
use asmotion_datum::DatumError;
use hyper::{StatusCode, header};
use serde_json::json;

use asmotion_http::HttpResponse;

use crate::response;

/// The reason that a request has no result.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum Problem {
    #[error("{}", if host.is_empty() { "request without a host".to_owned() } else { format!("`{host}` is not a name of this gateway") })]
    OtherHost { host: String },
    #[error("missing or wrong token")]
    Unauthorized,
    #[error("calls are under way on all connections")]
    Busy,
    #[error("unknown path `{path}`")]
    UnknownPath { path: String },
    #[error("unknown service `{name}`")]
    UnknownService {
        name: String,
        available: Vec<String>,
    },
    #[error("unknown operation `{name}` of `{service}`")]
    UnknownOperation {
        service: String,
        name: String,
        available: Vec<String>,
    },
    #[error("unknown component `{name}`")]
    UnknownComponent {
        name: String,
        available: Vec<String>,
    },
    #[error("expected method {allowed}")]
    Method { allowed: &'static str },
    #[error("request from a web page")]
    WebPage,
    #[error("unsupported content type `{found}`")]
    ContentType { found: String },
    #[error("the argument is longer than {limit} bytes")]
    TooLarge { limit: usize },
    #[error("the argument did not arrive within {} s", within.as_secs())]
    RequestTimeout { within: Duration },
    #[error("incomplete argument")]
    IncompleteBody,
    #[error("invalid parameter `{part}`")]
    Query { part: String },
    #[error("{error}")]
    Argument { error: DatumError, path: String },
    #[error("{}", refusal.detail)]
    Fault { refusal: Refusal, path: String },
    #[error("no reply within {} ms", after.as_millis())]
    Timeout { after: Duration },
    #[error("no server for `{service}`")]
    Unavailable { service: String },
    #[error("the component that serves `{service}` does not run")]
    Stopped { service: String },
    #[error("the reply cannot be written as JSON: {0}")]
    Answer(DatumError),
}

/// The code that a provider uses for a request that it cannot decode.
const BAD_REQUEST: &str = "BAD_REQUEST";

impl Problem {
    fn status(&self) -> StatusCode {
        match self {
            Self::OtherHost { .. } => StatusCode::MISDIRECTED_REQUEST,
            Self::Unauthorized => StatusCode::UNAUTHORIZED,
            Self::UnknownPath { .. }
            | Self::UnknownService { .. }
            | Self::UnknownOperation { .. }
            | Self::UnknownComponent { .. } => StatusCode::NOT_FOUND,
            Self::Method { .. } => StatusCode::METHOD_NOT_ALLOWED,
            Self::WebPage => StatusCode::FORBIDDEN,
            Self::ContentType { .. } => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::TooLarge { .. } => StatusCode::PAYLOAD_TOO_LARGE,
            Self::RequestTimeout { .. } => StatusCode::REQUEST_TIMEOUT,
            Self::IncompleteBody | Self::Query { .. } | Self::Argument { .. } => {
                StatusCode::BAD_REQUEST
            }
            Self::Fault { refusal, .. } if refusal.code == BAD_REQUEST => StatusCode::BAD_REQUEST,
            Self::Fault { .. } => StatusCode::UNPROCESSABLE_ENTITY,
            Self::Timeout { .. } => StatusCode::GATEWAY_TIMEOUT,
            Self::Unavailable { .. } | Self::Stopped { .. } | Self::Busy => {
                StatusCode::SERVICE_UNAVAILABLE
            }
            Self::Answer(_) => StatusCode::BAD_GATEWAY,
        }
    }

    /// The code for programs; for a fault, the operation's own code.
    fn code(&self) -> &str {
        match self {
            Self::OtherHost { .. } => "OTHER_HOST",
            Self::Unauthorized => "NO_TOKEN",
            Self::Busy => "BUSY",
            Self::UnknownPath { .. } => "NO_PATH_HERE",
            Self::UnknownService { .. } => "NO_SERVICE",
            Self::UnknownOperation { .. } => "NO_OPERATION",
            Self::UnknownComponent { .. } => "NO_COMPONENT",
            Self::Method { .. } => "OTHER_METHOD",
            Self::WebPage => "WEB_PAGE",
            Self::ContentType { .. } => "OTHER_CONTENT_TYPE",
            Self::TooLarge { .. } => "TOO_LARGE",
            Self::RequestTimeout { .. } => "SLOW",
            Self::IncompleteBody => "BROKEN",
            Self::Query { .. } => "BAD_QUERY",
            Self::Argument { .. } => BAD_REQUEST,
            Self::Fault { refusal, .. } => &refusal.code,
            Self::Timeout { .. } => "TIMEOUT",
            Self::Unavailable { .. } => "UNAVAILABLE",
            Self::Stopped { .. } => "STOPPED",
            Self::Answer(_) => "NO_FORM",
        }
    }

    /// A remedy; `None` for faults of an operation.
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::OtherHost { .. } => {
                "use its IP address or `localhost`, or add the name to `allowed_hosts` of the gateway".to_owned()
            }
            Self::Unauthorized => {
                "send the `token` of the gateway: `curl -H \"Authorization: Bearer $TOKEN\"`".to_owned()
            }
            Self::Busy => "try again later, or raise `max_connections` of the gateway".to_owned(),
            Self::UnknownPath { .. } => {
                "`GET /services` lists the services; call one with `POST /services/NAME/OPERATION`"
                    .to_owned()
            }
            Self::UnknownService { name, available: known } => suggest_among("services", name, known),
            Self::UnknownOperation { name, available: known, .. } => suggest_among("operations", name, known),
            Self::UnknownComponent { name, available: known } => suggest_among("components", name, known),
            Self::Method { allowed } => format!("use `curl -X {allowed}`"),
            Self::WebPage => "to allow requests from web pages, put a proxy before the gateway that authenticates the user and removes the header `Origin`"
                .to_owned(),
            Self::ContentType { .. } => {
                "add `-H 'Content-Type: application/json'`, or use `curl --json`".to_owned()
            }
            Self::TooLarge { .. } => "send less, or raise `max_body_kb` of the gateway".to_owned(),
            Self::RequestTimeout { .. } | Self::IncompleteBody => "send it again".to_owned(),
            Self::Query { .. } => {
                "use `timeout_ms=500`, from 1 to 86400000, or `oneway=true`".to_owned()
            }
            Self::Argument { path, .. } => format!("`GET {path}` returns its JSON Schema"),
            Self::Fault { refusal, path } if refusal.code == BAD_REQUEST => {
                format!("`GET {path}` returns its JSON Schema")
            }
            Self::Fault { .. } => return None,
            Self::Timeout { .. } => "allow more time with `?timeout_ms=5000`".to_owned(),
            Self::Unavailable { .. } => {
                "too many requests wait for the component: try again later".to_owned()
            }
            Self::Stopped { .. } => {
                "start the component (`asmotion component start`); until then it answers only operations that need no cycle"
                    .to_owned()
            }
            Self::Answer(_) => return None,
        })
    }

    /// The header that the status requires.
    fn header(&self) -> Option<(header::HeaderName, &'static str)> {
        if let Self::Method { allowed } = self {
            Some((header::ALLOW, allowed))
        } else if let Self::Unauthorized = self {
            Some((header::WWW_AUTHENTICATE, "Bearer"))
        } else if let Self::Busy = self {
            Some((header::RETRY_AFTER, "1"))
        } else {
            None
        }
    }

    /// The HTTP response.
    pub(crate) fn response(&self) -> HttpResponse {
        let status = self.status();
        let mut details = json!({
            "status": status.as_u16(),
            "title": status.canonical_reason(),
            "code": self.code(),
            "detail": self.to_string(),
        });
        if let Some(help) = self.help() {
            details["help"] = help.into();
        }
        let mut response = response::json(status, details.to_string());
        let kind = header::HeaderValue::from_static("application/problem+json");
        response.headers_mut().insert(header::CONTENT_TYPE, kind);
        if let Some((name, value)) = self.header() {
            let value = header::HeaderValue::from_static(value);
            response.headers_mut().insert(name, value);
        }
        response
    }
}

/// A suggestion if a similar name exists, otherwise the list of known names.
fn suggest_among(what: &str, name: &str, available: &[String]) -> String {
    let distance = |known: &String| strsim::osa_distance(name, known);
    let nearest = available.iter().min_by_key(|known| distance(known));
    let suggestion =
        nearest.filter(|it| distance(it) * 3 <= it.chars().count().max(name.chars().count()));
    match (suggestion, available.is_empty()) {
        (Some(meant), _) => format!("did you mean `{meant}`?"),
        (None, true) => format!("it has no {what}"),
        (None, false) => format!("the {what} are {}", available.join(", ")),
    }
}
