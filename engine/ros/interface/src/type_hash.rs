//! The type hash of ROS 2 (REP 2016), which peers announce with their topics and services.

use std::fmt;

use sha2::{Digest, Sha256};

use crate::catalogue::Catalogue;
use crate::error::DefinitionError;
use crate::name::InterfaceName;

/// A type hash of version 1, printed as `RIHS01_` and 64 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TypeHash(pub [u8; 32]);

impl fmt::Display for TypeHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("RIHS01_")?;
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Catalogue {
    /// The type hash of an interface: the SHA-256 sum of its type description, as JSON.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself. Services need `service_msgs`, actions also
    /// `unique_identifier_msgs`.
    pub fn type_hash(&self, name: &InterfaceName) -> Result<TypeHash, DefinitionError> {
        let text = self.type_description(name)?.to_json();
        Ok(TypeHash(Sha256::digest(text).into()))
    }
}
