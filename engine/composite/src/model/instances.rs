//! The key `for`.

use serde_json::{Value as Json, json};

use crate::at::At;
use crate::table::derived::{Node, Reader};
use crate::table::{Key, Value};

/// The value of `for`. Elements with it are replaced by their instances before the model is read, so that no element of a model
/// has one.
#[derive(Clone, Copy, Debug)]
pub enum Instances {}

impl Value for Instances {
    fn schema(_: &Key) -> Json {
        let row = json!({
            "type": "object",
            "minProperties": 1,
            "additionalProperties": { "type": ["string", "number", "boolean"] },
        });
        json!({ "anyOf": [
            { "type": "string", "pattern": r"^\s*\$[A-Za-z][A-Za-z0-9_]* in .+$" },
            { "type": "array", "items": row, "minItems": 1 },
        ] })
    }

    fn read(_: &mut Reader<'_>, _: &At<String>, _: &Key, _: &Node) -> Option<Self> {
        None
    }
}
