//! Values of XML-RPC.

/// A value of XML-RPC.
#[derive(Debug, Clone, PartialEq)]
pub enum XmlRpcValue {
    /// An integer. The standard has 32 bits; more are read from `i8`, and not written.
    Int(i64),
    /// A Boolean.
    Bool(bool),
    /// A float.
    Double(f64),
    /// A text.
    Text(String),
    /// A time, as it was written.
    Time(String),
    /// Bytes.
    Bytes(Vec<u8>),
    /// A list.
    Array(Vec<XmlRpcValue>),
    /// Named members, in their order.
    Struct(Vec<(String, XmlRpcValue)>),
}

impl XmlRpcValue {
    /// A text.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// The content of an integer.
    pub fn as_int(&self) -> Option<i64> {
        if let Self::Int(value) = self {
            Some(*value)
        } else {
            None
        }
    }

    /// The content of a text.
    pub fn as_text(&self) -> Option<&str> {
        if let Self::Text(text) = self {
            Some(text)
        } else {
            None
        }
    }

    /// The elements of an array.
    pub fn as_array(&self) -> Option<&[XmlRpcValue]> {
        if let Self::Array(elements) = self {
            Some(elements)
        } else {
            None
        }
    }

    /// The elements of an array of texts.
    pub fn as_texts(&self) -> Option<Vec<&str>> {
        self.as_array()?.iter().map(Self::as_text).collect()
    }
}
