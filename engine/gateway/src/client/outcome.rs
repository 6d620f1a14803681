//! The outcome of a call, from the response of the server.

use asmotion_bus::{CallFailure, Payload, Refusal};
use asmotion_datum::{Codec, Datum};
use hyper::StatusCode;
use hyper::header::{CONTENT_TYPE, LOCATION};
use hyper::http::response::Parts;
use serde_json::Value;

/// Limit on the characters of an explanation that the server gives.
const MAX_DETAIL: usize = 300;

/// A call without a response, and why its server is unavailable.
#[derive(Debug)]
pub(super) struct FailedExchange {
    pub failure: CallFailure,
    pub reason: Option<String>,
}

impl From<CallFailure> for FailedExchange {
    fn from(failure: CallFailure) -> Self {
        let reason = None;
        Self { failure, reason }
    }
}

/// The failure of a call whose server is unavailable for this reason.
pub(super) fn unavailable(reason: impl Into<String>) -> FailedExchange {
    FailedExchange {
        failure: CallFailure::Unavailable,
        reason: Some(reason.into()),
    }
}

/// The failure of a call that the server, or the protocol, refuses.
pub(super) fn refusal(code: &str, detail: impl Into<String>) -> CallFailure {
    CallFailure::Refused(Refusal {
        code: code.to_owned(),
        detail: detail.into(),
    })
}

/// The result of a call.
pub(super) fn of(head: &Parts, body: &[u8], one_way: bool) -> Result<Payload, FailedExchange> {
    match head.status {
        status if status.is_success() && (one_way || body.is_empty()) => {
            Ok(Payload::of(Datum::Null))
        }
        status if status.is_success() => Ok(result(head, body)?),
        StatusCode::SERVICE_UNAVAILABLE if text_in(body, "code").as_deref() == Some("STOPPED") => {
            Err(CallFailure::Stopped.into())
        }
        status @ (StatusCode::SERVICE_UNAVAILABLE | StatusCode::TOO_MANY_REQUESTS) => {
            let detail = text_in(body, "detail").map_or(String::new(), |it| format!(": {it}"));
            Err(unavailable(format!(
                "the server answers `{status}`{detail}"
            )))
        }
        StatusCode::GATEWAY_TIMEOUT => Err(CallFailure::Timeout.into()),
        status if status.is_redirection() => {
            let to = head.headers.get(LOCATION).map(|it| it.as_bytes());
            let to = String::from_utf8_lossy(to.unwrap_or_default());
            let detail = format!("redirected to `{to}`: name this URL in the wire");
            Err(refusal(&code_of(status), shortened(&detail)).into())
        }
        status => Err(problem(status, body).into()),
    }
}

fn result(head: &Parts, body: &[u8]) -> Result<Payload, CallFailure> {
    let kind = head.headers.get(CONTENT_TYPE);
    let kind = kind.map_or(Ok(Codec::Json.content_type()), |kind| kind.to_str());
    let kind = kind.unwrap_or_default();
    let essence = kind.split(';').next().unwrap_or(kind).trim();
    if Codec::of_content_type(essence) != Some(Codec::Json) {
        let detail = format!("expected JSON, found the content type `{kind}`");
        return Err(refusal("BAD_REPLY", shortened(&detail)));
    }
    Ok(Payload::Bytes {
        codec: Codec::Json,
        bytes: body.into(),
    })
}

/// The fault that problem details (RFC 9457) describe, or one with the status as its code.
fn problem(status: StatusCode, body: &[u8]) -> CallFailure {
    let details: Value = serde_json::from_slice(body).unwrap_or_default();
    let text = |key: &str| details[key].as_str().map(shortened);
    let reason = || status.canonical_reason().unwrap_or("failed").to_owned();
    let detail = text("detail").or_else(|| text("title"));
    let code = text("code").unwrap_or_else(|| code_of(status));
    refusal(&code, detail.unwrap_or_else(reason))
}

/// A text in problem details.
fn text_in(body: &[u8], key: &str) -> Option<String> {
    let details: Value = serde_json::from_slice(body).ok()?;
    details[key].as_str().map(shortened)
}

fn code_of(status: StatusCode) -> String {
    format!("HTTP_{}", status.as_u16())
}

fn shortened(text: &str) -> String {
    text.chars().take(MAX_DETAIL).collect()
}
