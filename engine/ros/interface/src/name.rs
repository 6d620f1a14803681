//! Names of interfaces: `geometry_msgs/msg/Twist`.

use std::fmt;
use std::str::FromStr;

/// The kinds of interfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum InterfaceKind {
    /// A message, in a file `.msg`.
    Message,
    /// A service, in a file `.srv`.
    Service,
    /// An action, in a file `.action`.
    Action,
}

impl InterfaceKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Message, Self::Service, Self::Action];

    /// The name of the folder and the extension of the files.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Message => "msg",
            Self::Service => "srv",
            Self::Action => "action",
        }
    }

    /// The kind whose files are in a folder of this name.
    pub fn of_folder(folder: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.folder() == folder)
    }
}

/// The name of an interface: its package, its kind, and its name in the package.
///
/// It is read from `geometry_msgs/msg/Twist`, or from `geometry_msgs/Twist`, which is a message.
///
/// ```
/// use asmotion_ros_interface::InterfaceName;
///
/// let name: InterfaceName = "geometry_msgs/Twist".parse()?;
/// assert_eq!(name.to_string(), "geometry_msgs/msg/Twist");
/// assert_eq!(name.short(), "geometry_msgs/Twist");
/// # Ok::<(), asmotion_ros_interface::NameError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct InterfaceName {
    package: Box<str>,
    kind: InterfaceKind,
    name: Box<str>,
}

/// A text is not the name of an interface.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is not the name of an interface, such as `geometry_msgs/msg/Twist`")]
pub struct NameError {
    /// The text.
    pub text: String,
}

impl InterfaceName {
    /// A name from its parts.
    ///
    /// # Errors
    /// The package or the name is not an identifier.
    pub fn new(package: &str, kind: InterfaceKind, name: &str) -> Result<Self, NameError> {
        if !is_identifier(package) || !is_identifier(name) {
            let text = format!("{package}/{}/{name}", kind.folder());
            return Err(NameError { text });
        }
        Ok(Self {
            package: package.into(),
            kind,
            name: name.into(),
        })
    }

    /// The name of a message. Both parts are identifiers.
    pub(crate) fn message(package: &str, name: &str) -> Self {
        Self {
            package: package.into(),
            kind: InterfaceKind::Message,
            name: name.into(),
        }
    }

    /// The package.
    pub fn package(&self) -> &str {
        &self.package
    }

    /// The kind.
    pub fn kind(&self) -> InterfaceKind {
        self.kind
    }

    /// The name in the package.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name without the kind, as ROS 1 writes it.
    pub fn short(&self) -> String {
        format!("{}/{}", self.package, self.name)
    }

    /// The name of a part of this service or action, of the same package and kind: `Fibonacci_Goal`.
    pub(crate) fn part(&self, suffix: &str) -> Self {
        Self {
            name: format!("{}_{suffix}", self.name).into(),
            ..self.clone()
        }
    }
}

impl fmt::Display for InterfaceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            package,
            kind,
            name,
        } = self;
        write!(f, "{package}/{}/{name}", kind.folder())
    }
}

impl FromStr for InterfaceName {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let wrong = || NameError {
            text: text.to_owned(),
        };
        let mut parts = text.split('/');
        let (package, second) = (parts.next(), parts.next());
        let (kind, name) = match parts.next() {
            Some(name) => {
                let kind = second.and_then(InterfaceKind::of_folder);
                (kind.ok_or_else(wrong)?, name)
            }
            None => (InterfaceKind::Message, second.ok_or_else(wrong)?),
        };
        if parts.next().is_some() {
            return Err(wrong());
        }
        Self::new(package.unwrap_or_default(), kind, name).map_err(|_| wrong())
    }
}

/// Returns `true` for a letter followed by letters, digits and underscores.
pub(crate) fn is_identifier(text: &str) -> bool {
    text.starts_with(|first: char| first.is_ascii_alphabetic())
        && text
            .chars()
            .all(|sign| sign.is_ascii_alphanumeric() || sign == '_')
}
