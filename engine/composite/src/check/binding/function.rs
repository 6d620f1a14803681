//! Checks bound functions against the types of the ports, services and message fields.

use crate::codes::c090::UnknownBoundFunction;
use crate::codes::c091::WrongFunctionKind;
use crate::codes::c092::WrongLocationArity;
use crate::codes::c093::UnknownLiteral;
use crate::codes::c094::WrongLiteralType;
use crate::codes::c095::WrongFieldType;
use crate::codes::c096::AmbiguousField;
use crate::codes::c127::StaleWithoutPeriod;
use crate::codes::c140::UnknownElement;
use crate::codes::c141::UnlistedDomain;
use crate::codes::c142::UnknownKeyVariable;
use crate::codes::c143::WrongSelectorType;
use crate::codes::c145::InvalidTerm;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use super::{Bound, action, argument};
use crate::at::At;
use crate::check::component::unknown;
use crate::check::endpoints::{EndpointPort, find, nearest_service};
use crate::finding::Findings;
use crate::model::binding::{Effect, Monitored, Out, Source};
use crate::model::{End, MessagePath};
use crate::nearest::nearest;
use crate::pattern::{function_of, out_key};
use crate::signature::{Codomain, FunctionInfo, FunctionKind, Signature};
use crate::table::NamedValue;
use crate::tree::{Branch, Node};
use asmotion_coordinator::{LocationArgument, LocationName, Receive};

pub(super) fn monitored(bound: &Bound<'_>, monitored: &Monitored, report: &mut Report) {
    let message = match &monitored.from {
        Source::Port(port) => {
            input(bound, port, report).and_then(|port| Some(port.kind.as_ref()?.text.clone()))
        }
        Source::Request(end) => request(bound, end, report).map(|schema| schema.to_string()),
        Source::Losses(port) => {
            input(bound, port, report);
            None
        }
        Source::Timer { .. } | Source::Value(_) => None,
    };
    let function = bound.signature.and_then(|signature| {
        let found = location(signature, &monitored.location, &monitored.key, report)?;
        read_by_asm(found, monitored.location.span, report).then_some(found)
    });
    if let Some(message) = &message {
        self::key(
            bound,
            function,
            &monitored.location,
            message,
            &monitored.key,
            report,
        );
    }
    self::matching(bound, monitored, message.as_deref(), report);
    let selected = selected_fields(&monitored.key);
    if let Some(function) = function {
        for value in [&monitored.none, &monitored.on_stale].into_iter().flatten() {
            self::value(function, value, report);
        }
    }
    match &monitored.from {
        Source::Port(_) | Source::Request(_) => {}
        Source::Timer { running, .. } => {
            timer(bound, function, running, report);
            return;
        }
        Source::Losses(port) => {
            lost(function, port.span, report);
            return;
        }
        Source::Value(node) => {
            let is_text = matches!(&node.value, Branch::Text(text) if text.contains("${"));
            if let Some(function) = function.filter(|_| !is_text) {
                value(function, node, report);
            }
            return;
        }
    }
    let path = monitored.field.as_ref().or(monitored.map.as_ref());
    let name = &monitored.location;
    if let Some(first) = monitored.is.first() {
        let truth = function.filter(|it| it.codomain != Codomain::Boolean);
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
                ..function.clone()
            });
            field(
                bound,
                text.as_ref(),
                name,
                message,
                (path, &selected),
                report,
            );
        }
        return;
    }
    let received = monitored.received();
    if received.value == Receive::Edge {
        let path = path.map(|path| path.span);
        edge(function, received.span, path, report);
        return;
    }
    if let Some(message) = &message {
        field(bound, function, name, message, (path, &selected), report);
    }
}

/// Checks the values that fields of a message must have.
fn matching(bound: &Bound<'_>, monitored: &Monitored, message: Option<&str>, report: &mut Report) {
    let schema = match &monitored.from {
        Source::Port(_) => message.and_then(|name| bound.scene.types.schema(name)),
        Source::Request(end) => request(bound, end, &mut Report::new()),
        Source::Timer { .. } | Source::Losses(_) | Source::Value(_) => None,
    };
    argument::matching(bound, &monitored.matching, schema.as_ref(), report);
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

/// Checks that the function is monitored or shared.
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
    monitored
}

/// Checks a function bound to a timer: its condition must be a term of the specification, and both must be Boolean.
fn timer(
    bound: &Bound<'_>,
    function: Option<&FunctionInfo>,
    running: &At<String>,
    report: &mut Report,
) {
    let component = bound.part.component;
    if !bound.scene.cycles_by_time(component) {
        report.found(StaleWithoutPeriod {
            key: "timer",
            component: component.name.value.clone(),
            at: running.span,
            declared: component.name.span,
        });
    }
    let term = bound.signature.map(|signature| signature.term(running));
    let reason = match term {
        Some(Err(reason)) => Some(reason),
        Some(Ok(Some(Codomain::Boolean) | None)) | None => None,
        Some(Ok(Some(found))) => Some(format!("a condition is Boolean, not {}", found.name())),
    };
    if let Some(reason) = reason {
        report.found(InvalidTerm {
            term: running.value.clone(),
            reason,
            at: running.span,
        });
    }
    if let Some(function) = function.filter(|it| it.codomain != Codomain::Boolean) {
        report.found(WrongFieldType {
            function: function.clone(),
            found: "a timer".to_owned(),
            at: running.span,
            typed: None,
        });
    }
}

/// Checks a function bound to losses: its codomain must be Integer or Boolean.
fn lost(function: Option<&FunctionInfo>, at: Span, report: &mut Report) {
    let takes = |function: &&FunctionInfo| {
        matches!(
            function.codomain,
            Codomain::Boolean | Codomain::Integer | Codomain::Other(_)
        )
    };
    if let Some(function) = function.filter(|function| !takes(function)) {
        report.found(WrongFieldType {
            function: function.clone(),
            found: "the number of lost messages".to_owned(),
            at,
            typed: None,
        });
    }
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
        let found = location(signature, &out.location, out_key(out), report)?;
        written_by_asm(found, out.location.span, report).then_some(found)
    });
    match &out.effect {
        Effect::Publish(published) => {
            let path = &published.field;
            let port = output(bound, &published.port, report);
            if let Some(kind) = port.and_then(|port| port.kind.as_ref()) {
                let name = &out.location;
                let selected = selected_fields(&published.key);
                key(bound, function, name, &kind.text, &published.key, report);
                let part = (path.as_ref(), selected.as_slice());
                field(bound, function, name, &kind.text, part, report);
            }
        }
        Effect::Literals(cases) => {
            action::idle_cancels(cases, report);
            for (literal, actions) in cases {
                if let Some(function) = function {
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
    out
}

/// Looks up the function of a location; reports an error if it does not exist or if the arguments are not of its domain.
pub(in crate::check) fn location<'s>(
    signature: &'s dyn Signature,
    written: &At<String>,
    key: &[NamedValue<MessagePath>],
    report: &mut Report,
) -> Option<&'s FunctionInfo> {
    let (name, at) = (LocationName::from(written.as_str()), written.span);
    let Some(function) = function_of(&name, signature) else {
        let all = signature.functions();
        let known = all.iter().map(|it| (it.name.as_str(), Some(it.declared)));
        let mut nearest = nearest(&name.function, known);
        if let (Some(nearest), Some(arguments)) =
            (&mut nearest, written.strip_prefix(&name.function))
        {
            // the correction keeps the arguments of the location
            nearest.name += arguments;
        }
        let name = name.function;
        report.found(UnknownBoundFunction { name, at, nearest });
        return None;
    };
    if function.parameters.len() != name.arguments.len() {
        let given = name.arguments.len();
        report.found(WrongLocationArity {
            function: function.clone(),
            given,
            at,
        });
        return None;
    }
    for field in key {
        let variable = &field.name;
        if !name.variables().any(|known| known == variable.value) {
            report.found(UnknownKeyVariable {
                variable: variable.value.clone(),
                at: variable.span,
            });
        }
    }
    let mut arguments = name.arguments.iter().zip(&function.parameters);
    let is_good = arguments.all(|(argument, parameter)| match argument {
        LocationArgument::Element(element) => {
            let known = match (&parameter.elements, &parameter.domain) {
                (Some(elements), _) => elements.contains(element),
                (None, Codomain::Integer) => element.parse::<i64>().is_ok(),
                (None, _) => false,
            };
            if !known {
                report.found(UnknownElement {
                    element: element.clone(),
                    parameter: parameter.clone(),
                    at,
                    declared: function.declared,
                });
            }
            known
        }
        LocationArgument::Variable(variable) => {
            let selected = key.iter().any(|field| field.name.value == *variable);
            let elements = parameter.elements.as_ref();
            let known = selected && elements.is_some_and(|elements| !elements.is_empty());
            if !known {
                report.found(UnlistedDomain {
                    variable: variable.clone(),
                    parameter: parameter.clone(),
                    at,
                    declared: function.declared,
                });
            }
            known
        }
    });
    is_good.then_some(function)
}

/// Checks that the fields of a key exist and select elements of the domains of their variables.
fn key(
    bound: &Bound<'_>,
    function: Option<&FunctionInfo>,
    written: &At<String>,
    message: &str,
    key: &[NamedValue<MessagePath>],
    report: &mut Report,
) {
    let name = LocationName::from(written.as_str());
    for field in key {
        let schema = match bound.scene.types.field(message, &field.value) {
            Ok(Some(schema)) => schema,
            Ok(None) => continue,
            Err(error) => {
                report.found(error);
                continue;
            }
        };
        let is_variable = |argument: &LocationArgument| match argument {
            LocationArgument::Variable(variable) => *variable == field.name.value,
            LocationArgument::Element(_) => false,
        };
        let position = name.arguments.iter().position(is_variable);
        let parameter = position.and_then(|at| function?.parameters.get(at));
        if let Some(parameter) = parameter
            && !selects(&parameter.domain, &schema.shape)
        {
            report.found(WrongSelectorType {
                variable: field.name.value.clone(),
                parameter: parameter.clone(),
                found: schema.to_string(),
                at: field.value.span,
                declared: function.map(|function| function.declared),
            });
        }
    }
}

/// Returns whether values of the shape name elements of the domain.
fn selects(domain: &Codomain, shape: &Shape) -> bool {
    match domain {
        Codomain::Other(_) => matches!(shape, Shape::Text | Shape::Any),
        Codomain::Abstract(_)
        | Codomain::Character
        | Codomain::Map { .. }
        | Codomain::Boolean
        | Codomain::Integer
        | Codomain::Real
        | Codomain::Text
        | Codomain::Enum { .. }
        | Codomain::List { .. }
        | Codomain::Tuple { .. } => fits(domain, shape),
    }
}

/// Returns the names of the outermost fields that a key uses.
fn selected_fields(key: &[NamedValue<MessagePath>]) -> Vec<&str> {
    let paths = key.iter().filter_map(|field| field.value.steps.first());
    paths.map(|step| step.value.as_str()).collect()
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

/// Checks that the message field exists, is unambiguous and matches the codomain of the function. The fields in
/// `selected` are those of the key.
fn field(
    bound: &Bound<'_>,
    function: Option<&FunctionInfo>,
    name: &At<String>,
    message: &str,
    (path, selected): (Option<&MessagePath>, &[&str]),
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
            match chosen(&whole, selected) {
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
        && !(schema.shape == Shape::Text && is_written_as_text(function))
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

fn chosen(schema: &Schema, selected: &[&str]) -> Chosen {
    let Shape::Record(fields) = &schema.shape else {
        return Chosen::Whole;
    };
    let fields = fields.iter();
    let fields: Vec<_> = fields
        .filter(|field| !selected.contains(&&*field.name))
        .collect();
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

/// Returns the field that is the value if none is named; `None` for the whole message or if the choice is ambiguous. The
/// paths of the key are no candidates.
pub fn chosen_field(schema: &Schema, key: &[(String, String)]) -> Option<String> {
    let paths = key.iter();
    let selected: Vec<&str> = paths
        .filter_map(|(_, path)| path.split('.').next())
        .collect();
    match chosen(schema, &selected) {
        Chosen::Field(name, _) => Some(name),
        Chosen::Whole | Chosen::None(_) => None,
    }
}

/// Returns whether values of the shape are representable in the codomain.
pub(super) fn fits(codomain: &Codomain, shape: &Shape) -> bool {
    match (codomain, shape) {
        (_, Shape::Any) | (Codomain::Other(_), _) => true,
        (_, Shape::Option(present)) => fits(codomain, &present.shape),
        (Codomain::Boolean, _) => *shape == Shape::Bool,
        (Codomain::Integer, _) => shape.is_integer(),
        (Codomain::Real, _) => shape.is_number(),
        (
            Codomain::Text | Codomain::Character | Codomain::Abstract(_) | Codomain::Enum { .. },
            _,
        ) => *shape == Shape::Text,
        (Codomain::Map { key, item, .. }, Shape::Record(fields)) => fields
            .iter()
            .all(|field| is_key(key, &field.name) && fits(item, &field.schema.shape)),
        (Codomain::List { item, .. }, Shape::List(element) | Shape::Array(element, _)) => {
            fits(item, &element.shape)
        }
        (Codomain::Tuple { items, .. }, Shape::Record(fields)) if fields.len() == items.len() => {
            let mut fields = items.iter().zip(fields);
            fields.all(|(item, field)| fits(item, &field.schema.shape))
        }
        (Codomain::Tuple { items, .. }, Shape::List(element)) => {
            items.iter().all(|item| fits(item, &element.shape))
        }
        (Codomain::Tuple { items, .. }, Shape::Array(element, count)) => {
            *count == items.len() && items.iter().all(|item| fits(item, &element.shape))
        }
        // a record with one field stands for that field
        (Codomain::List { .. } | Codomain::Tuple { .. }, Shape::Record(fields)) => {
            matches!(fields.as_slice(), [only] if fits(codomain, &only.schema.shape))
        }
        (Codomain::List { .. } | Codomain::Tuple { .. } | Codomain::Map { .. }, _) => false,
    }
}

/// Returns whether the values of an out function are written as texts: maps whose keys are no names of fields.
fn is_written_as_text(function: &FunctionInfo) -> bool {
    let is_out = matches!(function.kind, FunctionKind::Out | FunctionKind::Shared);
    is_out && matches!(&function.codomain, Codomain::Map { key, .. } if !fits(key, &Shape::Text))
}

/// Returns whether the name of a field is a key of a map with keys of this codomain.
fn is_key(codomain: &Codomain, name: &str) -> bool {
    match codomain {
        Codomain::Enum { literals, .. } => literals.iter().any(|literal| literal == name),
        Codomain::Character => name.chars().count() == 1,
        Codomain::Text | Codomain::Abstract(_) | Codomain::Other(_) => true,
        Codomain::Boolean
        | Codomain::Integer
        | Codomain::Real
        | Codomain::List { .. }
        | Codomain::Tuple { .. }
        | Codomain::Map { .. } => false,
    }
}

/// Checks a constant of the composite assigned to a function.
fn value(function: &FunctionInfo, node: &Node, report: &mut Report) {
    if let (Codomain::Enum { .. }, Branch::Text(text)) = (&function.codomain, &node.value) {
        literal(function, &At::new(text.clone(), node.span), report);
        return;
    }
    if let Some(ConstantMisfit {
        codomain,
        found,
        at,
    }) = misfit(&function.codomain, node)
    {
        report.found(WrongLiteralType {
            function: FunctionInfo {
                codomain: codomain.clone(),
                ..function.clone()
            },
            found,
            at,
        });
    }
}

/// The innermost part of a constant that does not fit.
struct ConstantMisfit<'v> {
    /// Codomain to which it must belong.
    codomain: &'v Codomain,
    found: String,
    at: Span,
}

fn misfit<'v>(codomain: &'v Codomain, node: &'v Node) -> Option<ConstantMisfit<'v>> {
    let fits = match (codomain, &node.value) {
        (Codomain::Map { key, item, .. }, Branch::Table(table)) => {
            return table.entries.iter().find_map(|entry| {
                let name = &entry.key.value;
                let is_known = name.contains("${") || is_key(key, name);
                let wrong_key = (!is_known).then(|| ConstantMisfit {
                    codomain: key,
                    found: format!("the key `{name}`"),
                    at: entry.key.span,
                });
                wrong_key.or_else(|| misfit(item, &entry.node))
            });
        }
        (Codomain::List { item, .. }, Branch::List(nodes)) => {
            return nodes.iter().find_map(|node| misfit(item, node));
        }
        (Codomain::Tuple { items, .. }, Branch::List(nodes)) if items.len() == nodes.len() => {
            let mut parts = items.iter().zip(nodes);
            return parts.find_map(|(codomain, node)| misfit(codomain, node));
        }
        (Codomain::Enum { literals, .. }, Branch::Text(text)) => {
            text.contains("${") || literals.contains(text)
        }
        (_, Branch::Text(text)) if text.contains("${") => true,
        (Codomain::Boolean, Branch::Boolean(_))
        | (Codomain::Integer, Branch::Integer(_))
        | (Codomain::Real, Branch::Integer(_) | Branch::Float(_))
        | (Codomain::Text | Codomain::Character | Codomain::Abstract(_), Branch::Text(_))
        | (Codomain::Tuple { .. }, Branch::Table(_))
        | (Codomain::Other(_), _) => true,
        (
            Codomain::Boolean
            | Codomain::Integer
            | Codomain::Real
            | Codomain::Text
            | Codomain::List { .. }
            | Codomain::Tuple { .. }
            | Codomain::Map { .. }
            | Codomain::Character
            | Codomain::Abstract(_)
            | Codomain::Enum { .. },
            _,
        ) => false,
    };
    (!fits).then(|| ConstantMisfit {
        codomain,
        found: described(&node.value),
        at: node.span,
    })
}

/// Describes a value that does not fit, a list with its length.
fn described(value: &Branch) -> String {
    match value {
        Branch::List(nodes) => format!("{} of length {}", value.describe(), nodes.len()),
        Branch::Text(_)
        | Branch::Integer(_)
        | Branch::Float(_)
        | Branch::Boolean(_)
        | Branch::Date(_)
        | Branch::Table(_) => value.describe().to_owned(),
    }
}

/// Checks that a literal belongs to the codomain of the function.
pub(in crate::check) fn literal(
    function: &FunctionInfo,
    literal: &At<String>,
    report: &mut Report,
) {
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
        Codomain::Integer
        | Codomain::Real
        | Codomain::Text
        | Codomain::Character
        | Codomain::List { .. }
        | Codomain::Tuple { .. }
        | Codomain::Map { .. } => {
            let (found, at) = (format!("the literal `{}`", literal.value), literal.span);
            report.found(WrongLiteralType {
                function: function.clone(),
                found,
                at,
            });
            return;
        }
        Codomain::Abstract(_) | Codomain::Other(_) => return,
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
