//! Values of inputs and messages, as in `--values distance=0,9,10`.

use asmotion_lang::ir::{FunctionId, message_uses};
use asmotion_lang::value::Atom;
use asmotion_lang::{FunctionKind, Machine, NoInputs, Report, Specification, Value, hir, stdlib};
use asmotion_verify::{ContentValues, InputValues, VerifiedMachine};

/// The reason for which the values of an input cannot be used.
pub enum ValuesError {
    Text(String),
    Term(Report),
}

/// The values of an input or of a message.
pub enum GivenValues {
    Input(InputValues),
    Content(ContentValues),
}

/// The use of the values.
enum ValuesTarget {
    Input(FunctionId),
    /// A partner that replies, or `None` for requests; and the operation.
    Content(Option<Value>, String),
}

/// Returns the machine that `machine.function=value,…` names, or else the first one that knows the function or partner, and the
/// text without the name of the machine.
pub fn machine_of(machines: &[VerifiedMachine], text: &str) -> (usize, String) {
    if machines.len() > 1 {
        for (index, machine) in machines.iter().enumerate() {
            let rest = text.strip_prefix(machine.name.as_str());
            if let Some(rest) = rest.and_then(|rest| rest.strip_prefix('.')) {
                return (index, rest.to_owned());
            }
        }
    }
    let name = text.split_once('=').map_or(text, |(name, _)| name.trim());
    let mut machines = machines.iter();
    let known = machines.position(|machine| target(&machine.specification, name).is_ok());
    (known.unwrap_or(0), text.to_owned())
}

/// Finds the input or message that a name denotes, and the type of its values.
fn target(
    specification: &Specification,
    name: &str,
) -> Result<(ValuesTarget, Option<hir::TypeId>), &'static str> {
    let model = &specification.model;
    let mut named = model.own_functions().filter(|(_, it)| &*it.name == name);
    if let Some((id, function)) = named.next() {
        let is_input = matches!(
            function.kind,
            FunctionKind::Monitored | FunctionKind::Shared
        );
        if is_input {
            let target = ValuesTarget::Input(FunctionId(id.0));
            return Ok((target, Some(function.codomain)));
        }
        if function.kind != FunctionKind::Out || message_uses(model).is_empty() {
            return Err("the function is no input: only monitored and shared functions are");
        }
    }
    let (partner, operation) = match name.split_once('.') {
        Some((partner, operation)) => (Some(partner), operation),
        None => (None, name),
    };
    let uses = message_uses(model);
    let mut operations = uses.iter().map(|it| stdlib::operation(it.operation));
    if !operations.any(|known| known == operation) {
        return Err("the specification declares no such function");
    }
    let mut functions = model.own_functions().map(|(_, function)| function);
    let declared = functions
        .find(|it| it.kind == FunctionKind::Out && stdlib::operation(&it.name) == operation);
    match partner {
        Some(partner) => {
            let atoms = &specification.program.symbols.atoms;
            let atom = atoms.iter().position(|known| **known == *partner);
            let atom = atom.ok_or("the specification has no such partner")?;
            let partner = Value::Atom(Atom(atom as u32));
            let target = ValuesTarget::Content(Some(partner), operation.to_owned());
            Ok((target, declared.map(|it| it.codomain)))
        }
        None => {
            let parameters = declared.map(|it| it.parameters.as_slice());
            let ty = match parameters {
                Some([_, only]) => Some(*only),
                Some(_) | None => None,
            };
            Ok((ValuesTarget::Content(None, operation.to_owned()), ty))
        }
    }
}

/// Reads `function=value,…`, or `partner.operation=value,…` for replies and `operation=value,…` for requests.
pub fn given_values(
    machine: usize,
    specification: &mut Specification,
    text: &str,
) -> Result<GivenValues, ValuesError> {
    let refused = |text: &str| ValuesError::Text(text.to_owned());
    let (name, values) = text
        .split_once('=')
        .ok_or_else(|| refused("write FUNCTION=VALUE,VALUE"))?;
    let (target, ty) = target(specification, name.trim()).map_err(refused)?;
    let mut terms = Vec::new();
    for value in split(values) {
        terms.push(typed(specification, ty, value.trim()).map_err(ValuesError::Term)?);
    }
    specification.lower().map_err(ValuesError::Term)?;
    let fault = |specification: &Specification, fault: &asmotion_lang::StepFault| {
        let mut report = Report::new();
        report.push(specification.explain(fault));
        ValuesError::Term(report)
    };
    let evaluator = specification.machine();
    let mut evaluator: Machine = evaluator.map_err(|it| fault(specification, &it))?;
    let mut values: Vec<Value> = Vec::new();
    for term in terms {
        let value = evaluator.evaluate(term, &mut NoInputs, 0);
        values.push(value.map_err(|it| fault(specification, &it))?);
    }
    Ok(match target {
        ValuesTarget::Input(function) => GivenValues::Input(InputValues {
            machine,
            function,
            values,
        }),
        ValuesTarget::Content(partner, operation) => GivenValues::Content(ContentValues {
            machine,
            partner,
            operation,
            values,
        }),
    })
}

/// Adds a term for a value of an input.
fn typed(
    specification: &mut Specification,
    ty: Option<hir::TypeId>,
    text: &str,
) -> Result<asmotion_lang::hir::AddedTerm, Report> {
    let file = specification.sources.add("--values", text);
    let term = asmotion_lang::syntax::parse_term(file, text)?;
    match ty {
        Some(ty) => specification.model.add_typed(&term, ty, "the value"),
        None => specification.model.add_term(&term),
    }
}

/// Splits at commas outside of brackets.
fn split(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0u32, 0);
    for (at, character) in text.char_indices() {
        match character {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' | '>' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.extend(text.get(start..at));
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.extend(text.get(start..));
    parts
}
