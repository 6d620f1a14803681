//! The headers with which both ends of a TCPROS connection introduce themselves. Source: the ROS wiki, "ROS/Connection Header".
//!
//! ```text
//! u32 length of the rest │ u32 length of a field │ name=value │ u32 length … │ …
//! ```

use std::sync::Arc;

/// Limit on the size of a header, in bytes. Definitions of messages are part of it.
pub const MAX_HEADER: usize = 1 << 20;

/// Fields of a header, by name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ConnectionHeader {
    fields: Vec<(Box<str>, Arc<str>)>,
}

/// Bytes are not a header.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HeaderError {
    /// The header is larger than [`MAX_HEADER`].
    #[error("a header of {0} bytes; the limit is {MAX_HEADER}")]
    TooLarge(usize),
    /// A field is longer than the rest of the header.
    #[error("a field at byte {position} of the header is longer than the rest")]
    Truncated {
        /// Position of the field's length.
        position: usize,
    },
    /// A field is not UTF-8.
    #[error("a field at byte {position} of the header is not UTF-8")]
    Encoding {
        /// Position of the field's length.
        position: usize,
    },
    /// A field has no `=`.
    #[error("a field at byte {position} of the header has no `=`")]
    Field {
        /// Position of the field's length.
        position: usize,
    },
}

impl ConnectionHeader {
    /// A header without fields.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a field.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Arc<str>>) -> Self {
        self.fields.push((name.into(), value.into()));
        self
    }

    /// The value of a field; of the last one, if there are several.
    pub fn get(&self, name: &str) -> Option<&str> {
        let mut fields = self.fields.iter().rev();
        fields.find(|(it, _)| **it == *name).map(|(_, it)| &**it)
    }

    /// Whether a field has the value `1`.
    pub fn is_set(&self, name: &str) -> bool {
        self.get(name) == Some("1")
    }

    /// The fields, in their order.
    pub fn fields(&self) -> impl Iterator<Item = (&str, &str)> {
        self.fields.iter().map(|(name, value)| (&**name, &**value))
    }

    /// The header with its length in front.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = vec![0; 4];
        for (name, value) in &self.fields {
            let length = name.len() + 1 + value.len();
            out.extend((length as u32).to_le_bytes());
            out.extend(name.bytes());
            out.push(b'=');
            out.extend(value.bytes());
        }
        let length = (out.len() - 4) as u32;
        out[..4].copy_from_slice(&length.to_le_bytes());
        out
    }

    /// Reads a header from the bytes after its length.
    ///
    /// # Errors
    /// See [`HeaderError`].
    pub fn decode(bytes: &[u8]) -> Result<Self, HeaderError> {
        if bytes.len() > MAX_HEADER {
            return Err(HeaderError::TooLarge(bytes.len()));
        }
        let mut fields = Vec::new();
        let mut position = 0;
        while position < bytes.len() {
            let truncated = HeaderError::Truncated { position };
            let rest = &bytes[position..];
            let (length, rest) = rest.split_first_chunk().ok_or(truncated.clone())?;
            let length = u32::from_le_bytes(*length) as usize;
            let field = rest.get(..length).ok_or(truncated)?;
            let field =
                std::str::from_utf8(field).map_err(|_| HeaderError::Encoding { position })?;
            let field = field
                .split_once('=')
                .ok_or(HeaderError::Field { position })?;
            fields.push((field.0.into(), field.1.into()));
            position += 4 + length;
        }
        Ok(Self { fields })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_has_the_bytes_of_the_specification() {
        let header = ConnectionHeader::new().with("a", "b=c").with("topic", "/é");
        let bytes = header.encode();
        assert_eq!(&bytes[..13], b"\x16\0\0\0\x05\0\0\0a=b=c");
        assert_eq!(bytes.len(), 4 + 0x16);
        let read = ConnectionHeader::decode(&bytes[4..]).unwrap();
        assert_eq!(read, header);
        assert_eq!(read.get("topic"), Some("/é"));
        assert_eq!(read.get("b"), None);
    }

    #[test]
    fn bad_headers_are_errors() {
        let field = |text: &[u8]| [&(text.len() as u32).to_le_bytes(), text].concat();
        let good = field(b"a=b");
        let read = |bytes: &[u8]| ConnectionHeader::decode(bytes).unwrap_err();
        assert_eq!(
            read(&[&*good, b"\x01\0"].concat()),
            HeaderError::Truncated { position: 7 }
        );
        assert_eq!(
            read(b"\xff\xff\xff\xffa=b"),
            HeaderError::Truncated { position: 0 }
        );
        assert_eq!(
            read(&field(b"a=\xff")),
            HeaderError::Encoding { position: 0 }
        );
        assert_eq!(read(&field(b"ab")), HeaderError::Field { position: 0 });
        assert_eq!(
            read(&vec![0; MAX_HEADER + 1]),
            HeaderError::TooLarge(MAX_HEADER + 1)
        );
    }
}
