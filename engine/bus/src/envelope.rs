//! Envelopes: a payload and its metadata.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::{Codec, Datum, DatumError, DatumProblem, Message, Sample, Schema};

use crate::trace_context::TraceContext;

/// A message on a topic, with the metadata that every transport carries.
#[derive(Debug, Clone)]
pub struct Envelope {
    /// Topic on which it was published: words separated by dots, for example `rover1.odom`.
    pub topic: Arc<str>,
    /// Name of the publishing component.
    pub source: Arc<str>,
    /// Number of the source process's current run; grows with every restart.
    pub incarnation: u64,
    /// Number among all messages of this publisher, from 1 without gaps; a gap is a loss.
    pub sequence: u64,
    /// Time of sending, in nanoseconds of the sender's clock.
    pub stamp: i64,
    /// Name of that clock, for example `wall:rover1`; empty if it is the reader's own.
    pub clock: Arc<str>,
    /// Time since `stamp` in which the message is known to have waited: for its transport, to be sent again for a late reader, for
    /// a process that stood still, or in the queue of its reader.
    pub age: Duration,
    /// Trace that the message belongs to; `None` if its sender keeps no traces.
    pub trace: Option<TraceContext>,
    /// Name of the payload's message type, for example `geometry_msgs/Twist`; empty if unknown.
    pub type_name: Arc<str>,
    /// Data of the type `type_name`, encoded or as the sender's sample.
    pub payload: Payload,
}

/// Content of a message: the shared sample itself within a process, bytes when it arrives from outside.
#[derive(Clone)]
pub enum Payload {
    /// A shared sample. It is encoded only if a transport needs bytes.
    Sample(Arc<dyn Sample>),
    /// Encoded content, as received from outside.
    Bytes {
        /// Encoding of `bytes`.
        codec: Codec,
        /// Encoded content.
        bytes: Arc<[u8]>,
    },
}

impl Payload {
    /// A payload that contains a message.
    pub fn of<T: Message>(message: T) -> Self {
        Self::Sample(Arc::new(message))
    }

    /// Converts the content to a datum. For codecs that are not self-describing, use
    /// [`to_datum_of`](Self::to_datum_of).
    ///
    /// # Errors
    /// The bytes are malformed, or belong to a codec that does not describe itself.
    pub fn to_datum(&self) -> Result<Datum, DatumError> {
        self.to_datum_of(Datum::schema())
    }

    /// Returns the content as a datum, without a copy if no other pointer to it exists.
    ///
    /// # Errors
    /// As [`to_datum`](Self::to_datum).
    pub fn into_datum(self) -> Result<Datum, DatumError> {
        match self {
            Self::Sample(sample) => sample.read(),
            Self::Bytes { codec, bytes } => codec.decode(&bytes, Datum::schema()),
        }
    }

    /// Converts the content to a datum of this schema.
    ///
    /// # Errors
    /// The bytes are malformed, or do not follow the schema.
    pub fn to_datum_of(&self, schema: &Schema) -> Result<Datum, DatumError> {
        match self {
            Self::Sample(sample) => sample.to_datum(),
            Self::Bytes { codec, bytes } => codec.decode(bytes, schema),
        }
    }

    /// Converts the content to a message.
    ///
    /// # Errors
    /// The bytes are malformed, or the data does not fit the type.
    pub fn read<T: Message>(&self) -> Result<T, DatumError> {
        self.to_sample(T::schema())?.read()
    }

    /// Converts the content to a sample: the sample itself, or a datum of this schema.
    ///
    /// # Errors
    /// The bytes are malformed, or do not follow the schema.
    pub fn to_sample(&self, schema: &Schema) -> Result<Arc<dyn Sample>, DatumError> {
        match self {
            Self::Sample(sample) => Ok(Arc::clone(sample)),
            Self::Bytes { codec, bytes } => Ok(Arc::new(codec.decode(bytes, schema)?)),
        }
    }

    /// Converts the content to a sample in the form that a typed writer would give it: encoded content that fits the schema is
    /// [completed](Schema::complete). Other content is returned as it is, for its reader to refuse.
    ///
    /// # Errors
    /// As [`to_sample`](Self::to_sample).
    pub fn to_complete_sample(&self, schema: &Schema) -> Result<Arc<dyn Sample>, DatumError> {
        let Self::Bytes { codec, bytes } = self else {
            return self.to_sample(schema);
        };
        let datum = codec.decode(bytes, schema)?;
        let fits = schema.accepts(&datum).is_ok();
        Ok(Arc::new(if fits { schema.complete(datum)? } else { datum }))
    }

    /// Encodes the content, which has this schema, with a codec.
    ///
    /// # Errors
    /// The content does not follow the schema, or the codec cannot carry it.
    pub fn encode(&self, target: Codec, schema: &Schema) -> Result<Arc<[u8]>, DatumError> {
        match self {
            Self::Bytes { codec, bytes } if *codec == target => Ok(Arc::clone(bytes)),
            Self::Sample(_) | Self::Bytes { .. } => {
                let datum = self.to_datum_of(schema)?;
                Ok(target.encode(&datum, schema)?.into())
            }
        }
    }
}

impl Envelope {
    /// Converts the payload to a sample of this schema. Bytes that are not self-describing are decoded only if the
    /// message's type name matches.
    ///
    /// # Errors
    /// The bytes are malformed or do not follow the schema, or belong to a message of another name.
    pub fn to_sample(&self, schema: &Schema) -> Result<Arc<dyn Sample>, DatumError> {
        if let Payload::Bytes {
            codec: Codec::Cdr, ..
        } = self.payload
            && !is_named(&self.type_name, &schema.name)
        {
            return Err(DatumError::new(DatumProblem::Mismatch(format!(
                "expected `{schema}`, found `{}`",
                self.type_name
            ))));
        }
        self.payload.to_sample(schema)
    }
}

/// Returns whether two type names match. `type_name` may also have the form of ROS 2, `geometry_msgs/msg/Twist`. An
/// empty name matches everything.
fn is_named(type_name: &str, expected: &str) -> bool {
    let anonymous = type_name.is_empty() || expected.is_empty();
    let in_ros_2 = || type_name.split_once("/msg/");
    let same = |(package, name)| expected.split_once('/') == Some((package, name));
    anonymous || type_name == expected || in_ros_2().is_some_and(same)
}

impl fmt::Debug for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.to_datum() {
            Ok(datum) => write!(f, "{datum}"),
            Err(error) => write!(f, "({error})"),
        }
    }
}
