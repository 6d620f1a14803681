//! Messages of services: requests, replies, and messages about requests.

use std::sync::Arc;
use std::time::{Duration, Instant};

use amqprs::BasicProperties;
use asmotion_bus::{CallFailure, Payload, Refusal, Request, SenderId, TraceContext};
use asmotion_datum::{Codec, Datum, Message};

use crate::wire::{self, Headers};

/// RabbitMQ's pseudo-queue for replies on the requesting channel.
pub(crate) const REPLY_TO: &str = "amq.rabbitmq.reply-to";

/// A request, encoded for sending.
pub(crate) struct OutgoingRequest {
    /// Unique among all requests, so that a provider can execute it once.
    pub id: String,
    pub key: String,
    pub codec: Codec,
    pub bytes: Arc<[u8]>,
    pub source: Arc<str>,
    pub incarnation: u64,
    pub timeout: Duration,
    /// Instant of the call, from which the timeout counts.
    pub begun: Instant,
    pub callback: Option<Arc<str>>,
    pub trace: Option<TraceContext>,
    pub user: String,
    /// See [`Request::awaits_provider`].
    pub awaits_provider: bool,
}

impl OutgoingRequest {
    /// The properties of the request itself. The broker discards it when its time has expired.
    pub(crate) fn request(&self, kind: &str) -> BasicProperties {
        let remaining = self.timeout.saturating_sub(self.begun.elapsed());
        let left = i64::try_from(remaining.as_nanos()).unwrap_or(i64::MAX);
        let deadline = wire::unix_now().saturating_add(left);
        let headers = Headers::default()
            .text(wire::SOURCE, &self.source)
            .count(wire::INCARNATION, self.incarnation)
            .count(wire::TIMEOUT, wire::nanoseconds(remaining))
            .number(wire::DEADLINE, deadline)
            .maybe(wire::CALLBACK, self.callback.as_deref())
            .maybe(wire::TRACE, self.trace.map(|it| it.to_string()).as_deref());
        self.notice(kind)
            .with_content_type(self.codec.content_type())
            .with_headers(headers.into_table())
            .with_expiration(&wire::expiration(remaining))
            .finish()
    }

    /// The properties of a message that refers to the request.
    pub(crate) fn notice(&self, kind: &str) -> BasicProperties {
        BasicProperties::default()
            .with_message_type(kind)
            .with_message_id(&self.id)
            .with_correlation_id(&self.id)
            .with_reply_to(REPLY_TO)
            .with_user_id(&self.user)
            .finish()
    }
}

/// Decodes a request.
pub(crate) fn read_request(
    properties: &BasicProperties,
    content: Vec<u8>,
) -> Result<Request, String> {
    let argument = wire::payload(properties, content)?;
    let source = wire::text(properties, wire::SOURCE).unwrap_or_default();
    let incarnation = wire::number(properties, wire::INCARNATION).unwrap_or(0);
    let origin = SenderId::new(source, u64::try_from(incarnation).unwrap_or(0));
    Ok(Request {
        origin,
        argument,
        timeout: wire::time_left(properties),
        callback: wire::text(properties, wire::CALLBACK).map(Into::into),
        trace: wire::trace(properties),
        awaits_provider: false,
    })
}

/// The codec of the reply to a request with this argument: the same one, as the caller reads it. CDR cannot be written without
/// the schema of the response, which only the provider knows.
pub(crate) fn reply_codec(argument: &Payload) -> Codec {
    match argument {
        Payload::Bytes {
            codec: Codec::Json, ..
        } => Codec::Json,
        Payload::Bytes {
            codec: Codec::Cbor | Codec::Cdr,
            ..
        }
        | Payload::Sample(_) => Codec::Cbor,
    }
}

/// A reply, encoded for sending. Kept in case the request arrives again.
#[derive(Clone)]
pub(crate) struct OutgoingReply {
    kind: &'static str,
    code: Option<String>,
    content_type: &'static str,
    pub bytes: Arc<[u8]>,
}

impl OutgoingReply {
    /// The reply for this outcome, whose result has this codec; `None` if the caller knows it already.
    pub(crate) fn of(end: Result<Payload, CallFailure>, codec: Codec) -> Option<Self> {
        let answer = |kind, code, bytes| Self {
            kind,
            code,
            content_type: codec.content_type(),
            bytes,
        };
        Some(match end {
            Ok(payload) => match payload.encode(codec, Datum::schema()) {
                Ok(bytes) => answer(wire::RESULT, None, bytes),
                Err(error) => {
                    let detail = error.to_string();
                    let code = Some("UNWRITABLE".to_owned());
                    answer(wire::REFUSAL, code, detail.into_bytes().into())
                }
            },
            Err(CallFailure::Refused(refusal)) => {
                let detail = refusal.detail.into_bytes().into();
                answer(wire::REFUSAL, Some(refusal.code), detail)
            }
            Err(CallFailure::Unavailable) => answer(wire::UNAVAILABLE, None, Arc::from([])),
            Err(CallFailure::Stopped) => answer(
                wire::UNAVAILABLE,
                Some(wire::STOPPED.to_owned()),
                Arc::from([]),
            ),
            Err(CallFailure::Timeout | CallFailure::Cancelled) => return None,
        })
    }

    pub(crate) fn properties(&self, id: &str, user: &str) -> BasicProperties {
        let content_type = if self.kind == wire::REFUSAL {
            "text/plain"
        } else {
            self.content_type
        };
        let headers = Headers::default().maybe(wire::CODE, self.code.as_deref());
        BasicProperties::default()
            .with_message_type(self.kind)
            .with_correlation_id(id)
            .with_content_type(content_type)
            .with_headers(headers.into_table())
            .with_user_id(user)
            .finish()
    }
}

/// Decodes a reply.
pub(crate) fn read_reply(
    properties: &BasicProperties,
    content: Vec<u8>,
) -> Result<Payload, CallFailure> {
    let refusal = |code: &str, detail| {
        CallFailure::Refused(Refusal {
            code: code.to_owned(),
            detail,
        })
    };
    match properties.message_type().map_or("", String::as_str) {
        wire::UNAVAILABLE if wire::text(properties, wire::CODE) == Some(wire::STOPPED) => {
            Err(CallFailure::Stopped)
        }
        wire::UNAVAILABLE => Err(CallFailure::Unavailable),
        wire::REFUSAL => {
            let code = wire::text(properties, wire::CODE).unwrap_or("REFUSED");
            let detail = String::from_utf8_lossy(&content).into_owned();
            Err(refusal(code, detail))
        }
        // a reply without a type, from a foreign provider, is a result
        _ => wire::payload(properties, content).map_err(|reason| refusal("UNREADABLE", reason)),
    }
}
