//! Names of queues.

use std::fmt;

use crate::error::QueueCheckError;

/// The name of a queue, `/jointStatus`: a slash, and something without slashes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueName(String);

/// What the kernel takes, the slash left out.
const LONGEST: usize = 255;

impl QueueName {
    /// A name.
    ///
    /// # Errors
    /// It is none.
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

    /// As it is written.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// As it is written in a composite: `mqueue:/jointStatus`.
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
