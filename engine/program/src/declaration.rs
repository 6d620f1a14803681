//! The declaration of a program: read from its reply, completed and checked.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use asmotion_component::Dynamic;
use asmotion_component::declaration::{Declaration, OperationDeclaration, PropertyDeclaration};
use asmotion_component::{In, Interface, Out, Property, Provided, Required};
use asmotion_datum::{Datum, DatumError, Schema, Shape};

use crate::connection::ProgramConnection;
use crate::error::ProgramError;
use crate::process::{self, ProgramCommand};
use crate::reply::{expect, text_of, value_of};
use crate::request::ProgramRequest;

/// Version of the protocol.
const PROTOCOL: i64 = 1;

/// Greatest number of elements of an array, with those of arrays in it.
const MOST_ELEMENTS: usize = 1 << 24;

/// The declaration of a program.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramDeclaration {
    /// Name and version of the program for people; empty if it does not tell.
    pub implementation: String,
    /// The ports, services, references and properties, with the fields of all known types.
    pub declaration: Declaration,
    /// The same as the program declared it: some types by name alone.
    declared: Declaration,
}

/// ProgramHandles of a declared component.
pub(crate) struct ProgramHandles {
    pub inputs: Vec<(String, In<Datum>)>,
    pub outputs: BTreeMap<String, (Out<Datum>, Schema)>,
    pub services: Vec<DeclaredOperation<Provided<Dynamic>>>,
    pub references: Vec<DeclaredOperation<Required<Dynamic>>>,
    pub properties: Vec<(String, Property<Datum>)>,
}

/// An operation of a service or reference, with its handle.
pub(crate) struct DeclaredOperation<H> {
    /// Name of the service or reference.
    pub port: String,
    pub operation: OperationDeclaration,
    pub handle: H,
}

/// Starts a program, reads its declaration and ends it. `component` is the name of a component that it implements.
///
/// # Errors
/// The program cannot be started, ends, does not answer in time, or violates the protocol.
pub fn ask(command: &ProgramCommand, component: &str) -> Result<ProgramDeclaration, ProgramError> {
    let (mut connection, declaration) = connect(command, component, ProgramClock::Virtual)?;
    connection.end();
    Ok(declaration)
}

/// The clock of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ProgramClock {
    Virtual,
    Wall,
}

/// Starts a program and reads its declaration.
pub(crate) fn connect(
    command: &ProgramCommand,
    component: &str,
    clock: ProgramClock,
) -> Result<(ProgramConnection, ProgramDeclaration), ProgramError> {
    let until = Instant::now() + command.start_timeout;
    let (process, stream, log) = process::start(command, component)?;
    let mut connection = ProgramConnection::new(process, stream, log);
    let clock = match clock {
        ProgramClock::Virtual => "virtual",
        ProgramClock::Wall => "wall",
    };
    let hello = ProgramRequest::of("hello")
        .put("protocol", PROTOCOL)
        .put("component", component)
        .put("clock", clock);
    let hello = match i64::try_from(connection.offered_memory()) {
        Ok(size) if size > 0 => hello.put("shared_memory", size),
        Ok(_) | Err(_) => hello,
    };
    let left = until.saturating_duration_since(Instant::now());
    let reply = connection.exchange(&hello.datum(), "hello", left);
    let reply = reply.map_err(|error| error.with_limit(command.start_timeout))?;
    expect(&reply, "declare", "hello")?;
    let declaration = ProgramDeclaration::read(&reply)?;
    let uses_memory = value_of(&reply, "shared_memory").and_then(Datum::as_bool);
    connection.agree(uses_memory == Some(true));
    Ok((connection, declaration))
}

impl ProgramDeclaration {
    /// A declaration by a program with this name and version.
    pub fn new(implementation: String, declared: Declaration) -> Self {
        Self {
            implementation,
            declaration: declared.clone(),
            declared,
        }
    }

    /// Reads the reply to `hello`.
    fn read(reply: &Datum) -> Result<Self, ProgramError> {
        let version = reply.get("protocol").and_then(|it| it.as_int());
        if version != Some(PROTOCOL) {
            let version = version.map_or("no version".to_owned(), |it| format!("version {it}"));
            return Err(ProgramError::Protocol(format!(
                "the program speaks {version} of the protocol; this build speaks version {PROTOCOL}"
            )));
        }
        let declared: Declaration = reply.to().map_err(|error| misfit("", &error))?;
        let implementation = text_of(reply, "implementation").unwrap_or_default();
        Ok(Self::new(implementation, declared))
    }

    /// Returns whether both programs have declared the same.
    pub(crate) fn is_declared_alike(&self, other: &Self) -> bool {
        self.declared == other.declared
    }

    /// Completes types that the program gives by name alone, and checks the declaration.
    ///
    /// # Errors
    /// A contradiction, or a default, range or safe sample that does not fit its type.
    pub fn complete(
        mut self,
        known: &dyn Fn(&str) -> Option<Schema>,
    ) -> Result<Self, ProgramError> {
        let declaration = &mut self.declaration;
        for schema in schemas_mut(declaration) {
            fill(schema, known)?;
            check_size(schema)?;
        }
        for port in &mut declaration.outputs {
            if let Some(safe) = port.safe.take() {
                let safe = port.schema.complete(safe);
                let place = format!("the safe sample of output `{}`", port.name);
                port.safe = Some(safe.map_err(|error| misfit(&place, &error))?);
            }
        }
        for property in &mut declaration.properties {
            complete_property(property)?;
        }
        check_names(declaration)?;
        let mut scratch = Interface::new();
        self.declare(&mut scratch);
        match scratch.problems() {
            [] => Ok(self),
            [first, ..] => Err(ProgramError::protocol(first.to_string())),
        }
    }

    /// Declares ports, services, references and properties.
    pub(crate) fn declare(&self, interface: &mut Interface) -> ProgramHandles {
        let declaration = &self.declaration;
        let inputs = declaration.inputs.iter().map(|port| {
            let handle = interface.input_of(&port.name, port.schema.clone(), &port.doc);
            if port.command {
                interface.command(handle);
            }
            (port.name.clone(), handle)
        });
        let inputs = inputs.collect();
        let mut outputs = BTreeMap::new();
        for port in &declaration.outputs {
            let handle = interface.output_of(&port.name, port.schema.clone(), &port.doc);
            if let Some(safe) = &port.safe {
                interface.safe(handle, safe.clone());
            }
            outputs.insert(port.name.clone(), (handle, port.schema.clone()));
        }
        let mut services = Vec::new();
        for service in &declaration.services {
            for operation in &service.operations {
                let (name, doc) = (&service.name, &service.doc);
                services.push(DeclaredOperation {
                    port: name.clone(),
                    operation: operation.clone(),
                    handle: interface.serve_declared(
                        name,
                        &service.interface,
                        operation.clone(),
                        doc,
                    ),
                });
            }
        }
        let mut references = Vec::new();
        for reference in &declaration.references {
            for operation in &reference.operations {
                let (name, doc) = (&reference.name, &reference.doc);
                let handle =
                    interface.require_declared(name, &reference.interface, operation.clone(), doc);
                if reference.optional {
                    interface.optional(handle);
                }
                references.push(DeclaredOperation {
                    port: name.clone(),
                    operation: operation.clone(),
                    handle,
                });
            }
        }
        let properties = declaration.properties.iter().map(|property| {
            let handle = interface.property_of(property.clone());
            (property.name.clone(), handle)
        });
        ProgramHandles {
            inputs,
            outputs,
            services,
            references,
            properties: properties.collect(),
        }
    }

    /// The schemas of all named types of ports, operations and properties, by name.
    pub fn types(&self) -> BTreeMap<&str, &Schema> {
        let named = schemas(&self.declaration).filter(|it| !it.name.is_empty());
        named.map(|schema| (&*schema.name, schema)).collect()
    }
}

/// Fills in the fields of types that are given by name alone, at any depth, and compares the others with the known type of
/// their name.
fn fill(schema: &mut Schema, known: &dyn Fn(&str) -> Option<Schema>) -> Result<(), ProgramError> {
    if !schema.name.is_empty()
        && let Some(known) = known(&schema.name)
    {
        return match schema.compare(&known) {
            Ok(()) => {
                *schema = known;
                Ok(())
            }
            Err(difference) => Err(ProgramError::Protocol(format!(
                "the type `{schema}` differs from the known one of this name: {difference}"
            ))),
        };
    }
    schema.parts_mut().try_for_each(|part| fill(part, known))
}

/// Checks that a new message of a type has a sensible size: arrays are filled with zeros.
fn check_size(schema: &Schema) -> Result<(), ProgramError> {
    if elements(schema) <= MOST_ELEMENTS {
        return Ok(());
    }
    Err(ProgramError::Protocol(format!(
        "the type `{schema}` has arrays of more than {MOST_ELEMENTS} elements"
    )))
}

fn elements(schema: &Schema) -> usize {
    if let Shape::Array(element, count) = &schema.shape {
        return elements(element).saturating_mul(*count);
    }
    let parts = schema.parts().map(elements);
    parts.fold(0, usize::saturating_add).max(1)
}

fn complete_property(property: &mut PropertyDeclaration) -> Result<(), ProgramError> {
    let name = &property.name;
    let complete = |what: &str, value: &Datum| {
        let complete = property.schema.complete(value.clone());
        complete.map_err(|error| misfit(&format!("the {what} of property `{name}`"), &error))
    };
    let default = complete("default", &property.default)?;
    let range = match &property.range {
        Some((least, greatest)) => Some((complete("range", least)?, complete("range", greatest)?)),
        None => None,
    };
    let choices = property.choices.iter();
    let choices = choices.map(|choice| complete("choices", choice));
    let choices = choices.collect::<Result<_, _>>()?;
    property.default = default;
    property.range = range;
    property.choices = choices;
    Ok(())
}

/// Checks that each name can be part of a path, and that no name occurs twice.
fn check_names(declaration: &Declaration) -> Result<(), ProgramError> {
    let inputs = declaration.inputs.iter().map(|it| ("input", &it.name));
    let outputs = declaration.outputs.iter().map(|it| ("output", &it.name));
    let services = declaration.services.iter().map(|it| ("service", &it.name));
    let references = declaration.references.iter();
    let references = references.map(|it| ("reference", &it.name));
    let properties = declaration.properties.iter();
    let properties = properties.map(|it| ("property", &it.name));
    let mut seen = BTreeSet::new();
    for (kind, name) in inputs
        .chain(outputs)
        .chain(services)
        .chain(references)
        .chain(properties)
    {
        let is_word = |it: char| it.is_alphanumeric() || matches!(it, '_' | '-');
        if name.is_empty() || !name.chars().all(is_word) {
            return Err(ProgramError::Protocol(format!(
                "the {kind} `{name}` needs a name of letters, digits, `_` and `-`"
            )));
        }
        if !seen.insert((kind, name)) {
            return Err(ProgramError::Protocol(format!("duplicate {kind} `{name}`")));
        }
    }
    Ok(())
}

fn schemas(declaration: &Declaration) -> impl Iterator<Item = &Schema> {
    let ports = declaration.inputs.iter().chain(&declaration.outputs);
    let services = declaration.services.iter().flat_map(|it| &it.operations);
    let references = declaration.references.iter();
    let operations = services.chain(references.flat_map(|it| &it.operations));
    let properties = declaration.properties.iter().map(|it| &it.schema);
    let operations = operations.flat_map(|it| [&it.request, &it.response]);
    ports
        .map(|it| &it.schema)
        .chain(operations)
        .chain(properties)
}

fn schemas_mut(declaration: &mut Declaration) -> impl Iterator<Item = &mut Schema> {
    let ports = declaration.inputs.iter_mut();
    let ports = ports.chain(&mut declaration.outputs);
    let services = declaration.services.iter_mut();
    let references = declaration.references.iter_mut();
    let operations = services
        .flat_map(|it| &mut it.operations)
        .chain(references.flat_map(|it| &mut it.operations));
    let properties = declaration.properties.iter_mut();
    let properties = properties.map(|it| &mut it.schema);
    let operations = operations.flat_map(|it| [&mut it.request, &mut it.response]);
    ports
        .map(|it| &mut it.schema)
        .chain(operations)
        .chain(properties)
}

/// The error for a part of the declaration that does not fit.
fn misfit(place: &str, error: &DatumError) -> ProgramError {
    let place = if place.is_empty() {
        "the declaration"
    } else {
        place
    };
    ProgramError::Protocol(format!("{place} does not fit: {error}"))
}
