//! Messages of a component as values of the functions of its protocol.

use super::super::observed::{MessageEnd, ObservedMessage, ProtocolDeviation};
use super::{ExpectedValue, ProtocolAcceptor};
use crate::actor::Codomain;
use asmotion_coordinator::Receive;
use asmotion_datum::Datum;
use asmotion_lang::Value;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::value::Atom;
use std::borrow::Cow;
use std::collections::BTreeMap;

impl ProtocolAcceptor {
    /// Messages of the component, as values of the out functions.
    pub(super) fn expected(
        &self,
        sent: &[ObservedMessage],
    ) -> Result<BTreeMap<FunctionId, Vec<ExpectedValue>>, ProtocolDeviation> {
        let mut expected: BTreeMap<FunctionId, Vec<ExpectedValue>> = BTreeMap::new();
        for output in &self.outputs {
            for message in sent.iter().filter(|it| it.end == output.end) {
                let part = part(&message.content, output.field.as_deref());
                let value = self.value(&output.output.codomain, part.as_deref());
                let value = match value {
                    Some(value) => ExpectedValue::Value(value),
                    None if output.output.codomain.is_boolean() => ExpectedValue::Any,
                    None => {
                        let function = &output.output.location;
                        return Err(self.unknown(message, function, part.as_deref()));
                    }
                };
                expected.entry(output.function).or_default().push(value);
            }
        }
        Ok(expected)
    }

    /// The values of the inputs in a step.
    pub(super) fn input_values(
        &self,
        received: &[ObservedMessage],
    ) -> Result<BTreeMap<FunctionId, Value>, ProtocolDeviation> {
        let mut values = BTreeMap::new();
        for followed in &self.inputs {
            let input = &followed.input;
            let arrived = received.iter().rfind(|it| it.end == followed.end);
            let message = if input.receive != Receive::Last || followed.is_of_arrival {
                arrived.map(|it| &it.content)
            } else {
                self.newest.get(&followed.end)
            };
            let value = match (input.receive, message) {
                (Receive::Edge, message) => Value::Bool(message.is_some()),
                (Receive::Last | Receive::All, None) => Value::Undef,
                (Receive::Last | Receive::All, Some(content)) => {
                    let part = part(content, input.field.as_deref());
                    let found = self.value(&input.codomain, part.as_deref());
                    match found {
                        Some(value) => value,
                        None => {
                            let message = ObservedMessage {
                                end: followed.end.clone(),
                                content: content.clone(),
                            };
                            return Err(self.unknown(&message, &input.location, part.as_deref()));
                        }
                    }
                }
            };
            values.insert(followed.function, value);
        }
        Ok(values)
    }

    /// The value of a codomain that a part of a message stands for; of a list, whether it has elements.
    fn value(&self, codomain: &Codomain, part: Option<&Datum>) -> Option<Value> {
        let part = part?;
        if codomain.is_boolean() {
            let truth = part
                .as_bool()
                .or_else(|| part.count().map(|count| count > 0));
            return truth.map(Value::Bool);
        }
        self.atom(&codomain.named(part.as_text()?)?.name)
    }

    pub(super) fn atom(&self, name: &str) -> Option<Value> {
        let atoms = &self.specification.program.symbols.atoms;
        let at = atoms.iter().position(|it| **it == *name)?;
        Some(Value::Atom(Atom(u32::try_from(at).ok()?)))
    }

    fn unknown(
        &self,
        message: &ObservedMessage,
        function: &str,
        part: Option<&Datum>,
    ) -> ProtocolDeviation {
        ProtocolDeviation::UnknownValue {
            cycle: self.cycle,
            end: message.end.clone(),
            function: function.to_owned(),
            value: part.map_or_else(|| "no value".to_owned(), shown),
        }
    }

    /// Checks that messages repeat what they promise.
    pub(super) fn check_echoes(&self, sent: &[ObservedMessage]) -> Result<(), ProtocolDeviation> {
        for echo in &self.echoes {
            let (output, input) = (
                MessageEnd::Port(echo.output.clone()),
                MessageEnd::Port(echo.input.clone()),
            );
            let newest = self.newest.get(&input);
            let promised = newest.and_then(|it| it.get(&echo.input_field));
            for message in sent.iter().filter(|it| it.end == output) {
                let repeated = message.content.get(&echo.field);
                if promised.is_none() || repeated != promised {
                    return Err(ProtocolDeviation::NoEcho {
                        cycle: self.cycle,
                        output: format!("{}.{}", echo.output, echo.field),
                        input: format!("{}.{}", echo.input, echo.input_field),
                        sent: repeated.map_or_else(|| "no value".to_owned(), |it| shown(&it)),
                        received: promised
                            .map_or_else(|| "no message yet".to_owned(), |it| shown(&it)),
                    });
                }
            }
        }
        Ok(())
    }
}

/// A field of a message, or the message; the only field of a message counts as the message.
fn part<'a>(content: &'a Datum, field: Option<&str>) -> Option<Cow<'a, Datum>> {
    match (field, content) {
        (Some(field), content) => content.get(field),
        (None, Datum::Record(fields)) => match fields.as_slice() {
            [(_, only)] => Some(Cow::Borrowed(only)),
            _ => None,
        },
        (None, content) => Some(Cow::Borrowed(content)),
    }
}

fn shown(datum: &Datum) -> String {
    format!("{datum:?}")
}
