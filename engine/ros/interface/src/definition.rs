//! Definitions: the constants and fields of messages, and the parts of services and actions.

use std::fmt;

use crate::name::InterfaceName;

/// The definition of an interface.
#[derive(Debug, Clone, PartialEq)]
pub enum Interface {
    /// A message.
    Message(Structure),
    /// A service.
    Service {
        /// Data that the client sends.
        request: Structure,
        /// Data that the server answers.
        response: Structure,
    },
    /// An action.
    Action {
        /// Data that the client sends to start the action.
        goal: Structure,
        /// Data that the server sends at its end.
        result: Structure,
        /// Data that the server sends on the way.
        feedback: Structure,
    },
}

/// Constants and fields, in order of their declaration.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Structure {
    /// Constants, which are not transmitted.
    pub constants: Vec<Constant>,
    /// Fields.
    pub fields: Vec<Field>,
}

/// A named value.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Type: a primitive type or a string.
    pub element: Element,
    /// Name.
    pub name: String,
    /// Value, as it is written.
    pub value: String,
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Type.
    pub of: FieldType,
    /// Name, unique in the message.
    pub name: String,
    /// Value in a new message, as it is written; ROS 2 only.
    pub default: Option<String>,
}

/// The type of a field: an element, once or several times.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldType {
    /// Type of each element.
    pub element: Element,
    /// Number of elements.
    pub count: Count,
}

/// The type of a single value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Element {
    /// A number, a Boolean, or a time of ROS 1.
    Primitive(Primitive),
    /// UTF-8 text, in ROS 2 possibly with a largest number of bytes.
    String(Option<usize>),
    /// UTF-16 text of ROS 2, possibly with a largest number of code units.
    WideString(Option<usize>),
    /// Another message.
    Message(InterfaceName),
}

/// The number of elements of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    /// A single value.
    One,
    /// An array, `[N]`.
    Exactly(usize),
    /// A sequence of at most so many elements, `[<=N]`; ROS 2 only.
    AtMost(usize),
    /// A sequence, `[]`.
    Any,
}

/// The primitive types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Primitive {
    /// A Boolean.
    Bool,
    /// Eight bits: an `int8` in ROS 1, unsigned in ROS 2.
    Byte,
    /// Eight bits, unsigned.
    Char,
    /// 8-bit signed integer.
    Int8,
    /// 8-bit unsigned integer.
    Uint8,
    /// 16-bit signed integer.
    Int16,
    /// 16-bit unsigned integer.
    Uint16,
    /// 32-bit signed integer.
    Int32,
    /// 32-bit unsigned integer.
    Uint32,
    /// 64-bit signed integer.
    Int64,
    /// 64-bit unsigned integer.
    Uint64,
    /// Single-precision float.
    Float32,
    /// Double-precision float.
    Float64,
    /// Seconds and nanoseconds since an epoch; ROS 1 only.
    Time,
    /// Seconds and nanoseconds between two times; ROS 1 only.
    Duration,
}

impl Primitive {
    /// All primitive types.
    pub const ALL: [Self; 15] = [
        Self::Bool,
        Self::Byte,
        Self::Char,
        Self::Int8,
        Self::Uint8,
        Self::Int16,
        Self::Uint16,
        Self::Int32,
        Self::Uint32,
        Self::Int64,
        Self::Uint64,
        Self::Float32,
        Self::Float64,
        Self::Time,
        Self::Duration,
    ];

    /// The name in definitions.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Byte => "byte",
            Self::Char => "char",
            Self::Int8 => "int8",
            Self::Uint8 => "uint8",
            Self::Int16 => "int16",
            Self::Uint16 => "uint16",
            Self::Int32 => "int32",
            Self::Uint32 => "uint32",
            Self::Int64 => "int64",
            Self::Uint64 => "uint64",
            Self::Float32 => "float32",
            Self::Float64 => "float64",
            Self::Time => "time",
            Self::Duration => "duration",
        }
    }

    /// The type with this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }
}

impl Interface {
    /// The structures, in the order of the file.
    pub fn structures(&self) -> Vec<&Structure> {
        match self {
            Self::Message(structure) => vec![structure],
            Self::Service { request, response } => vec![request, response],
            Self::Action {
                goal,
                result,
                feedback,
            } => vec![goal, result, feedback],
        }
    }
}

/// The text of a definition, without comments: one line for each constant and field, and `---` between structures.
impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, structure) in self.structures().into_iter().enumerate() {
            if index > 0 {
                writeln!(f, "---")?;
            }
            write!(f, "{structure}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Structure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Constant {
            element,
            name,
            value,
        } in &self.constants
        {
            writeln!(f, "{element} {name}={value}")?;
        }
        for Field { of, name, default } in &self.fields {
            write!(f, "{of} {name}")?;
            match default {
                Some(default) => writeln!(f, " {default}")?,
                None => writeln!(f)?,
            }
        }
        Ok(())
    }
}

impl fmt::Display for FieldType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.element, self.count)
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Primitive(primitive) => f.write_str(primitive.name()),
            Self::String(None) => f.write_str("string"),
            Self::String(Some(bound)) => write!(f, "string<={bound}"),
            Self::WideString(None) => f.write_str("wstring"),
            Self::WideString(Some(bound)) => write!(f, "wstring<={bound}"),
            Self::Message(name) => f.write_str(&name.short()),
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One => Ok(()),
            Self::Exactly(count) => write!(f, "[{count}]"),
            Self::AtMost(count) => write!(f, "[<={count}]"),
            Self::Any => f.write_str("[]"),
        }
    }
}
