//! The MD5 sum of ROS 1, which both ends of a connection compare.
//!
//! It is the sum of the definition without comments: first the constants, then the fields, in their order. The sum of a
//! message takes the place of the type of a field that contains it. The sum of a service is that of both texts, one after
//! the other. Source: the ROS wiki, "ROS/Technical Overview", section *Message serialization and msg MD5 sums*.

use std::fmt;

use md5::{Digest, Md5};

use crate::catalogue::Catalogue;
use crate::definition::{Element, FieldType, Structure};
use crate::error::DefinitionError;
use crate::name::InterfaceName;

/// An MD5 sum, printed as 32 hexadecimal digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Md5Sum(pub [u8; 16]);

impl fmt::Display for Md5Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl Catalogue {
    /// The MD5 sum of a message or service.
    ///
    /// An action has none: its messages `NAMEAction`, `NAMEActionGoal` and so on have.
    ///
    /// # Errors
    /// A definition is missing, or a message contains itself.
    pub fn md5(&self, name: &InterfaceName) -> Result<Md5Sum, DefinitionError> {
        self.contained(name)?;
        let mut whole = Md5::new();
        for structure in self.interface(name)?.structures() {
            whole.update(self.summed_text(structure)?);
        }
        Ok(Md5Sum(whole.finalize().into()))
    }

    /// The text of which the sum is taken.
    fn summed_text(&self, structure: &Structure) -> Result<String, DefinitionError> {
        let mut lines = Vec::new();
        for constant in &structure.constants {
            lines.push(format!(
                "{} {}={}",
                constant.element, constant.name, constant.value
            ));
        }
        for field in &structure.fields {
            let FieldType { element, count } = &field.of;
            lines.push(match element {
                Element::Message(name) => {
                    let inner = self.message(name)?;
                    let text = self.summed_text(inner)?;
                    let sum = Md5Sum(Md5::digest(text).into());
                    format!("{sum} {}", field.name)
                }
                Element::Primitive(_) | Element::String(_) | Element::WideString(_) => {
                    format!("{element}{count} {}", field.name)
                }
            });
        }
        Ok(lines.join("\n"))
    }
}
