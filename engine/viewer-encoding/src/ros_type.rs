//! Message types of ROS 2: their definitions, and their messages in CDR.

use std::fmt;
use std::sync::LazyLock;

use asmotion_datum::{Codec, Datum, DatumError, Sample, Schema, json};
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceName};

/// The definitions of this build.
static INCLUDED: LazyLock<Catalogue> = LazyLock::new(|| Catalogue::included(Distribution::Ros2));

/// The line between the definitions of a message and of those in it, as bags have it.
const SEPARATOR: &str =
    "================================================================================";

/// Name of the message that is a text.
const TEXT: &str = "std_msgs/msg/String";

/// A message type of ROS 2.
#[derive(Clone, PartialEq)]
pub struct RosType {
    /// Full name: `nav_msgs/msg/Odometry`.
    pub name: String,
    /// Definition with those of all messages in it, as in a bag (`ros2msg`).
    pub definition: String,
    schema: Schema,
}

impl fmt::Debug for RosType {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.name)
    }
}

impl RosType {
    /// The type of ROS 2 with the name and the fields of a message type of the system; `None` if there is none.
    pub fn of(schema: &Schema) -> Option<Self> {
        let known = Self::known(&schema.name.parse().ok()?)?;
        known.schema.compare(schema).ok()?;
        Some(known)
    }

    /// The type whose messages are texts, for what has no type of ROS.
    pub fn text() -> Option<Self> {
        Self::known(&TEXT.parse().ok()?)
    }

    fn known(name: &InterfaceName) -> Option<Self> {
        let schema = INCLUDED.schema(name).ok()?;
        Codec::Cdr.carries(&schema).ok()?;
        Some(Self {
            name: name.to_string(),
            definition: INCLUDED.full_text(name).ok()?,
            schema,
        })
    }

    /// The type with this name and definition (`ros2msg`); `None` if the definition is none.
    pub fn read(name: &str, definition: &str) -> Option<Self> {
        let root: InterfaceName = name.parse().ok()?;
        let mut catalogue = Catalogue::empty(Distribution::Ros2);
        for (index, part) in definition.split(SEPARATOR).enumerate() {
            let (name, text) = if index == 0 {
                (root.clone(), part)
            } else {
                let named = part.trim_start().strip_prefix("MSG: ")?;
                let (name, text) = named.split_once('\n')?;
                (name.trim().parse().ok()?, text)
            };
            catalogue.define(name, text).ok()?;
        }
        Some(Self {
            schema: catalogue.schema(&root).ok()?,
            name: name.to_owned(),
            definition: definition.to_owned(),
        })
    }

    /// Encodes a message; `None` if it is not of the type. Fields that it omits have their initial values.
    pub fn encode(&self, message: Datum) -> Option<Vec<u8>> {
        let encoded = Codec::Cdr.encode(&message, &self.schema).ok();
        encoded.or_else(|| {
            let complete = self.schema.complete(message).ok()?;
            Codec::Cdr.encode(&complete, &self.schema).ok()
        })
    }

    /// Encodes a message as one of a type of ROS 2, or as JSON; `None` if it is not of the type.
    pub fn encode_or_json(ros: Option<&Self>, sample: &dyn Sample) -> Option<Vec<u8>> {
        let datum = sample.to_datum().ok()?;
        match ros {
            Some(of) => of.encode(datum),
            None => json::encode_datum(&datum).ok().map(String::into_bytes),
        }
    }

    /// Decodes a message.
    ///
    /// # Errors
    /// The bytes are no message of the type.
    pub fn decode(&self, bytes: &[u8]) -> Result<Datum, DatumError> {
        Codec::Cdr.decode(bytes, &self.schema)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_is_read_as_it_was_written() {
        for name in ["nav_msgs/msg/Odometry", "std_msgs/msg/Empty", TEXT] {
            let known = RosType::known(&name.parse().expect("a name")).expect(name);
            assert_eq!(RosType::read(&known.name, &known.definition), Some(known));
        }
        assert_eq!(
            RosType::read("nav_msgs/msg/Odometry", "Header header"),
            None
        );
    }

    #[test]
    fn a_type_of_the_same_name_with_other_fields_is_none_of_ros() {
        let twist: InterfaceName = "geometry_msgs/Twist".parse().expect("a name");
        let mut schema = INCLUDED.schema(&twist).expect("a type");
        assert!(RosType::of(&schema).is_some());
        if let asmotion_datum::Shape::Record(fields) = &mut schema.shape {
            fields.pop();
        }
        assert_eq!(RosType::of(&schema), None);
    }

    #[test]
    fn a_message_that_omits_fields_is_encoded_with_their_initial_values() {
        let twist: InterfaceName = "geometry_msgs/Twist".parse().expect("a name");
        let twist = RosType::known(&twist).expect("a type");
        let linear = Datum::record([("x", Datum::Float(0.5))]);
        let bytes = twist.encode(Datum::record([("linear", linear)]));
        let message = twist.decode(&bytes.expect("encoded")).expect("decoded");
        assert_eq!(message.get("linear.x").as_deref(), Some(&Datum::Float(0.5)));
        assert_eq!(
            message.get("angular.z").as_deref(),
            Some(&Datum::Float(0.0))
        );
        assert_eq!(twist.encode(Datum::text("no twist")), None);
    }
}
