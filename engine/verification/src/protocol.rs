//! Protocols: the behaviour of a component as others see it, as a specification.
//!
//! A monitored function is what the component receives, an update of an out function is what it sends. Annotations connect
//! them to the component:
//!
//! - `//@Port NAME` or `//@Port NAME.FIELD` before a function: the port of the component, or the field of its messages. For
//!   operations, `SERVICE.OPERATION` or `REFERENCE.OPERATION.FIELD`. Without it, the function has the name of the port.
//!   A Boolean function of a port is true in the step after a message has arrived. A function of a field has its value in the
//!   newest message or, if there is a function for the arrival too, in the message that has arrived; of a list, whether it has
//!   elements.
//!   An update of an out function sends a message, even if it does not change the value; the function is undef in the step after.
//! - `//@Echo PORT.FIELD = PORT.FIELD`: the field of each message sent repeats that of the newest message received.

use crate::actor::{
    ActorInput, ActorOutput, Echo, FunctionFacts, InputOrigin, OutputEffect, ReadFiles,
};
use crate::error::ModelError;
use asmotion_coordinator::{PublishWhen, Receive};
use asmotion_lang::syntax::ast;
use std::collections::BTreeMap;

/// The names that a protocol can connect functions to.
#[derive(Clone, Debug, Default)]
pub struct ComponentNames {
    /// Input ports.
    pub inputs: Vec<String>,
    /// Output ports.
    pub outputs: Vec<String>,
    /// Services.
    pub services: Vec<String>,
    /// References.
    pub references: Vec<String>,
}

/// The connections of a protocol.
#[derive(Debug, Default)]
pub(crate) struct ProtocolEnds {
    pub inputs: Vec<ActorInput>,
    pub outputs: Vec<ActorOutput>,
    pub echoes: Vec<Echo>,
}

/// Connects the functions of a protocol to a component.
///
/// # Errors
/// An annotation names something that the component does not have.
pub(crate) fn ends(
    component: &str,
    names: &ComponentNames,
    files: &ReadFiles,
) -> Result<ProtocolEnds, ModelError> {
    let problem = |problem: String| ModelError::Annotation {
        component: component.to_owned(),
        problem,
    };
    let mut found = ProtocolEnds::default();
    let own = files.loaded.units.iter().filter(|unit| !unit.library);
    for tree in own.map(|unit| &unit.tree) {
        let ports = port_annotations(tree);
        for annotation in tree
            .annotations
            .iter()
            .filter(|it| &*it.name.text == "Echo")
        {
            let echo = echo(&annotation.rest).ok_or_else(|| {
                problem(format!(
                    "`//@Echo {}`: write `//@Echo PORT.FIELD = PORT.FIELD`",
                    annotation.rest
                ))
            })?;
            for (known, name) in [(&names.outputs, &echo.output), (&names.inputs, &echo.input)] {
                if !known.contains(name) {
                    return Err(problem(format!("the component has no port `{name}`")));
                }
            }
            found.echoes.push(echo);
        }
        for function in &tree.functions {
            let declared = &*function.name.text;
            let name = files.names.get(declared).map_or(declared, String::as_str);
            let Some(facts) = files.functions.get(name) else {
                continue;
            };
            if !facts.elements.is_empty() {
                match function.kind {
                    ast::FunctionKind::Monitored | ast::FunctionKind::Out => {
                        return Err(problem(format!(
                            "`{declared}` has arguments: a function of a protocol is a port or a field"
                        )));
                    }
                    ast::FunctionKind::Static
                    | ast::FunctionKind::Derived
                    | ast::FunctionKind::Controlled
                    | ast::FunctionKind::Shared
                    | ast::FunctionKind::Local => continue,
                }
            }
            let end = ports.get(declared).map_or(declared, String::as_str);
            match function.kind {
                ast::FunctionKind::Monitored => {
                    let input = input(names, end, declared, name, facts);
                    let unknown =
                        || problem(format!("`{declared}`: the component has no input `{end}`"));
                    found.inputs.push(input.ok_or_else(unknown)?);
                }
                ast::FunctionKind::Out => {
                    let output = output(names, end, declared, name, facts);
                    let unknown =
                        || problem(format!("`{declared}`: the component has no output `{end}`"));
                    found.outputs.push(output.ok_or_else(unknown)?);
                }
                ast::FunctionKind::Static
                | ast::FunctionKind::Derived
                | ast::FunctionKind::Controlled
                | ast::FunctionKind::Shared
                | ast::FunctionKind::Local => {}
            }
        }
    }
    Ok(found)
}

/// The ends that annotations give functions.
fn port_annotations(tree: &ast::File) -> BTreeMap<String, String> {
    let ports = tree
        .annotations
        .iter()
        .filter(|it| &*it.name.text == "Port");
    let behind = |annotation: &ast::Annotation| {
        let at = annotation.name.span.start;
        let functions = tree.functions.iter().map(|it| &it.name);
        let later = functions.filter(|name| name.span.start > at);
        later.min_by_key(|name| name.span.start)
    };
    let ports =
        ports.filter_map(|it| Some((behind(it)?.text.to_string(), it.rest.trim().to_owned())));
    ports.collect()
}

fn echo(text: &str) -> Option<Echo> {
    let (output, input) = text.split_once('=')?;
    let (output, field) = output.trim().split_once('.')?;
    let (input, input_field) = input.trim().split_once('.')?;
    Some(Echo {
        output: output.to_owned(),
        field: field.to_owned(),
        input: input.to_owned(),
        input_field: input_field.to_owned(),
    })
}

fn input(
    names: &ComponentNames,
    end: &str,
    declared: &str,
    name: &str,
    facts: &FunctionFacts,
) -> Option<ActorInput> {
    let (origin, field) = match longest(&names.inputs, end) {
        Some((port, field)) => (InputOrigin::Port(port), field),
        None => {
            let (service, rest) = longest(&names.services, end)?;
            let (operation, field) = first_of(&rest?);
            (InputOrigin::Request { service, operation }, field)
        }
    };
    // a field keeps its value; an arrival is true in one step
    let receive = match (&field, facts.codomain.is_boolean()) {
        (None, true) => Receive::Edge,
        (None, false) => Receive::All,
        (Some(_), _) => Receive::Last,
    };
    Some(ActorInput {
        location: name.to_owned(),
        word: declared.to_owned(),
        function: name.to_owned(),
        codomain: facts.codomain.clone(),
        origin,
        receive,
        field,
        is: Vec::new(),
        none: None,
        stale: None,
        matching: Vec::new(),
        key: Vec::new(),
    })
}

fn output(
    names: &ComponentNames,
    end: &str,
    declared: &str,
    name: &str,
    facts: &FunctionFacts,
) -> Option<ActorOutput> {
    let effect = if let Some((port, field)) = longest(&names.outputs, end) {
        OutputEffect::Publish {
            port,
            field,
            key: Vec::new(),
            when: PublishWhen::OnUpdate,
        }
    } else if let Some((service, rest)) = longest(&names.services, end) {
        OutputEffect::Reply {
            service,
            operation: first_of(&rest?).0,
        }
    } else {
        let (reference, rest) = longest(&names.references, end)?;
        let (operation, field) = first_of(&rest?);
        OutputEffect::Send {
            reference,
            operation,
            field,
        }
    };
    Some(ActorOutput {
        location: name.to_owned(),
        word: declared.to_owned(),
        function: name.to_owned(),
        codomain: facts.codomain.clone(),
        effect,
    })
}

/// Splits an end into the known name that it begins with and the rest.
fn longest(known: &[String], end: &str) -> Option<(String, Option<String>)> {
    let rest = |name: &String| {
        let rest = end.strip_prefix(name.as_str())?;
        match rest.strip_prefix('.') {
            Some(field) => Some((name.clone(), Some(field.to_owned()))),
            None => rest.is_empty().then(|| (name.clone(), None)),
        }
    };
    known
        .iter()
        .filter_map(rest)
        .max_by_key(|(name, _)| name.len())
}

fn first_of(path: &str) -> (String, Option<String>) {
    match path.split_once('.') {
        Some((first, rest)) => (first.to_owned(), Some(rest.to_owned())),
        None => (path.to_owned(), None),
    }
}
