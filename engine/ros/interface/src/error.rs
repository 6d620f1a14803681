//! Errors of definitions.

use std::io;
use std::path::PathBuf;

use crate::name::InterfaceName;

/// An interface is not defined, or its definition is wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{interface}{}: {problem}", At(*line))]
pub struct DefinitionError {
    /// Name of the interface.
    pub interface: InterfaceName,
    /// Line of the definition, from 1, if the problem is at one.
    pub line: Option<usize>,
    /// Cause.
    pub problem: DefinitionProblem,
}

/// The causes of a [`DefinitionError`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DefinitionProblem {
    /// The catalogue has no such interface.
    #[error("it is not defined; a folder with its package can be added")]
    Undefined,
    /// A message contains a message that the catalogue does not have.
    #[error("`{0}`, the type of a field, is not defined; a folder with its package can be added")]
    UndefinedField(InterfaceName),
    /// A message contains itself.
    #[error("`{0}` contains itself")]
    Recursive(InterfaceName),
    /// A line is neither a field nor a constant.
    #[error("`{0}` is neither a field, such as `float64 x`, nor a constant, such as `uint8 RED=1`")]
    Line(String),
    /// A type is not written correctly.
    #[error("`{0}` is not a type")]
    Type(String),
    /// A type exists in the other generation of ROS only.
    #[error("`{0}` is not a type of this generation of ROS")]
    OtherGeneration(String),
    /// A name is not an identifier.
    #[error("`{0}` is not a name: letters, digits and underscores, and first a letter")]
    Name(String),
    /// Two fields, or two constants, have the same name.
    #[error("`{0}` is declared twice")]
    Twice(String),
    /// The type of a constant is a message or an array.
    #[error("a constant cannot have the type `{0}`")]
    Constant(String),
    /// The number of structures does not agree with the kind.
    #[error("{found} parts, separated by `---`; {wanted} are needed")]
    Parts {
        /// Number of parts in the text.
        found: usize,
        /// Number of parts of this kind of interface.
        wanted: usize,
    },
}

/// A folder with definitions cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Read {
        /// The folder or file.
        path: PathBuf,
        /// Reason.
        source: io::Error,
    },
    /// A file is too large for a definition.
    #[error("{}: {size} bytes; a definition has at most {most}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size, in bytes.
        size: u64,
        /// The limit, in bytes.
        most: u64,
    },
    /// A definition is wrong.
    #[error("{}: {error}", path.display())]
    Definition {
        /// The file.
        path: PathBuf,
        /// Reason.
        error: Box<DefinitionError>,
    },
    /// The folder has no definition.
    #[error("{}: no definitions `PACKAGE/msg/NAME.msg`, `srv/NAME.srv` or `action/NAME.action`", .0.display())]
    Empty(PathBuf),
}

/// Prints the line of an error, if there is one.
struct At(Option<usize>);

impl std::fmt::Display for At {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            Some(line) => write!(f, ", line {line}"),
            None => Ok(()),
        }
    }
}
