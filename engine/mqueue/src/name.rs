//! Names of queues.

use std::fmt;

use crate::error::QueueCheckError;

/// The name of a queue, for example `/jointStatus`: a slash, followed by characters other than a slash.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueName(String);

/// The kernel's limit (`NAME_MAX`), without the slash.
const LONGEST: usize = 255;

impl QueueName {
    /// Checks a name.
    ///
    /// # Errors
    /// [`QueueCheckError::Name`] if it is invalid.
    pub fn new(name: &str) -> Result<Self, QueueCheckError> {
        match name.strip_prefix('/') {
            Some(rest)
                if !rest.is_empty()
                    && rest.len() <= LONGEST
                    && !rest.contains(['/', '\0'])
                    && rest != "."
                    && rest != ".." =>
            {
                Ok(Self(name.to_owned()))
            }
            _ => Err(QueueCheckError::Name {
                name: name.to_owned(),
            }),
        }
    }

    /// The name with its slash.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// Displays the name as in a composite: `mqueue:/jointStatus`.
impl fmt::Display for QueueName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "mqueue:{}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::QueueName;

    #[test]
    fn a_name_is_a_slash_and_something_without() {
        assert!(QueueName::new("/jointStatus").is_ok());
        for wrong in ["", "/", "jointStatus", "/a/b", "//", "/..", "/a\0b"] {
            assert!(QueueName::new(wrong).is_err(), "{wrong:?}");
        }
        assert!(QueueName::new(&format!("/{}", "a".repeat(256))).is_err());
    }
}
