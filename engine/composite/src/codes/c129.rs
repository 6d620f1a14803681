use crate::nearest::{Nearest, Suggest};
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Nothing to leave out
///
/// `without` names an element that the base does not have. A path consists of the names of keys, separated by dots. A
/// connection, wire or promotion is named by one of its ends, or by both: `connections.Joystick.twist -> Rover.twist`.
///
/// ```toml base
/// schema = "composite/1"
///
/// [composite]
/// name = "base"
///
/// [components.Joystick]
/// implementation = { rust = "nav::Operator" }
///
/// [components.Maps]
/// implementation = { rust = "nav::MapServer" }
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
/// base = "base.toml"
/// without = ["components.Joystik"]
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
/// base = "base.toml"
/// without = ["components.Joystick"]
/// ```
/// An element of a nested composite belongs to the file of that composite. Write a composite that has this file as its `base`
/// and leaves the element out, and set `implementation.composite` of the component to it.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C129, error)]
#[error("`{base}` has no `{path}`")]
pub(crate) struct NothingToLeaveOut {
    pub path: String,
    pub at: Span,
    pub base: String,
    pub reason: Missing,
}

/// Reason for which there is nothing to leave out.
#[derive(Debug)]
pub(crate) enum Missing {
    /// There is no such element.
    Unknown(Option<Nearest>),
    /// It belongs to the composite in this file, which implements the component at `component`.
    Nested { component: String, file: String },
    /// It is a part of one instance of an element with `for`; all instances have it at this path.
    OfInstances(String),
}

impl Finding for NothingToLeaveOut {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match &self.reason {
            Missing::Unknown(nearest) => {
                let way_out = "name the keys that lead to it, separated by dots";
                let diagnostic = diagnostic.label(self.at, "not in the base");
                diagnostic.suggest_or(self.at, nearest, way_out)
            }
            Missing::OfInstances(declared) => diagnostic
                .label(self.at, "a part of one instance")
                .help(format!(
                    "`{declared}` leaves it out of all instances; a whole instance can be left out alone"
                )),
            Missing::Nested { component, file } => diagnostic
                .label(self.at, format!("belongs to `{file}`"))
                .help(format!(
                    "leave it out in a composite with `base = \"{file}\"`, and set `{component}.implementation.composite` to that one"
                )),
        }
    }
}
