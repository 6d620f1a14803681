use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

use crate::nearest::nearest_name;

/// Invalid name
///
/// Names consist of letters, digits, `_` and `-`, and start with a letter. An endpoint of a connection
/// is written `Component.port` or `topic:name`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "twist"
/// to = "Rover.twist"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Joystick]
/// implementation = { process = "joystick" }
/// ports.out = { twist = "geometry_msgs/Twist" }
///
/// [components.Rover]
/// implementation = { process = "rover" }
/// ports.in = { twist = "geometry_msgs/Twist" }
///
/// [[connections]]
/// from = "Joystick.twist"
/// to = "Rover.twist"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C009, error)]
#[error("`{text}` is not valid as {what}")]
pub(crate) struct InvalidName {
    pub text: String,
    pub what: &'static str,
    pub rule: &'static str,
    pub at: Span,
    /// A variable in the name that `for` does not have.
    pub variable: Option<UnknownVariable>,
}

/// A variable in a name for which `for` has no values.
#[derive(Debug)]
pub(crate) struct UnknownVariable {
    /// The variable, without `$`.
    pub name: String,
    /// The variables of the element, without `$`; empty if it has no `for`.
    pub known: Vec<String>,
}

impl UnknownVariable {
    /// Returns the first variable in a text, if there is one; `known` are those of the element, without `$`.
    pub(crate) fn in_text(text: &str, known: Vec<String>) -> Option<Self> {
        let (_, rest) = text.split_once('$')?;
        let end = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
        let name = &rest[..end.unwrap_or(rest.len())];
        let name = (!name.is_empty()).then(|| name.to_owned())?;
        Some(Self { name, known })
    }

    /// What is wrong, and what to write.
    fn explain(&self) -> (String, String) {
        let name = &self.name;
        let problem = format!("`${name}` is not a variable of `for`");
        let nearest = nearest_name(name, self.known.iter().map(String::as_str));
        let nearest = nearest.map(|it| it.name);
        let help = match (self.known.as_slice(), nearest) {
            ([], _) => format!(
                "the element has no `for`: `for = \"${name} in 1..3\"` makes an instance for each value"
            ),
            ([only], _) => format!("write `${only}`, the variable of its `for`"),
            (_, Some(nearest)) => format!("did you mean `${nearest}`?"),
            (known, None) => format!("the variables of its `for` are `${}`", known.join("`, `$")),
        };
        (problem, help)
    }
}

impl Finding for InvalidName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match &self.variable {
            Some(variable) => {
                let (problem, help) = variable.explain();
                diagnostic.label(self.at, problem).help(help)
            }
            None => diagnostic.label(self.at, "invalid form").help(self.rule),
        }
    }
}
