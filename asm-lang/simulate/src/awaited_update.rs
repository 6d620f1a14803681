//! An update that a run waits for, written by the user as `mode=ARRIVED`.

use crate::literal::Literals;
use asmotion_diagnostics::{or_did_you_mean, similar};
use asmotion_ir::{Function, FunctionKind, Program, ValueShape};
use asmotion_machine::Machine;
use std::sync::Arc;

/// A location and a value, in the notation of traces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AwaitedUpdate {
    /// The location, as in `doing(ROB1, TASK2)`.
    pub location: String,
    /// The value that an update gives it.
    pub value: String,
}

/// The reason that no step can produce the update.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AwaitError {
    /// No function has this name.
    #[error("unknown function `{name}`{}", or_did_you_mean(similar.as_deref()))]
    Unknown {
        /// Name as written.
        name: String,
        /// A declared name that is similar.
        similar: Option<Arc<str>>,
    },
    /// No overload of the function takes this number of arguments.
    #[error("`{name}` takes {expected} argument{}, not {found}", if *expected == 1 { "" } else { "s" })]
    Arity {
        /// Name of the function.
        name: String,
        /// Number of its parameters.
        expected: usize,
        /// Number of arguments given.
        found: usize,
    },
    /// Rules cannot update the function.
    #[error("no rule writes `{name}`: it is {kind}")]
    NotWritten {
        /// Name of the function.
        name: String,
        /// Its kind, as in "monitored".
        kind: &'static str,
    },
    /// The text of an argument or of the value denotes no element of its domain.
    #[error("`{text}` is not a value {place}{}", or_did_you_mean(similar.as_deref()))]
    NotAValue {
        /// Text as written.
        text: String,
        /// The position of the text, as in "of `mode`".
        place: String,
        /// An element with a similar name.
        similar: Option<Arc<str>>,
    },
}

impl AwaitedUpdate {
    /// Checks the texts against the specification of a machine, and converts them to the notation
    /// of traces.
    ///
    /// # Errors
    /// No step can produce such an update.
    pub fn of(machine: &Machine, location: &str, value: &str) -> Result<Self, AwaitError> {
        let (name, texts) = Literals::location(location);
        let function = written(machine.program(), name, texts.len())?;
        let arguments = texts.iter().zip(&function.parameters);
        let arguments: Vec<String> = arguments
            .map(|(text, shape)| element(machine, text, shape, format!("for `{name}`")))
            .collect::<Result<_, _>>()?;
        let value = element(machine, value, &function.codomain, format!("of `{name}`"))?;
        let location = match arguments.as_slice() {
            [] => name.to_owned(),
            arguments => format!("{name}({})", arguments.join(", ")),
        };
        Ok(Self { location, value })
    }
}

/// Returns the function of this name that rules update.
fn written<'p>(program: &'p Program, name: &str, arity: usize) -> Result<&'p Function, AwaitError> {
    let all = || program.symbols.functions.iter().zip(&program.functions);
    let own = || all().filter(|(_, function)| function.own);
    let named = || own().filter(|(known, _)| &***known == name);
    let fitting = named().find(|(_, function)| function.parameters.len() == arity);
    let Some((_, function)) = fitting.or_else(|| named().next()) else {
        let written = own().filter(|(_, function)| unwritten(function.kind).is_none());
        return Err(AwaitError::Unknown {
            name: name.to_owned(),
            similar: similar(name, written.map(|(known, _)| known)).cloned(),
        });
    };
    let name = name.to_owned();
    if let Some(kind) = unwritten(function.kind) {
        return Err(AwaitError::NotWritten { name, kind });
    }
    match function.parameters.len() {
        wanted if wanted == arity => Ok(function),
        wanted => Err(AwaitError::Arity {
            name,
            expected: wanted,
            found: arity,
        }),
    }
}

/// Returns the kind of a function that rules cannot update, otherwise `None`.
fn unwritten(kind: FunctionKind) -> Option<&'static str> {
    match kind {
        FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared => None,
        FunctionKind::Monitored => Some("monitored"),
        FunctionKind::Local => Some("local to a rule"),
        FunctionKind::Fixed => Some("static or derived"),
    }
}

/// Converts the text of a value to the notation of traces.
fn element(
    machine: &Machine,
    text: &str,
    shape: &ValueShape,
    place: String,
) -> Result<String, AwaitError> {
    let literals = Literals::new(machine.program(), &[]);
    match literals.value(text, shape) {
        Some(value) => Ok(value.show(&machine.naming()).to_string()),
        // accepted unchecked: the name of an element that `extend` may still create
        None if text.contains('!') => Ok(text.trim().to_owned()),
        None => Err(AwaitError::NotAValue {
            text: text.to_owned(),
            place,
            similar: literals
                .names(shape)
                .and_then(|names| similar(text, names).cloned()),
        }),
    }
}
