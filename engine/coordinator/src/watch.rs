//! What a coordinator watches.

use serde::{Deserialize, Serialize};

pub use asmotion_verify::GivenProperty;

/// The properties to watch, and the reaction to violations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Watch {
    /// Neither the temporal properties of the specification nor `properties` are watched. Invariants are always checked.
    pub is_off: bool,
    /// A rule in the scope of the specification, as in `r_halt[IDLE]`, that replaces the main rule in a step that violates a
    /// property.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub safe_rule: Option<String>,
    /// Properties in addition to those of the specification.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub properties: Vec<GivenProperty>,
}
