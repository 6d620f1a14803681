//! The bindings of a composite as inputs and outputs of an actor.

use crate::actor::{
    ActorInput, ActorOutput, Codomain, ElementName, InputOrigin, OutputEffect, ReadFiles,
};
use crate::error::ModelError;
use crate::rename::renamed;
use asmotion_coordinator::{
    Binding, Constant, Effect, LocationArgument, LocationName, Monitored, Out, Receive, Source,
};
use asmotion_datum::Datum;
use std::collections::{BTreeMap, BTreeSet};

/// The term without a value.
const UNDEF: &str = "undef";

/// A location with the elements of the variables in its name.
struct NamedLocation {
    location: String,
    word: String,
    function: String,
    codomain: Codomain,
    elements: BTreeMap<String, String>,
}

/// Turns bindings into the inputs and outputs of an actor.
pub(crate) struct BindingReader<'a> {
    pub component: &'a str,
    pub files: &'a ReadFiles,
}

impl BindingReader<'_> {
    /// Returns the inputs and outputs.
    ///
    /// # Errors
    /// A binding names a function that the specification does not declare, or an input has outcomes of calls beside values of
    /// another kind.
    pub fn read(
        &self,
        binding: &Binding,
    ) -> Result<(Vec<ActorInput>, Vec<ActorOutput>), ModelError> {
        let mut inputs = Vec::new();
        for monitored in &binding.monitored {
            inputs.extend(self.inputs(monitored)?);
        }
        let mut outputs = Vec::new();
        for out in &binding.out {
            outputs.extend(self.outputs(out)?);
        }
        let events: BTreeSet<&String> =
            binding.calls().filter_map(|it| it.event.as_ref()).collect();
        for event in events {
            let name = LocationName::from(event.as_str());
            for named in self.locations(&name)? {
                let bound = inputs.iter_mut().find(|it| it.location == named.location);
                match bound {
                    Some(input) => self.add_outcomes(input)?,
                    None => inputs.push(outcomes_only(named)),
                }
            }
        }
        Ok((inputs, outputs))
    }

    /// Makes an input that has a binding take outcomes of calls as well.
    fn add_outcomes(&self, input: &mut ActorInput) -> Result<(), ModelError> {
        match (&input.origin, input.receive) {
            // the value between two outcomes
            (InputOrigin::Value(value), _) => {
                input.none = (value != UNDEF).then(|| value.clone());
                input.origin = InputOrigin::Calls;
                input.receive = Receive::All;
                Ok(())
            }
            (InputOrigin::Timer(_), _)
            | (InputOrigin::Port(_) | InputOrigin::Request { .. }, Receive::Last) => {
                Err(ModelError::OutcomesBesideValues {
                    component: self.component.to_owned(),
                    location: input.location.clone(),
                })
            }
            // outcomes are queued together with messages, or have no effect
            (InputOrigin::Calls | InputOrigin::Losses, _)
            | (InputOrigin::Port(_) | InputOrigin::Request { .. }, Receive::All | Receive::Edge) => {
                Ok(())
            }
        }
    }

    fn inputs(&self, monitored: &Monitored) -> Result<Vec<ActorInput>, ModelError> {
        let locations = self.locations(&monitored.location)?;
        let inputs = locations.into_iter().map(|named| {
            let constant = |it: &Constant| term_of(&it.datum, &named.codomain);
            let key = monitored.key.iter().filter_map(|(variable, field)| {
                let element = named.elements.get(variable)?;
                Some((field.clone(), element.clone()))
            });
            let key = key.collect();
            let none = monitored.none.as_ref().and_then(constant);
            let stale = monitored.stale_ms.map(|_| {
                let value = monitored.on_stale.as_ref().and_then(constant);
                value.unwrap_or_else(|| UNDEF.to_owned())
            });
            let origin = match &monitored.from {
                Source::Port(port) => InputOrigin::Port(port.clone()),
                Source::Request(bound) => InputOrigin::Request {
                    service: bound.service.clone(),
                    operation: bound.operation.clone(),
                },
                Source::Timer { running, .. } => {
                    InputOrigin::Timer(renamed(running, &self.files.names))
                }
                Source::Losses(_) => InputOrigin::Losses,
                Source::Value(value) => {
                    InputOrigin::Value(constant(value).unwrap_or_else(|| UNDEF.to_owned()))
                }
            };
            ActorInput {
                location: named.location,
                word: named.word,
                function: named.function,
                codomain: named.codomain,
                origin,
                receive: monitored.receive,
                field: monitored.field.clone().or_else(|| monitored.map.clone()),
                is: monitored.is.clone(),
                none,
                stale,
                matching: monitored.matching.clone(),
                key,
            }
        });
        Ok(inputs.collect())
    }

    fn outputs(&self, out: &Out) -> Result<Vec<ActorOutput>, ModelError> {
        let locations = self.locations(&out.location)?;
        let outputs = locations.into_iter().map(|named| {
            let effect = match &out.effect {
                Effect::Publish(published) => {
                    let key = published.key.iter().filter_map(|(variable, field)| {
                        let element = named.elements.get(variable)?;
                        Some((field.clone(), element.clone()))
                    });
                    OutputEffect::Publish {
                        port: published.port.clone(),
                        field: published.field.clone(),
                        key: key.collect(),
                        when: published.when,
                    }
                }
                Effect::Literals(cases) => {
                    let cases = cases.iter().map(|case| {
                        let literal = literal(&case.literal, &named.codomain);
                        (literal, case.actions.clone())
                    });
                    OutputEffect::Cases(cases.collect())
                }
            };
            ActorOutput {
                location: named.location,
                word: named.word,
                function: named.function,
                codomain: named.codomain,
                effect,
            }
        });
        Ok(outputs.collect())
    }

    /// The locations that a name stands for: several if it has variables.
    fn locations(&self, name: &LocationName) -> Result<Vec<NamedLocation>, ModelError> {
        let missing = || ModelError::NoFunction {
            component: self.component.to_owned(),
            location: name.to_string(),
        };
        let names = &self.files.names;
        let function = names.get(&name.function).unwrap_or(&name.function);
        let facts = self.files.functions.get(function).ok_or_else(missing)?;
        if facts.elements.len() != name.arguments.len() {
            return Err(missing());
        }
        let mut found = vec![(Vec::<String>::new(), name.function.clone(), BTreeMap::new())];
        for (argument, elements) in name.arguments.iter().zip(&facts.elements) {
            let choices = choices(argument, elements.as_deref(), names).ok_or_else(missing)?;
            let mut extended = Vec::new();
            for (arguments, word, variables) in &found {
                for (variable, element) in &choices {
                    let (mut arguments, mut variables) = (arguments.clone(), variables.clone());
                    arguments.push(element.name.clone());
                    if let Some(variable) = variable {
                        variables.insert(variable.clone(), element.declared.clone());
                    }
                    extended.push((arguments, format!("{word}_{}", element.declared), variables));
                }
            }
            found = extended;
        }
        Ok(found
            .into_iter()
            .map(|(arguments, word, elements)| NamedLocation {
                location: applied(function, &arguments),
                word: word.replace('-', "minus"),
                function: function.clone(),
                codomain: facts.codomain.clone(),
                elements,
            })
            .collect())
    }
}

/// The elements that an argument stands for, each with the variable if it is one.
fn choices(
    argument: &LocationArgument,
    elements: Option<&[ElementName]>,
    names: &BTreeMap<String, String>,
) -> Option<Vec<(Option<String>, ElementName)>> {
    match argument {
        LocationArgument::Element(name) => {
            let listed = elements.unwrap_or_default().iter();
            let listed = listed.clone().find(|it| it.declared == *name).cloned();
            let other = || ElementName {
                declared: name.clone(),
                name: renamed(name, names),
            };
            Some(vec![(None, listed.unwrap_or_else(other))])
        }
        LocationArgument::Variable(variable) => {
            let elements = elements?.iter();
            let elements = elements.map(|it| (Some(variable.clone()), it.clone()));
            Some(elements.collect())
        }
    }
}

fn applied(function: &str, arguments: &[String]) -> String {
    if arguments.is_empty() {
        function.to_owned()
    } else {
        format!("{function}({})", arguments.join(", "))
    }
}

/// An input that only the outcomes of calls set.
fn outcomes_only(named: NamedLocation) -> ActorInput {
    let none = named.codomain.is_boolean().then(|| "false".to_owned());
    ActorInput {
        location: named.location,
        word: named.word,
        function: named.function,
        codomain: named.codomain,
        origin: InputOrigin::Calls,
        receive: Receive::All,
        field: None,
        is: Vec::new(),
        none,
        stale: None,
        matching: Vec::new(),
        key: Vec::new(),
    }
}

/// A literal of a codomain.
pub(crate) fn literal(text: &str, codomain: &Codomain) -> ElementName {
    let named = codomain.named(text).cloned();
    named.unwrap_or_else(|| ElementName {
        declared: text.to_owned(),
        name: text.to_owned(),
    })
}

/// The term for a value of a codomain; `None` if it is not one.
pub(crate) fn term_of(datum: &Datum, codomain: &Codomain) -> Option<String> {
    if let (Datum::Text(text), Some(_)) = (datum, &codomain.elements) {
        return codomain.named(text).map(|it| it.name.clone());
    }
    term_of_type(datum, &codomain.text)
}

fn term_of_type(datum: &Datum, kind: &str) -> Option<String> {
    let inside = |name: &str| kind.strip_prefix(name)?.strip_suffix(')');
    match datum {
        Datum::Bool(truth) => Some(truth.to_string()),
        Datum::Int(number) if kind == "Real" => Some(format!("{number}.0")),
        Datum::Int(number) => Some(number.to_string()),
        Datum::Float(number) => number.is_finite().then(|| format!("{number:?}")),
        Datum::Text(text) => (!text.contains(['"', '\n', '\\'])).then(|| format!("\"{text}\"")),
        Datum::List(items) => {
            if let Some(item) = inside("Seq(") {
                let terms = items.iter().map(|it| term_of_type(it, item));
                return Some(format!(
                    "[{}]",
                    terms.collect::<Option<Vec<_>>>()?.join(", ")
                ));
            }
            let parts = split(inside("Prod(")?);
            let terms = items
                .iter()
                .zip(parts)
                .map(|(it, part)| term_of_type(it, part));
            Some(format!(
                "({})",
                terms.collect::<Option<Vec<_>>>()?.join(", ")
            ))
        }
        Datum::Numbers(_) => {
            let count = datum.count()?;
            let items = (0..count).map(|index| Some(datum.element(index)?.into_owned()));
            term_of_type(&Datum::List(items.collect::<Option<_>>()?), kind)
        }
        Datum::Null | Datum::Bytes(_) | Datum::Record(_) => None,
    }
}

/// Splits at commas outside of parentheses.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0_usize, 0, Vec::new());
    for (at, sign) in text.char_indices() {
        match sign {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.extend(text.get(start..at).map(str::trim));
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.extend(text.get(start..).map(str::trim));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_a_composite_become_terms() {
        let codomain = |text: &str| Codomain {
            text: text.to_owned(),
            elements: None,
        };
        let pair = |x: f64, y: i64| Datum::List(vec![Datum::Float(x), Datum::Int(y)]);
        let tour = Datum::List(vec![pair(3.0, 7), pair(12.5, -4)]);
        assert_eq!(
            term_of(&tour, &codomain("Seq(Prod(Real, Real))")).as_deref(),
            Some("[(3.0, 7.0), (12.5, -4.0)]")
        );
        assert_eq!(term_of(&Datum::Null, &codomain("Integer")), None);
    }
}
