//! Sources of the values of inputs, in words.

/// A source of the values of an input.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueOrigin {
    /// The values; `None` if they are not listed.
    pub values: Option<Vec<String>>,
    /// The component and its port, or the call.
    pub from: String,
}
