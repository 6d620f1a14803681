//! Compares protocols with the ports, services and references of their components.

use crate::codes::c160::UnknownProtocolEnd;
use crate::codes::c161::UnfitProtocolFunction;
use asmotion_datum::{Schema, Shape};
use asmotion_diagnostics::{Report, Span};

use super::endpoints::{EndpointPort, EndpointService, PortDirection};
use super::scene::{CheckedComponent, CheckedComposite};
use crate::finding::Findings;
use crate::nearest::nearest_name;
use crate::signature::{Annotations, Codomain, FunctionInfo, FunctionKind};
use crate::wording::has;

/// Checks the protocols of the components that name one.
pub(super) fn check(scene: &CheckedComposite<'_>, report: &mut Report) {
    for part in &scene.parts {
        let Some(file) = &part.component.special.protocol else {
            continue;
        };
        let Some(signature) = scene.family.specification(scene.member, &file.value) else {
            continue;
        };
        if part.face.blank {
            continue;
        }
        let protocol = CheckedProtocol {
            scene,
            part,
            key: file.span,
        };
        let annotations = signature.annotations();
        for function in signature.functions() {
            protocol.function(function, &annotations, report);
        }
        for (text, at) in &annotations.echoes {
            protocol.echo(text, *at, report);
        }
    }
}

struct CheckedProtocol<'c, 's> {
    scene: &'c CheckedComposite<'s>,
    part: &'c CheckedComponent<'s>,
    /// The key `protocol`.
    key: Span,
}

/// The message or operation for which a function of a protocol stands.
enum ProtocolEnd {
    /// A message, or a field of it; the type is `None` if it is not known.
    Message {
        schema: Option<Schema>,
        field: Option<String>,
    },
    /// The answer to a request.
    Answer,
    /// A request.
    Request,
}

impl CheckedProtocol<'_, '_> {
    fn function(&self, function: &FunctionInfo, annotations: &Annotations, report: &mut Report) {
        let is_output = match function.kind {
            FunctionKind::Monitored => false,
            FunctionKind::Out => true,
            FunctionKind::Shared
            | FunctionKind::Controlled
            | FunctionKind::Static
            | FunctionKind::Derived
            | FunctionKind::Local => return,
        };
        let annotated = annotations
            .ports
            .iter()
            .find(|it| it.function == function.name);
        let (end, at) = annotated.map_or((function.name.as_str(), function.declared), |it| {
            (it.end.as_str(), it.at)
        });
        let unfit = |problem: String, help: &'static str| UnfitProtocolFunction {
            component: self.part.component.name.value.clone(),
            function: function.name.clone(),
            problem,
            at: function.declared,
            key: self.key,
            help,
        };
        if !function.parameters.is_empty() {
            return report.found(unfit(
                "has arguments".to_owned(),
                "declare a function without arguments for each port or field",
            ));
        }
        let found = match self.end(end, is_output, at) {
            Ok(found) => found,
            Err(missing) => return report.found(*missing),
        };
        let codomain = &function.codomain;
        match found {
            ProtocolEnd::Answer if !matches!(codomain, Codomain::Enum { .. }) => {
                report.found(unfit(
                    format!("is an answer with values of `{}`", codomain.name()),
                    "declare an enumeration of `OK` and the codes of the operation's faults",
                ))
            }
            ProtocolEnd::Request if !matches!(codomain, Codomain::Boolean) => report.found(unfit(
                format!("is a request with values of `{}`", codomain.name()),
                "declare it `Boolean`: it is true when a request has arrived",
            )),
            ProtocolEnd::Answer | ProtocolEnd::Request => {}
            ProtocolEnd::Message { schema, field } => {
                match self.within(schema, field.as_deref(), at) {
                    Ok(Some(schema)) if !carries(&schema, codomain, field.is_some()) => {
                        report.found(unfit(
                            format!("has values of `{}`, and {end} has `{schema}`", codomain.name()),
                            "use `Boolean` for an arrival, a truth value or whether a list has elements, and an enumeration for \
                             a text",
                        ));
                    }
                    Ok(_) => {}
                    Err(missing) => report.found(*missing),
                }
            }
        }
    }

    /// Finds what an end stands for: a port, or an operation of a service or through a reference.
    fn end(
        &self,
        end: &str,
        is_output: bool,
        at: Span,
    ) -> Result<ProtocolEnd, Box<UnknownProtocolEnd>> {
        let face = &self.part.face;
        let (ports, what) = if is_output {
            (&face.outputs, PortDirection::Out.word())
        } else {
            (&face.inputs, PortDirection::In.word())
        };
        if let Some((port, field)) = longest(ports, end) {
            return Ok(ProtocolEnd::Message {
                schema: self.schema(port),
                field: field.map(str::to_owned),
            });
        }
        if let Some((service, operation)) = named(&face.services, end) {
            self.operation(service, operation, at)?;
            return Ok(if is_output {
                ProtocolEnd::Answer
            } else {
                ProtocolEnd::Request
            });
        }
        if is_output && let Some((reference, rest)) = named(&face.references, end) {
            let (operation, field) = match rest.split_once('.') {
                Some((operation, field)) => (operation, Some(field.to_owned())),
                None => (rest, None),
            };
            let schema = self.operation(reference, operation, at)?;
            return Ok(ProtocolEnd::Message { schema, field });
        }
        let mut known: Vec<String> = ports.iter().map(|it| it.name.text.clone()).collect();
        for service in &face.services {
            known.extend(self.operations(service));
        }
        if is_output {
            for reference in &face.references {
                known.extend(self.operations(reference));
            }
        }
        Err(Box::new(self.unknown(what, end, known, at)))
    }

    /// Returns the type of an operation's request; `None` if it is not known.
    fn operation(
        &self,
        service: &EndpointService,
        name: &str,
        at: Span,
    ) -> Result<Option<Schema>, Box<UnknownProtocolEnd>> {
        let Some(operations) = self.scene.catalogue.operations(&service.interface.text) else {
            return Ok(None);
        };
        match operations.iter().find(|it| it.name == name) {
            Some(operation) => Ok(Some(operation.request.clone())),
            None => {
                let end = format!("{}.{name}", service.name.text);
                Err(Box::new(self.unknown(
                    "operation",
                    &end,
                    self.operations(service),
                    at,
                )))
            }
        }
    }

    fn operations(&self, service: &EndpointService) -> Vec<String> {
        let operations = self.scene.catalogue.operations(&service.interface.text);
        let operations = operations.unwrap_or_default();
        let names = operations.iter().map(|it| &it.name);
        names
            .map(|name| format!("{}.{name}", service.name.text))
            .collect()
    }

    fn schema(&self, port: &EndpointPort) -> Option<Schema> {
        self.scene.types.schema(&port.kind.as_ref()?.text)
    }

    /// Returns the type of a field; `None` if it is not known.
    fn within(
        &self,
        schema: Option<Schema>,
        field: Option<&str>,
        at: Span,
    ) -> Result<Option<Schema>, Box<UnknownProtocolEnd>> {
        let Some(mut here) = schema else {
            return Ok(None);
        };
        for step in field.into_iter().flat_map(|it| it.split('.')) {
            if here.shape == Shape::Any {
                return Ok(None);
            }
            let Some(part) = here.part(step) else {
                let fields = here.fields().iter();
                let known = fields.map(|it| it.name.to_string()).collect();
                return Err(Box::new(self.unknown("field", step, known, at)));
            };
            here = part.clone();
        }
        Ok(Some(here))
    }

    /// Checks an echo: `PORT.FIELD = PORT.FIELD`.
    fn echo(&self, text: &str, at: Span, report: &mut Report) {
        let face = &self.part.face;
        let sides = text.split_once('=').and_then(|(output, input)| {
            Some((
                output.trim().split_once('.')?,
                input.trim().split_once('.')?,
            ))
        });
        let Some((output, input)) = sides else {
            return report.found(UnknownProtocolEnd {
                component: self.part.component.name.value.clone(),
                what: "echo",
                name: text.to_owned(),
                at,
                key: self.key,
                nearest: None,
                help: "write `//@Echo OUTPUT.FIELD = INPUT.FIELD`".to_owned(),
            });
        };
        for ((name, field), ports, what) in [
            (output, &face.outputs, PortDirection::Out.word()),
            (input, &face.inputs, PortDirection::In.word()),
        ] {
            let Some(port) = ports.iter().find(|it| it.name.text == name) else {
                let known = ports.iter().map(|it| it.name.text.clone()).collect();
                report.found(self.unknown(what, name, known, at));
                continue;
            };
            if let Err(missing) = self.within(self.schema(port), Some(field), at) {
                report.found(*missing);
            }
        }
    }

    fn unknown(
        &self,
        what: &'static str,
        name: &str,
        known: Vec<String>,
        at: Span,
    ) -> UnknownProtocolEnd {
        let names = || known.iter().map(String::as_str);
        UnknownProtocolEnd {
            component: self.part.component.name.value.clone(),
            what,
            name: name.to_owned(),
            at,
            key: self.key,
            nearest: nearest_name(name, names()),
            help: has(what, names()),
        }
    }
}

/// Returns the port with the longest name that an end begins with, and the field behind it.
fn longest<'p, 'e>(
    ports: &'p [EndpointPort],
    end: &'e str,
) -> Option<(&'p EndpointPort, Option<&'e str>)> {
    let behind = |port: &'p EndpointPort| {
        let rest = end.strip_prefix(port.name.text.as_str())?;
        match rest.strip_prefix('.') {
            Some(field) => Some((port, Some(field))),
            None => rest.is_empty().then_some((port, None)),
        }
    };
    let found = ports.iter().filter_map(behind);
    found.max_by_key(|(port, _)| port.name.text.len())
}

/// Returns the service or reference that an end begins with, and what is behind it.
fn named<'p, 'e>(
    services: &'p [EndpointService],
    end: &'e str,
) -> Option<(&'p EndpointService, &'e str)> {
    let behind = |service: &'p EndpointService| {
        let rest = end.strip_prefix(service.name.text.as_str())?;
        Some((service, rest.strip_prefix('.')?))
    };
    services.iter().find_map(behind)
}

/// Returns whether messages of a type have values of a codomain.
fn carries(schema: &Schema, codomain: &Codomain, has_field: bool) -> bool {
    let schema = schema.without_option();
    // a message with one field is read with and without the name of the field
    let schema = match schema.fields() {
        [only] if !has_field => only.schema.without_option(),
        _ => schema,
    };
    match codomain {
        Codomain::Boolean => {
            !has_field
                || match schema.shape {
                    Shape::Any | Shape::Bool | Shape::List(_) | Shape::Array(..) => true,
                    Shape::I8
                    | Shape::I16
                    | Shape::I32
                    | Shape::I64
                    | Shape::U8
                    | Shape::U16
                    | Shape::U32
                    | Shape::U64
                    | Shape::F32
                    | Shape::F64
                    | Shape::Text
                    | Shape::Option(_)
                    | Shape::Record(_) => false,
                }
        }
        Codomain::Enum { .. } => matches!(schema.shape, Shape::Any | Shape::Text),
        Codomain::Integer
        | Codomain::Real
        | Codomain::Text
        | Codomain::List { .. }
        | Codomain::Tuple { .. }
        | Codomain::Map { .. }
        | Codomain::Character
        | Codomain::Abstract(_)
        | Codomain::Other(_) => false,
    }
}
