//! The type of the messages of a channel.

use std::sync::Arc;

use asmotion_datum::json_schema::SchemaDefinitions;
use asmotion_datum::{Sample, Schema};
use serde_json::{Value, json};

use crate::encoding_names::{CDR, JSON, JSON_SCHEMA, ROS2_DEFINITION};
use crate::ros_type::RosType;

/// Name of a type without a name.
const UNNAMED: &str = "asmotion.Message";

/// The type of the messages of a channel.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelSchema {
    /// JSON, with the name and the text of its JSON Schema.
    Json(String, String),
    /// A message of ROS 2, in CDR.
    Ros(Arc<RosType>),
}

impl ChannelSchema {
    /// The schema of messages of a type: that of ROS 2 if there is one, otherwise one of JSON; of any object if the type is
    /// unknown. `name` is the name of the type if the schema has none.
    pub fn of_messages(name: &str, schema: Option<&Schema>) -> Self {
        if let Some(of) = schema.and_then(RosType::of) {
            return Self::Ros(Arc::new(of));
        }
        let Some(schema) = schema else {
            let name = if name.is_empty() { UNNAMED } else { name };
            return Self::Json(name.to_owned(), json!({ "type": "object" }).to_string());
        };
        let name = match (&*schema.name, name) {
            ("", "") => UNNAMED,
            ("", name) => name,
            (known, _) => known,
        };
        let mut definitions = SchemaDefinitions::at("#/$defs");
        let root = definitions.schema(schema);
        let root = resolved(root, &definitions.into_value());
        Self::Json(name.to_owned(), root.to_string())
    }

    /// Name of the type.
    pub fn name(&self) -> &str {
        match self {
            Self::Json(name, _) => name,
            Self::Ros(of) => &of.name,
        }
    }

    /// Definition of the type.
    pub fn definition(&self) -> &str {
        match self {
            Self::Json(_, text) => text,
            Self::Ros(of) => &of.definition,
        }
    }

    /// Name of the encoding of the definition.
    pub fn definition_encoding(&self) -> &'static str {
        match self {
            Self::Json(..) => JSON_SCHEMA,
            Self::Ros(_) => ROS2_DEFINITION,
        }
    }

    /// Name of the encoding of the messages.
    pub fn message_encoding(&self) -> &'static str {
        match self {
            Self::Json(..) => JSON,
            Self::Ros(_) => CDR,
        }
    }

    /// The type of ROS 2; `None` for JSON.
    pub fn ros_type(&self) -> Option<&Arc<RosType>> {
        match self {
            Self::Json(..) => None,
            Self::Ros(of) => Some(of),
        }
    }

    /// Encodes a message; `None` if it is not of the type.
    pub fn encode(&self, sample: &dyn Sample) -> Option<Vec<u8>> {
        RosType::encode_or_json(self.ros_type().map(|of| &**of), sample)
    }
}

/// Puts the root definition in the place of the reference to it: readers expect an object with properties.
fn resolved(root: Value, definitions: &Value) -> Value {
    let reference = root.get("$ref").and_then(Value::as_str);
    let key = reference.and_then(|path| path.strip_prefix("#/$defs/"));
    let mut root = match key.and_then(|key| definitions.get(key)) {
        Some(definition) => definition.clone(),
        None => root,
    };
    if let Value::Object(members) = &mut root {
        members.insert("$defs".to_owned(), definitions.clone());
        // a reader that wants an object gets one, whatever is in it
        members.entry("type").or_insert_with(|| "object".into());
    }
    root
}
