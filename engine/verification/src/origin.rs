//! Where the values of inputs come from, in words.

/// Where values of an input come from.
#[derive(Clone, Debug, PartialEq)]
pub struct ValueOrigin {
    /// The values; `None` if they are not listed.
    pub values: Option<Vec<String>>,
    /// The component and its port, or the call.
    pub from: String,
}
