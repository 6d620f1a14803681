//! An update that a run waits for, as a person names it: `mode=ARRIVED`.

use crate::literal::Literals;
use asmotion_diagnostics::similar;
use asmotion_ir::{Function, FunctionKind, Program, ValueShape};
use asmotion_machine::Machine;
use std::sync::Arc;

/// A location and a value, written as steps show them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AwaitedUpdate {
    /// The location.
    pub location: String,
    /// What it is to become.
    pub value: String,
}

/// Why no step can bring what is awaited.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AwaitError {
    /// There is no function of this name.
    #[error("there is no function `{name}`{}", meant(similar.as_deref()))]
    Unknown {
        /// What was written.
        name: String,
        /// A name like it.
        similar: Option<Arc<str>>,
    },
    /// No function of this name takes so many arguments.
    #[error("`{name}` takes {wanted} argument{}, not {found}", if *wanted == 1 { "" } else { "s" })]
    Arity {
        /// The function.
        name: String,
        /// How many it takes.
        wanted: usize,
        /// How many there are.
        found: usize,
    },
    /// Rules do not write it.
    #[error("no rule writes `{name}`: it is {kind}")]
    NotWritten {
        /// The function.
        name: String,
        /// What it is.
        kind: &'static str,
    },
    /// An argument or the value is none.
    #[error("`{text}` is no value {place}{}", meant(similar.as_deref()))]
    NotAValue {
        /// What was written.
        text: String,
        /// As in "of `mode`".
        place: String,
        /// An element like it.
        similar: Option<Arc<str>>,
    },
}

fn meant(similar: Option<&str>) -> String {
    similar.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

impl AwaitedUpdate {
    /// What the texts name in a specification that is about to run.
    ///
    /// # Errors
    /// No step can ever write this value there.
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

/// The function of this name that rules write.
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
            wanted,
            found: arity,
        }),
    }
}

/// Why rules do not write such functions, if they do not.
fn unwritten(kind: FunctionKind) -> Option<&'static str> {
    match kind {
        FunctionKind::Controlled | FunctionKind::Out | FunctionKind::Shared => None,
        FunctionKind::Monitored => Some("monitored"),
        FunctionKind::Local => Some("local to a rule"),
        FunctionKind::Fixed => Some("static or derived"),
    }
}

/// A value as steps show it.
fn element(
    machine: &Machine,
    text: &str,
    shape: &ValueShape,
    place: String,
) -> Result<String, AwaitError> {
    let literals = Literals::new(machine.program(), &[]);
    match literals.value(text, shape) {
        Some(value) => Ok(value.show(&machine.naming()).to_string()),
        // an element that `extend` will take from the reserve
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
