//! Checks that the first step of a specification can be made before any message has arrived.

use std::collections::BTreeMap;

use asmotion_coordinator::{LocationName, Receive};
use asmotion_diagnostics::{Report, Span};

use super::input::{InputSource, sources};
use crate::codes::c146::UndefinedAtStart;
use crate::finding::Findings;
use crate::model::binding::{Bind, Monitored, Source};
use crate::signature::{Codomain, FunctionInfo, Signature, StartValue};
use crate::tree::{Branch, Node};

/// Reports bound functions that are undef in the first step where it needs their values. Nothing is reported if a value at the
/// start depends on properties, or on the element of a location.
pub(super) fn check(bind: &Bind, signature: &dyn Signature, report: &mut Report) {
    let functions = signature.functions();
    let mut values: BTreeMap<String, StartValue> = BTreeMap::new();
    let mut places: BTreeMap<String, Span> = BTreeMap::new();
    // bindings of monitored functions come first; a call adds no value to them
    for (location, source) in sources(bind) {
        let name = LocationName::from(location.as_str()).function;
        let Some(function) = functions.iter().find(|it| it.name == name) else {
            continue;
        };
        places.entry(name.clone()).or_insert(location.span);
        let value = match source {
            InputSource::Binding(monitored) => start_value(monitored, function),
            InputSource::Outcome(_) if values.contains_key(&name) => continue,
            // a Boolean event is true in the step that receives it
            InputSource::Outcome(_) if function.codomain == Codomain::Boolean => {
                Some(StartValue::Bool(false))
            }
            InputSource::Outcome(_) => Some(StartValue::Undef),
        };
        let Some(value) = value else { return };
        let known = values.entry(name).or_insert_with(|| value.clone());
        if *known != value {
            return;
        }
    }
    for (function, needed) in signature.undefined_at_start(&values) {
        let Some(at) = places.get(&function).copied() else {
            continue;
        };
        let declared = functions.iter().find(|it| it.name == function);
        let example = match declared.map(|it| &it.codomain) {
            Some(Codomain::Boolean) => "false",
            Some(Codomain::Integer | Codomain::Real) => "0",
            Some(_) | None => "\"NOTHING\"",
        };
        let mut bindings = bind.monitored.iter();
        let ages = |it: &Monitored| it.location.span == at && it.stale_ms.is_some();
        let key = if bindings.any(ages) {
            "on_stale"
        } else {
            "none"
        };
        report.found(UndefinedAtStart {
            function,
            at,
            needed,
            key,
            example,
        });
    }
}

/// The value of a bound function before the first message; `None` if it is not known.
fn start_value(monitored: &Monitored, function: &FunctionInfo) -> Option<StartValue> {
    let given = match &monitored.from {
        Source::Timer { .. } => return Some(StartValue::Bool(false)),
        Source::Losses(_) if function.codomain == Codomain::Boolean => {
            return Some(StartValue::Bool(false));
        }
        Source::Losses(_) => return Some(StartValue::Int(0)),
        Source::Value(value) => Some(value),
        Source::Port(_) | Source::Request(_) if monitored.received().value == Receive::Edge => {
            return Some(StartValue::Bool(false));
        }
        Source::Port(_) | Source::Request(_)
            if monitored.stale_ms.is_some() && monitored.received().value == Receive::Last =>
        {
            monitored.on_stale.as_ref()
        }
        Source::Port(_) | Source::Request(_) => monitored.none.as_ref(),
    };
    match given {
        None => Some(StartValue::Undef),
        Some(node) => constant(node),
    }
}

fn constant(node: &Node) -> Option<StartValue> {
    match &node.value {
        Branch::Boolean(value) => Some(StartValue::Bool(*value)),
        Branch::Integer(value) => Some(StartValue::Int(*value)),
        Branch::Text(text) if !text.contains("${") => Some(StartValue::Text(text.clone())),
        Branch::Text(_)
        | Branch::Float(_)
        | Branch::Date(_)
        | Branch::List(_)
        | Branch::Table(_) => None,
    }
}
