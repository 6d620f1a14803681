//! Checks bound functions against the types of the ports, services and message fields.

use crate::codes::c090::UnknownBoundFunction;
use crate::codes::c091::WrongFunctionKind;
use crate::codes::c092::BoundFunctionHasArguments;
use crate::codes::c093::UnknownLiteral;
use crate::codes::c094::WrongLiteralType;
use crate::codes::c095::WrongFieldType;
use crate::codes::c096::AmbiguousField;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use super::{Bound, action};
use crate::at::At;
use crate::check::component::unknown;
use crate::check::endpoints::{EndpointPort, find, nearest_service};
use crate::finding::Findings;
use crate::model::binding::{Effect, Monitored, Out, Source};
use crate::model::{End, MessagePath};
use crate::nearest::nearest;
use crate::signature::{Codomain, FunctionInfo, FunctionKind};
use crate::tree::{Branch, Node};
use crate::types::{is_float, is_integer};
use asmotion_coordinator::Receive;

pub(super) fn monitored(bound: &Bound<'_>, monitored: &Monitored, report: &mut Report) {
    let message = match &monitored.from {
        Source::Port(port) => {
            input(bound, port, report).and_then(|port| Some(port.kind.as_ref()?.text.clone()))
        }
        Source::Request(end) => request(bound, end, report).map(|schema| schema.to_string()),
    };
    let function = bound.signature.and_then(|signature| {
        let found = function(signature, &monitored.function, report)?;
        read_by_asm(&found, monitored.function.span, report).then_some(found)
    });
    if let Some(function) = &function {
        for value in [&monitored.none, &monitored.on_stale].into_iter().flatten() {
            self::value(function, value, report);
        }
    }
    let path = monitored.field.as_ref().or(monitored.map.as_ref());
    let name = &monitored.function;
    if let Some(first) = monitored.is.first() {
        let truth = function
            .as_ref()
            .filter(|it| it.codomain != Codomain::Boolean);
        if let Some(function) = truth {
            report.found(WrongFieldType {
                function: function.clone(),
                found: "what is true for some texts".to_owned(),
                at: first.span,
                typed: None,
            });
        }
        if let Some(message) = &message {
            // the field is compared with a string, regardless of the codomain of the function
            let text = function.map(|function| FunctionInfo {
                codomain: Codomain::Text,
                ..function
            });
            field(bound, text.as_ref(), name, message, path, report);
        }
        return;
    }
    let received = monitored.received();
    if received.value == Receive::Edge {
        let path = path.map(|path| path.span);
        edge(function.as_ref(), received.span, path, report);
        return;
    }
    if let Some(message) = &message {
        field(bound, function.as_ref(), name, message, path, report);
    }
}

/// Returns the request type of a provided operation; `None` if the catalogue does not know it.
pub(super) fn request(bound: &Bound<'_>, end: &End, report: &mut Report) -> Option<Schema> {
    let services = &bound.part.face.services;
    let Some(service) = find(services, &end.component) else {
        let nearest = nearest_service(services, &end.component);
        report.found(unknown("service", &end.component, nearest));
        return None;
    };
    let operations = bound.scene.catalogue.operations(&service.interface.text)?;
    let found = operations.iter().find(|known| known.name == end.name.value);
    if found.is_none() {
        let known = operations.iter().map(|known| (known.name.as_str(), None));
        report.found(unknown("operation", &end.name, nearest(&end.name, known)));
    }
    found.map(|operation| operation.request.clone())
}

/// Checks that the function is monitored or shared and has no arguments.
fn read_by_asm(function: &FunctionInfo, at: Span, report: &mut Report) -> bool {
    let monitored = matches!(
        function.kind,
        FunctionKind::Monitored | FunctionKind::Shared
    );
    if !monitored {
        report.found(WrongFunctionKind {
            function: function.clone(),
            reason: "the environment cannot write it",
            help: "declare it `monitored`, or bind another function",
            at,
        });
    }
    monitored && nullary(function, at, report)
}

fn nullary(function: &FunctionInfo, at: Span, report: &mut Report) -> bool {
    if function.domain.is_empty() {
        return true;
    }
    report.found(BoundFunctionHasArguments {
        function: function.clone(),
        at,
    });
    false
}

/// Checks a function bound to an edge: its codomain must be Boolean, and no message field may be given.
fn edge(function: Option<&FunctionInfo>, at: Span, path: Option<Span>, report: &mut Report) {
    let Some(function) = function else {
        return;
    };
    let truth = matches!(function.codomain, Codomain::Boolean | Codomain::Other(_));
    if !truth || path.is_some() {
        let found = "an edge".to_owned();
        let at = path.filter(|_| truth).unwrap_or(at);
        let function = function.clone();
        report.found(WrongFieldType {
            function,
            found,
            at,
            typed: None,
        });
    }
}

pub(super) fn out(bound: &Bound<'_>, out: &Out, report: &mut Report) {
    let function = bound.signature.and_then(|signature| {
        let found = function(signature, &out.function, report)?;
        written_by_asm(&found, out.function.span, report).then_some(found)
    });
    match &out.effect {
        Effect::Publish(published) => {
            let path = &published.field;
            let port = output(bound, &published.port, report);
            if let Some(kind) = port.and_then(|port| port.kind.as_ref()) {
                let function = function.as_ref();
                field(
                    bound,
                    function,
                    &out.function,
                    &kind.text,
                    path.as_ref(),
                    report,
                );
            }
        }
        Effect::Literals(cases) => {
            for (literal, actions) in cases {
                if let Some(function) = &function {
                    self::literal(function, literal, report);
                }
                for action in actions {
                    action::check(bound, action, report);
                }
            }
        }
    }
}

fn written_by_asm(function: &FunctionInfo, at: Span, report: &mut Report) -> bool {
    let out = matches!(function.kind, FunctionKind::Out | FunctionKind::Shared);
    if !out {
        report.found(WrongFunctionKind {
            function: function.clone(),
            reason: "the environment cannot read it",
            help: "declare it `out`, or bind another function",
            at,
        });
    }
    out && nullary(function, at, report)
}

/// Looks up a function; reports an error if it does not exist.
pub(super) fn function(
    signature: &dyn crate::signature::Signature,
    name: &At<String>,
    report: &mut Report,
) -> Option<FunctionInfo> {
    let found = signature.function(name);
    if found.is_none() {
        let all = signature.functions();
        let known = all.iter().map(|it| (it.name.as_str(), Some(it.declared)));
        let nearest = nearest(name, known);
        let (name, at) = (name.value.clone(), name.span);
        report.found(UnknownBoundFunction { name, at, nearest });
    }
    found
}

/// Looks up an input port.
pub(super) fn input<'b>(
    bound: &Bound<'b>,
    name: &At<String>,
    report: &mut Report,
) -> Option<&'b EndpointPort> {
    port(&bound.part.face.inputs, "input", name, report)
}

/// Looks up an output port.
pub(super) fn output<'b>(
    bound: &Bound<'b>,
    name: &At<String>,
    report: &mut Report,
) -> Option<&'b EndpointPort> {
    port(&bound.part.face.outputs, "output", name, report)
}

fn port<'b>(
    ports: &'b [EndpointPort],
    what: &'static str,
    name: &At<String>,
    report: &mut Report,
) -> Option<&'b EndpointPort> {
    let found = ports.iter().find(|port| port.name.text == name.value);
    if found.is_none() {
        let known = ports
            .iter()
            .map(|port| (port.name.text.as_str(), port.name.at));
        report.found(unknown(what, name, nearest(name, known)));
    }
    found
}

/// Checks that the message field exists, is unambiguous and matches the codomain of the function.
fn field(
    bound: &Bound<'_>,
    function: Option<&FunctionInfo>,
    name: &At<String>,
    message: &str,
    path: Option<&MessagePath>,
    report: &mut Report,
) {
    let types = bound.scene.types;
    let schema = match path {
        Some(path) => match types.field(message, path) {
            Ok(schema) => schema,
            Err(error) => {
                report.found(error);
                return;
            }
        },
        None => {
            let Some(whole) = types.schema(message) else {
                return;
            };
            match chosen(&whole) {
                Chosen::Whole => Some(whole),
                Chosen::Field(_, schema) => Some(schema),
                Chosen::None(fields) => {
                    report.found(AmbiguousField {
                        function: name.value.clone(),
                        message: message.to_owned(),
                        fields,
                        at: name.span,
                    });
                    return;
                }
            }
        }
    };
    if let (Some(function), Some(schema)) = (function, schema)
        && !fits(&function.codomain, &schema.shape)
    {
        report.found(WrongFieldType {
            function: function.clone(),
            found: format!("`{schema}`"),
            at: path.map_or(name.span, |path| path.span),
            typed: types.declared(message),
        });
    }
}

/// The part of a message selected if no field is named.
enum Chosen {
    /// The whole message, which is not a record.
    Whole,
    /// The only field, or the field named `data` (as in `std_msgs`) or `code` (as in `nav/Event`).
    Field(String, Schema),
    /// No unambiguous field; contains the names of the candidates.
    None(Vec<String>),
}

fn chosen(schema: &Schema) -> Chosen {
    let Shape::Record(fields) = &schema.shape else {
        return Chosen::Whole;
    };
    let named = |name: &str| fields.iter().find(|field| field.name == name);
    let only = match fields.as_slice() {
        [only] => Some(only),
        _ => None,
    };
    match only.or(named("data")).or(named("code")) {
        Some(field) => Chosen::Field(field.name.to_string(), field.schema.clone()),
        None => Chosen::None(fields.iter().map(|field| field.name.to_string()).collect()),
    }
}

/// Returns the field selected if none is named; `None` for the whole message or if the choice is ambiguous.
pub fn chosen_field(schema: &Schema) -> Option<String> {
    match chosen(schema) {
        Chosen::Field(name, _) => Some(name),
        Chosen::Whole | Chosen::None(_) => None,
    }
}

/// Returns whether values of the shape are representable in the codomain.
fn fits(codomain: &Codomain, shape: &Shape) -> bool {
    let whole = is_integer(shape);
    match codomain {
        _ if *shape == Shape::Any => true,
        Codomain::Boolean => *shape == Shape::Bool,
        Codomain::Integer => whole,
        Codomain::Real => whole || is_float(shape),
        Codomain::Text | Codomain::Enum { .. } => *shape == Shape::Text,
        Codomain::Other(_) => true,
    }
}

/// Checks a constant of the composite assigned to a function.
fn value(function: &FunctionInfo, node: &Node, report: &mut Report) {
    let fits = match (&function.codomain, &node.value) {
        (Codomain::Enum { .. }, Branch::Text(text)) => {
            literal(function, &At::new(text.clone(), node.span), report);
            true
        }
        (Codomain::Boolean, Branch::Boolean(_))
        | (Codomain::Integer, Branch::Integer(_))
        | (Codomain::Real, Branch::Integer(_) | Branch::Float(_))
        | (Codomain::Text, Branch::Text(_))
        | (Codomain::Other(_), _) => true,
        (
            Codomain::Boolean
            | Codomain::Integer
            | Codomain::Real
            | Codomain::Text
            | Codomain::Enum { .. },
            _,
        ) => false,
    };
    if !fits {
        let found = node.value.describe().to_owned();
        report.found(WrongLiteralType {
            function: function.clone(),
            found,
            at: node.span,
        });
    }
}

/// Checks that a literal belongs to the codomain of the function.
pub(super) fn literal(function: &FunctionInfo, literal: &At<String>, report: &mut Report) {
    let (domain, literals, declared) = match &function.codomain {
        Codomain::Enum {
            name,
            literals,
            declared,
        } => (name.clone(), literals.clone(), *declared),
        Codomain::Boolean => (
            "Boolean".to_owned(),
            vec!["true".to_owned(), "false".to_owned()],
            None,
        ),
        Codomain::Integer if literal.parse::<i64>().is_ok() => return,
        Codomain::Integer | Codomain::Real | Codomain::Text => {
            let (found, at) = (format!("the literal `{}`", literal.value), literal.span);
            report.found(WrongLiteralType {
                function: function.clone(),
                found,
                at,
            });
            return;
        }
        Codomain::Other(_) => return,
    };
    if !literals.contains(&literal.value) {
        report.found(UnknownLiteral {
            literal: literal.value.clone(),
            domain,
            literals,
            at: literal.span,
            declared: declared.unwrap_or(function.declared),
        });
    }
}
