//! The content of a recorded message.

use std::borrow::Cow;
use std::sync::Arc;

use asmotion_datum::{Datum, DatumError, json};
use asmotion_viewer_encoding::RosType;

/// A recorded message, which is decoded when it is needed.
#[derive(Clone, Debug, PartialEq)]
pub struct MessageData {
    pub(super) bytes: Vec<u8>,
    pub(super) channel: Arc<KnownChannel>,
}

/// A channel of a recording.
#[derive(Debug, PartialEq)]
pub(super) struct KnownChannel {
    /// Its name, whatever the profile of the file.
    pub name: String,
    /// Name of the type of its messages.
    pub kind: String,
    /// The port whose sample was its first message.
    pub port: Option<String>,
    pub encoding: MessageEncoding,
}

/// The encoding of the messages of a channel.
#[derive(Debug, PartialEq)]
pub(super) enum MessageEncoding {
    Json,
    /// A message of ROS 2, in CDR.
    Ros(Arc<RosType>),
    /// A text of ROS 2 that is JSON.
    JsonInRos(Arc<RosType>),
}

impl MessageData {
    /// Size of the message in bytes, in the encoding of its channel.
    pub fn size(&self) -> usize {
        self.bytes.len()
    }

    /// The message as JSON.
    ///
    /// # Errors
    /// The message is not of the type of its channel.
    pub fn json(&self) -> Result<Cow<'_, str>, DatumError> {
        match &self.channel.encoding {
            MessageEncoding::Json => Ok(String::from_utf8_lossy(&self.bytes)),
            MessageEncoding::Ros(of) => {
                json::encode_datum(&of.decode(&self.bytes)?).map(Cow::Owned)
            }
            MessageEncoding::JsonInRos(text) => {
                let message = text.decode(&self.bytes)?;
                let data = message.get("data");
                let text = data.as_deref().and_then(Datum::as_text);
                Ok(Cow::Owned(text.unwrap_or_default().to_owned()))
            }
        }
    }

    /// The message as data.
    ///
    /// # Errors
    /// The message is not of the type of its channel, or no JSON.
    pub fn datum(&self) -> Result<Datum, DatumError> {
        match &self.channel.encoding {
            MessageEncoding::Ros(of) => of.decode(&self.bytes),
            MessageEncoding::Json | MessageEncoding::JsonInRos(_) => json::decode(&self.json()?),
        }
    }

    /// Name of the type of the message, as in `nav_msgs/Odometry`.
    pub fn type_name(&self) -> &str {
        &self.channel.kind
    }

    /// The port that wrote or received the first message of the channel, as `Component.port`; `None` for a message of no port.
    pub fn port(&self) -> Option<&str> {
        self.channel.port.as_deref()
    }
}
