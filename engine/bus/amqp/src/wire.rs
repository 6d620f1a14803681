//! Wire format: properties, headers, content types. `docs/wire.md` documents it for other implementations.

use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use amqprs::{BasicProperties, FieldName, FieldTable, FieldValue};
use asmotion_bus::{Envelope, Payload, TraceContext};
use asmotion_datum::{Codec, Schema};

/// Header: name of the sending component.
pub const SOURCE: &str = "source";
/// Header: number of the current run of the sender's process.
pub const INCARNATION: &str = "incarnation";
/// Header: number among the publisher's messages, from 1 without gaps.
pub const SEQUENCE: &str = "sequence";
/// Header: time of sending in nanoseconds; AMQP's own `timestamp` has seconds.
pub const STAMP: &str = "stamp";
/// Header: name of the sender's clock, for example `wall:rover1`.
pub const CLOCK: &str = "clock";
/// Header: W3C trace context of the message.
pub const TRACE: &str = "traceparent";
/// Header of a request: instant at which the caller gives up, in nanoseconds of Unix time.
pub const DEADLINE: &str = "deadline";
/// Header of a request: time limit in nanoseconds.
pub const TIMEOUT: &str = "timeout";
/// Header of a request: address at which the caller can be called back.
pub const CALLBACK: &str = "callback";
/// Header of a refusal: error code of the operation.
pub const CODE: &str = "code";

/// `type` of a request that expects a reply.
pub const REQUEST: &str = "request";
/// `type` of a one-way request.
pub const TELLING: &str = "telling";
/// `type` of a message that cancels a request.
pub const CANCEL: &str = "cancel";
/// `type` of the question whether a request is still known.
pub const ENQUIRY: &str = "enquiry";
/// `type` of a reply with a result.
pub const RESULT: &str = "result";
/// `type` of a reply with a fault.
pub const REFUSAL: &str = "refusal";
/// `type` of the reply that no provider is there.
pub const UNAVAILABLE: &str = "unavailable";

/// Builder of a header table. Names are short and ASCII.
#[derive(Default)]
pub(crate) struct Headers(FieldTable);

impl Headers {
    pub(crate) fn text(mut self, name: &str, value: &str) -> Self {
        if let (Ok(name), Ok(value)) = (FieldName::try_from(name), value.to_owned().try_into()) {
            self.0.insert(name, FieldValue::S(value));
        }
        self
    }

    pub(crate) fn number(mut self, name: &str, value: i64) -> Self {
        if let Ok(name) = FieldName::try_from(name) {
            self.0.insert(name, FieldValue::l(value));
        }
        self
    }

    pub(crate) fn count(self, name: &str, value: u64) -> Self {
        self.number(name, i64::try_from(value).unwrap_or(i64::MAX))
    }

    pub(crate) fn maybe(self, name: &str, value: Option<&str>) -> Self {
        match value {
            Some(value) => self.text(name, value),
            None => self,
        }
    }

    pub(crate) fn into_table(self) -> FieldTable {
        self.0
    }
}

/// Returns a header field by its name.
fn field<'a>(properties: &'a BasicProperties, name: &str) -> Option<&'a FieldValue> {
    let name = FieldName::try_from(name).ok()?;
    properties.headers()?.get(&name)
}

/// Returns a header field if it is text.
pub(crate) fn text<'a>(properties: &'a BasicProperties, name: &str) -> Option<&'a str> {
    field(properties, name).and_then(|value| value.try_into().ok())
}

/// Returns a header field if it is an integer of any width: other clients choose the narrowest.
pub(crate) fn number(properties: &BasicProperties, name: &str) -> Option<i64> {
    match field(properties, name)? {
        FieldValue::b(value) => Some((*value).into()),
        FieldValue::B(value) => Some((*value).into()),
        FieldValue::s(value) => Some((*value).into()),
        FieldValue::u(value) => Some((*value).into()),
        FieldValue::I(value) => Some((*value).into()),
        FieldValue::i(value) => Some((*value).into()),
        FieldValue::l(value) => Some(*value),
        FieldValue::T(value) => i64::try_from(*value).ok(),
        FieldValue::t(_)
        | FieldValue::f(_)
        | FieldValue::d(_)
        | FieldValue::D(_)
        | FieldValue::S(_)
        | FieldValue::A(_)
        | FieldValue::F(_)
        | FieldValue::V
        | FieldValue::x(_) => None,
    }
}

fn count(properties: &BasicProperties, name: &str) -> Option<u64> {
    number(properties, name).and_then(|value| u64::try_from(value).ok())
}

/// Properties common to all messages of a publisher.
pub(crate) struct MessageSource {
    pub source: Arc<str>,
    pub incarnation: u64,
    /// Id of this publisher, unique among all.
    pub stream: String,
    pub clock: String,
    pub user: String,
    pub persistent: bool,
    pub codec: Codec,
    /// Schema of its messages.
    pub schema: Schema,
}

impl MessageSource {
    /// The properties of one message.
    pub(crate) fn properties(
        &self,
        sequence: u64,
        stamp: i64,
        trace: TraceContext,
    ) -> BasicProperties {
        let headers = Headers::default()
            .text(SOURCE, &self.source)
            .count(INCARNATION, self.incarnation)
            .count(SEQUENCE, sequence)
            .number(STAMP, stamp)
            .text(CLOCK, &self.clock)
            .text(TRACE, &trace.to_string())
            .into_table();
        BasicProperties::default()
            .with_content_type(self.codec.content_type())
            .with_headers(headers)
            .with_persistence(self.persistent)
            .with_message_id(&format!("{}-{sequence}", self.stream))
            .with_message_type(&self.schema.name)
            .with_user_id(&self.user)
            .finish()
    }
}

/// A name that a sender chose, together with the sender's AMQP user, so that no user can claim the names of another.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct OwnedName {
    /// The `user_id`, which the broker verifies; `None` if the sender left it out.
    pub user: Option<String>,
    pub name: String,
}

impl OwnedName {
    pub(crate) fn of(properties: &BasicProperties, name: String) -> Self {
        let user = properties.user_id().cloned();
        Self { user, name }
    }
}

/// Identity of a message, for the detection of duplicates.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum MessageIdentity {
    /// A message of a numbered stream.
    Numbered { stream: OwnedName, sequence: u64 },
    /// A message with an id of its own.
    Named(OwnedName),
    /// No identity: never a duplicate.
    Unknown,
}

/// Returns a message's identity: an id that ends in its number (`<stream>-<sequence>`) belongs to a stream; otherwise
/// the number counts the component's messages on the topic; otherwise the message id, if any.
pub(crate) fn identity(properties: &BasicProperties, topic: &str) -> MessageIdentity {
    let id = properties.message_id();
    let named = || {
        id.cloned().map_or(MessageIdentity::Unknown, |id| {
            MessageIdentity::Named(OwnedName::of(properties, id))
        })
    };
    let Some(sequence) = count(properties, SEQUENCE) else {
        return named();
    };
    let ours = id.and_then(|id| {
        let (stream, number) = id.rsplit_once('-')?;
        (number.parse() == Ok(sequence)).then(|| stream.to_owned())
    });
    let stream = ours.or_else(|| {
        let source = text(properties, SOURCE)?;
        let incarnation = count(properties, INCARNATION).unwrap_or(0);
        Some(format!("{source}/{incarnation}/{topic}"))
    });
    stream.map_or_else(named, |stream| MessageIdentity::Numbered {
        stream: OwnedName::of(properties, stream),
        sequence,
    })
}

/// Returns the trace context of a message.
pub(crate) fn trace(properties: &BasicProperties) -> Option<TraceContext> {
    text(properties, TRACE)?.parse().ok()
}

/// Returns the payload, or an explanation if its content type is unknown.
pub(crate) fn payload(properties: &BasicProperties, content: Vec<u8>) -> Result<Payload, String> {
    let content_type = properties.content_type().map_or("", String::as_str);
    // parameters such as `charset` do not affect decoding
    let plain = content_type.split(';').next().unwrap_or_default().trim();
    let codec = Codec::of_content_type(plain)
        .ok_or_else(|| format!("unknown content type `{content_type}`"))?;
    Ok(Payload::Bytes {
        codec,
        bytes: content.into(),
    })
}

/// The envelope for subscribers. Fields that the sender has left out are empty.
pub(crate) fn envelope(topic: &str, properties: &BasicProperties, payload: Payload) -> Envelope {
    let text = |name| text(properties, name);
    let user = properties.user_id().map(String::as_str);
    Envelope {
        topic: topic.into(),
        source: text(SOURCE).or(user).unwrap_or_default().into(),
        incarnation: count(properties, INCARNATION).unwrap_or(0),
        sequence: count(properties, SEQUENCE).unwrap_or(0),
        stamp: number(properties, STAMP).unwrap_or(0),
        clock: text(CLOCK).unwrap_or_default().into(),
        trace: trace(properties),
        type_name: properties.message_type().map_or("", String::as_str).into(),
        payload,
    }
}

/// Current time in nanoseconds since the Unix epoch.
pub(crate) fn unix_now() -> i64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    i64::try_from(now.unwrap_or_default().as_nanos()).unwrap_or(i64::MAX)
}

/// Returns the time a request has left; `None` if the caller has given up.
///
/// The deadline refers to the caller's clock. If the clocks differ, a request still never has more time than its
/// timeout.
pub(crate) fn time_left(properties: &BasicProperties) -> Option<Duration> {
    let timeout = count(properties, TIMEOUT).map(Duration::from_nanos)?;
    let left = match number(properties, DEADLINE) {
        Some(deadline) => deadline.saturating_sub(unix_now()),
        None => i64::MAX,
    };
    let left = u64::try_from(left).ok().filter(|left| *left > 0)?;
    Some(timeout.min(Duration::from_nanos(left)))
}
