//! Contents of messages and requests, and the values that messages must have.

use crate::bind_error::BindError;
use crate::binding::Argument;
use crate::convert::datum_of;
use crate::frame::InputFrame;
use crate::requests::Requests;
use crate::terms::BindingTerms;
use crate::typed_input::TypedInput;
use asmotion_component::{Cycle, Time};
use asmotion_datum::Datum;
use asmotion_lang::ir::AddedTerm;
use asmotion_lang::machine::{Machine, StepFault};
use asmotion_lang::value::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// An [`Argument`] whose terms are part of the machine's program.
pub(crate) enum BoundContent {
    Kept { name: String, path: Option<String> },
    Record(Vec<(String, BoundContent)>),
    Value(Datum),
    Term { term: AddedTerm, text: String },
}

impl BoundContent {
    pub fn resolve(argument: &Argument, terms: &BindingTerms) -> Result<Self, BindError> {
        Ok(match argument {
            Argument::Kept { name, path } => Self::Kept {
                name: name.clone(),
                path: path.clone(),
            },
            Argument::Record(fields) => {
                let fields = fields.iter();
                let fields =
                    fields.map(|(name, field)| Ok((name.clone(), Self::resolve(field, terms)?)));
                Self::Record(fields.collect::<Result<_, _>>()?)
            }
            Argument::Value(value) => Self::Value(value.datum.clone()),
            Argument::Term(text) => Self::Term {
                term: terms.get(text)?,
                text: text.clone(),
            },
        })
    }
}

/// The machine after a step, which evaluates terms in the new state with the inputs of the step.
pub(crate) struct AfterStep<'m> {
    pub machine: &'m mut Machine,
    pub frame: &'m mut InputFrame,
    /// The first fault of a term.
    pub fault: Option<Box<StepFault>>,
}

impl AfterStep<'_> {
    /// The value of a term as a datum; `None` if it is undef, or if its evaluation fails.
    pub fn value(&mut self, term: AddedTerm, now: Time) -> Option<Datum> {
        match self.machine.evaluate(term, self.frame, now.nanos()) {
            Ok(Value::Undef) => None,
            Ok(value) => Some(datum_of(&value, &self.machine.naming())),
            Err(fault) => {
                self.fault.get_or_insert(fault);
                None
            }
        }
    }
}

/// The sources of message contents.
pub(crate) struct EffectContext<'k> {
    /// Responses by the names under which they are kept.
    pub kept: &'k BTreeMap<String, Datum>,
    /// Input ports by name.
    pub ports: &'k [TypedInput],
    pub requests: &'k Requests,
    /// The newest messages published on output ports, by port.
    pub published: &'k BTreeMap<String, Datum>,
}

impl EffectContext<'_> {
    /// The kept response, the newest message received, the newest request or the newest message published under this name.
    fn datum<'k>(&'k self, name: &str, cycle: &'k Cycle<'_>) -> Option<Cow<'k, Datum>> {
        let received = || {
            let input = self.ports.iter().find(|it| it.name == name)?;
            Some(input.completed(cycle.read(input.port).any()?))
        };
        let kept = self.kept.get(name).map(Cow::Borrowed).or_else(received);
        kept.or_else(|| {
            let requested = self.requests.last(name);
            let other = requested.or_else(|| self.published.get(name));
            other.map(Cow::Borrowed)
        })
    }
}

/// Builds a message or request.
///
/// # Errors
/// The name of a response, port or service without data yet, or a term that is undef. Zeros in their place would look
/// like real data.
pub(crate) fn evaluate(
    content: &BoundContent,
    context: &EffectContext<'_>,
    after: &mut AfterStep<'_>,
    cycle: &Cycle<'_>,
) -> Result<Datum, String> {
    match content {
        BoundContent::Value(value) => Ok(value.clone()),
        BoundContent::Record(fields) => {
            let mut record = Vec::new();
            for (name, field) in fields {
                record.push((name.clone(), evaluate(field, context, after, cycle)?));
            }
            Ok(Datum::record(record))
        }
        BoundContent::Term { term, text } => {
            let value = after.value(*term, cycle.now());
            value.ok_or_else(|| text.clone())
        }
        BoundContent::Kept { name, path } => {
            let datum = context.datum(name, cycle);
            let part = match path {
                Some(path) => datum.as_ref().and_then(|whole| whole.get(path)),
                None => datum,
            };
            part.map(Cow::into_owned).ok_or_else(|| match path {
                Some(path) => format!("{name}.{path}"),
                None => name.clone(),
            })
        }
    }
}

/// Returns whether a message has the expected values: a record is compared field by field, without the fields that it does
/// not have; numbers are equal if their values are.
pub(crate) fn has_values(message: &Datum, expected: &Datum) -> bool {
    if let Datum::Record(fields) = expected {
        let mut fields = fields.iter();
        return fields.all(|(name, value)| {
            let part = message.get(name);
            part.is_some_and(|part| has_values(&part, value))
        });
    }
    let is_same_number = match (message.as_int(), expected.as_int()) {
        (Some(found), Some(expected)) => found == expected,
        (None, _) | (_, None) => {
            message.as_float().is_some() && message.as_float() == expected.as_float()
        }
    };
    message == expected || is_same_number
}
