//! Locations of functions, as bindings name them.

use std::fmt;

/// A function, or a location of it, as a binding names it: `estop`, `wants(ROB1)` or `wants($r)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LocationName {
    /// Name of the function.
    pub function: String,
    /// Arguments; empty for a function without arguments.
    pub arguments: Vec<LocationArgument>,
}

/// An argument of a [`LocationName`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LocationArgument {
    /// An element of the domain, such as `ROB1`, `3` or `true`.
    Element(String),
    /// A variable that ranges over the domain, without its dollar sign.
    Variable(String),
}

impl LocationName {
    /// Iterates over the names of the variables, in order of the arguments.
    pub fn variables(&self) -> impl Iterator<Item = &str> {
        self.arguments.iter().filter_map(|argument| match argument {
            LocationArgument::Variable(name) => Some(name.as_str()),
            LocationArgument::Element(_) => None,
        })
    }
}

/// A text without a complete list of arguments names a function, which then does not exist.
impl From<&str> for LocationName {
    fn from(text: &str) -> Self {
        let text = text.trim();
        let (function, arguments) = match text.strip_suffix(')').and_then(|it| it.split_once('(')) {
            Some((function, inner)) if !inner.trim().is_empty() => {
                let arguments = inner.split(',').map(LocationArgument::from);
                (function.trim_end(), arguments.collect())
            }
            Some(_) | None => (text, Vec::new()),
        };
        let function = function.to_owned();
        Self {
            function,
            arguments,
        }
    }
}

impl From<String> for LocationName {
    fn from(text: String) -> Self {
        Self::from(text.as_str())
    }
}

impl From<&str> for LocationArgument {
    fn from(text: &str) -> Self {
        let text = text.trim();
        match text.strip_prefix('$') {
            Some(name) => Self::Variable(name.to_owned()),
            None => Self::Element(text.to_owned()),
        }
    }
}

impl fmt::Display for LocationName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.function)?;
        if self.arguments.is_empty() {
            return Ok(());
        }
        let arguments: Vec<String> = self.arguments.iter().map(ToString::to_string).collect();
        write!(f, "({})", arguments.join(", "))
    }
}

impl fmt::Display for LocationArgument {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Element(name) => f.write_str(name),
            Self::Variable(name) => write!(f, "${name}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::LocationName;

    #[test]
    fn a_name_is_displayed_as_it_was_read() {
        for text in ["estop", "wants(ROB1)", "at($r, 3)"] {
            assert_eq!(LocationName::from(text).to_string(), text);
        }
        assert_eq!(LocationName::from("at( $r,3 )").to_string(), "at($r, 3)");
        assert_eq!(LocationName::from("at(").arguments, []);
    }

    #[test]
    fn its_variables_are_in_the_order_of_the_arguments() {
        let name = LocationName::from("at($r, ZONE1, $z)");
        assert_eq!(name.variables().collect::<Vec<_>>(), ["r", "z"]);
    }
}
