//! Wire format: properties, headers, content types. `docs/wire.md` documents it for other implementations.

use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use amqprs::{BasicProperties, FieldName, FieldTable, FieldValue};
use asmotion_bus::{Envelope, Payload, TraceContext};
use asmotion_datum::{Codec, Schema};

use crate::outbox::MessageHeader;

/// Header: name of the sending component.
pub const SOURCE: &str = "source";
/// Header: number of the current run of the sender's process.
pub const INCARNATION: &str = "incarnation";
/// Header: number among the publisher's messages, from 1 without gaps.
pub const SEQUENCE: &str = "sequence";
/// Header: time of sending in nanoseconds; AMQP's own `timestamp` has seconds.
pub const STAMP: &str = "stamp";
/// Header: nanoseconds between `stamp` and this sending, by the sender's clock.
pub const AGE: &str = "age";
/// Header: name of the sender's clock, for example `wall:rover1`.
pub const CLOCK: &str = "clock";
/// Header: time of this sending, in nanoseconds of a clock of the sending process that does not jump.
pub const SENT: &str = "sent";
/// Header: W3C trace context of the message.
pub const TRACE: &str = "traceparent";
/// Header of a request: instant at which its caller gives up, in nanoseconds of Unix time by the caller's clock.
pub const DEADLINE: &str = "deadline";
/// Header of a request: time, in nanoseconds from its sending, after which the caller gives up.
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
/// Code of an `unavailable` whose provider is there, and its component does not run.
pub const STOPPED: &str = "STOPPED";

/// Limit on the `timeout` of a request: a day, as for the keys of a composite.
const LONGEST_TIMEOUT: Duration = Duration::from_secs(24 * 3600);
/// `timeout` of a request that has none.
const DEFAULT_TIMEOUT: Duration = Duration::from_secs(60);

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
    /// Age beyond which the broker discards a message.
    pub max_age: Option<Duration>,
    pub codec: Codec,
    /// Schema of its messages.
    pub schema: Schema,
}

impl MessageSource {
    /// The properties of one message.
    pub(crate) fn properties(&self, header: &MessageHeader) -> BasicProperties {
        let MessageHeader {
            sequence,
            stamp,
            trace,
            published: _,
        } = *header;
        let age = header.age();
        let headers = Headers::default()
            .text(SOURCE, &self.source)
            .count(INCARNATION, self.incarnation)
            .count(SEQUENCE, sequence)
            .number(STAMP, stamp)
            .count(AGE, nanoseconds(age))
            .count(SENT, nanoseconds(process_time()))
            .text(CLOCK, &self.clock)
            .text(TRACE, &trace.to_string())
            .into_table();
        let mut properties = BasicProperties::default();
        properties
            .with_content_type(self.codec.content_type())
            .with_headers(headers)
            .with_persistence(self.persistent)
            .with_message_id(&format!("{}-{sequence}", self.stream))
            .with_message_type(&self.schema.name)
            .with_user_id(&self.user);
        if let Some(max_age) = self.max_age {
            properties.with_expiration(&expiration(max_age.saturating_sub(age)));
        }
        properties.finish()
    }
}

/// Time since the first use of this clock, which does not jump.
fn process_time() -> Duration {
    static ORIGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    ORIGIN.elapsed()
}

/// Time of a message's sending by its sender's clock, in nanoseconds; `None` if the sender has left it out.
pub(crate) fn sent(properties: &BasicProperties) -> Option<u64> {
    count(properties, SENT)
}

/// Returns a duration in nanoseconds, limited to the range of a header.
pub(crate) fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Returns AMQP's `expiration` for a message that the broker keeps for at most this time.
pub(crate) fn expiration(time: Duration) -> String {
    // the limit of the broker
    time.as_millis().clamp(1, u32::MAX.into()).to_string()
}

/// Identity of a message, for the detection of duplicates.
///
/// Ids are claims of the sender, so they are compared only among messages of one AMQP user: `user` is the property
/// `user_id`, which the broker verifies, and is empty if the sender has left it out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum MessageIdentity {
    /// A message of a numbered stream.
    Numbered { stream: StreamId, sequence: u64 },
    /// A message with an id of its own.
    Named { user: String, id: String },
    /// No identity: never a duplicate.
    Unknown,
}

/// A numbered stream of one user.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct StreamId {
    pub user: String,
    pub name: String,
}

/// Returns a message's identity: an id that ends in its number (`<stream>-<sequence>`) belongs to a stream; otherwise
/// the number counts the component's messages on the topic; otherwise the message id, if any.
pub(crate) fn identity(properties: &BasicProperties, topic: &str) -> MessageIdentity {
    let user = properties.user_id().cloned().unwrap_or_default();
    let id = properties.message_id();
    let Some(sequence) = count(properties, SEQUENCE) else {
        return match id.cloned() {
            Some(id) => MessageIdentity::Named { user, id },
            None => MessageIdentity::Unknown,
        };
    };
    let ours = id.and_then(|id| {
        let (stream, number) = id.rsplit_once('-')?;
        (number.parse() == Ok(sequence)).then(|| stream.to_owned())
    });
    let of_source = |source| {
        let incarnation = count(properties, INCARNATION).unwrap_or(0);
        format!("{source}/{incarnation}/{topic}")
    };
    match (ours.or_else(|| text(properties, SOURCE).map(of_source)), id) {
        (Some(name), _) => MessageIdentity::Numbered {
            stream: StreamId { user, name },
            sequence,
        },
        (None, Some(id)) => MessageIdentity::Named {
            user,
            id: id.clone(),
        },
        (None, None) => MessageIdentity::Unknown,
    }
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
        age: Duration::from_nanos(count(properties, AGE).unwrap_or(0)),
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

/// Returns the time that a request has left: `timeout`, which its sender reduces by the time that the request has waited
/// there, at most [`LONGEST_TIMEOUT`]. The broker discards a request that waits there for longer.
pub(crate) fn time_left(properties: &BasicProperties) -> Duration {
    match count(properties, TIMEOUT) {
        Some(timeout) => Duration::from_nanos(timeout).min(LONGEST_TIMEOUT),
        None => DEFAULT_TIMEOUT,
    }
}
