//! Envelopes: a payload and what is known about it.

use std::fmt;
use std::sync::Arc;

use asmotion_datum::{Codec, Datum, DatumError, DatumProblem, Message, Sample, Schema};

use crate::trace_context::TraceContext;

/// A message on a topic, with the metadata that every transport carries.
#[derive(Debug, Clone)]
pub struct Envelope {
    /// The topic it was published on: words with dots between, `rover1.odom`.
    pub topic: Arc<str>,
    /// The component that published it.
    pub source: Arc<str>,
    /// Number of the source process's current run; grows with every restart.
    pub incarnation: u64,
    /// Number among all messages of this publisher, from 1 without gaps; a gap is a loss.
    pub sequence: u64,
    /// Time of sending, in nanoseconds of the sender's clock.
    pub stamp: i64,
    /// Name of that clock, for example `wall:rover1`; empty if it is the reader's own.
    pub clock: Arc<str>,
    /// Trace that the message belongs to; `None` if its sender keeps no traces.
    pub trace: Option<TraceContext>,
    /// The payload's message type, `geometry_msgs/Twist`; empty if unknown.
    pub type_name: Arc<str>,
    /// Content.
    pub payload: Payload,
}

/// Content of a message: the shared sample itself within a process, bytes when it arrives from outside.
#[derive(Clone)]
pub enum Payload {
    /// The sample, shared. It is encoded only when a transport needs bytes.
    Sample(Arc<dyn Sample>),
    /// Encoded, as it arrived from outside.
    Bytes {
        /// Encoding of `bytes`.
        codec: Codec,
        /// Encoded content.
        bytes: Arc<[u8]>,
    },
}

impl Payload {
    /// The payload of a message.
    pub fn of<T: Message>(message: T) -> Self {
        Self::Sample(Arc::new(message))
    }

    /// The content as data, where it says itself what it is.
    pub fn to_datum(&self) -> Result<Datum, DatumError> {
        self.to_datum_of(Datum::schema())
    }

    /// The content as data of a shape.
    pub fn to_datum_of(&self, schema: &Schema) -> Result<Datum, DatumError> {
        match self {
            Self::Sample(sample) => sample.to_datum(),
            Self::Bytes { codec, bytes } => codec.decode(bytes, schema),
        }
    }

    /// The content as a message.
    pub fn read<T: Message>(&self) -> Result<T, DatumError> {
        self.to_sample(T::schema())?.read()
    }

    /// The content as a sample: itself, or a datum of a shape.
    pub fn to_sample(&self, schema: &Schema) -> Result<Arc<dyn Sample>, DatumError> {
        match self {
            Self::Sample(sample) => Ok(Arc::clone(sample)),
            Self::Bytes { codec, bytes } => Ok(Arc::new(codec.decode(bytes, schema)?)),
        }
    }

    /// The content, of this shape, in bytes of a codec.
    pub fn encode(&self, wanted: Codec, schema: &Schema) -> Result<Arc<[u8]>, DatumError> {
        match self {
            Self::Bytes { codec, bytes } if *codec == wanted => Ok(Arc::clone(bytes)),
            Self::Sample(_) | Self::Bytes { .. } => {
                let datum = self.to_datum_of(schema)?;
                Ok(wanted.encode(&datum, schema)?.into())
            }
        }
    }
}

impl Envelope {
    /// The content as a sample of a shape. Bytes that do not say what they are are read only if the message has the
    /// name of that shape.
    pub fn to_sample(&self, schema: &Schema) -> Result<Arc<dyn Sample>, DatumError> {
        if let Payload::Bytes {
            codec: Codec::Cdr, ..
        } = self.payload
            && !is_named(&self.type_name, &schema.name)
        {
            return Err(DatumError::new(DatumProblem::Mismatch(format!(
                "it is `{}`, and `{schema}` is read",
                self.type_name
            ))));
        }
        self.payload.to_sample(schema)
    }
}

/// Returns whether a message's type has a name, which may also be written as in ROS 2: `geometry_msgs/msg/Twist`. A
/// missing name matches everything.
fn is_named(type_name: &str, wanted: &str) -> bool {
    let anonymous = type_name.is_empty() || wanted.is_empty();
    let in_ros_2 = || type_name.split_once("/msg/");
    let same = |(package, name)| wanted.split_once('/') == Some((package, name));
    anonymous || type_name == wanted || in_ros_2().is_some_and(same)
}

impl fmt::Debug for Payload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.to_datum() {
            Ok(datum) => write!(f, "{datum}"),
            Err(error) => write!(f, "({error})"),
        }
    }
}
