//! Values of inputs, as in `--values distance=0,9,10`.

use asmotion_lang::{Machine, NoInputs, Report, Specification, Value};
use asmotion_verify::InputValues;

/// The reason for which the values of an input cannot be used.
pub enum ValuesError {
    Text(String),
    Term(Report),
}

/// Reads `function=value,…`.
pub fn input_values(
    specification: &mut Specification,
    text: &str,
) -> Result<InputValues, ValuesError> {
    let refused = |text: &str| ValuesError::Text(text.to_owned());
    let (name, values) = text
        .split_once('=')
        .ok_or_else(|| refused("write FUNCTION=VALUE,VALUE"))?;
    let name = name.trim();
    let mut named = specification
        .model
        .own_functions()
        .filter(|(_, it)| &*it.name == name);
    let (id, function) = named
        .next()
        .ok_or_else(|| refused("the specification declares no such function"))?;
    let (function_id, codomain) = (asmotion_lang::ir::FunctionId(id.0), function.codomain);
    if !matches!(
        function.kind,
        asmotion_lang::FunctionKind::Monitored | asmotion_lang::FunctionKind::Shared
    ) {
        return Err(refused(
            "the function is no input: only monitored and shared functions are",
        ));
    }
    drop(named);
    let mut terms = Vec::new();
    for value in split(values) {
        terms.push(typed(specification, codomain, value.trim()).map_err(ValuesError::Term)?);
    }
    specification.lower().map_err(ValuesError::Term)?;
    let fault = |specification: &Specification, fault: &asmotion_lang::StepFault| {
        let mut report = Report::new();
        report.push(specification.explain(fault));
        ValuesError::Term(report)
    };
    let machine = specification.machine();
    let mut machine: Machine = machine.map_err(|it| fault(specification, &it))?;
    let mut values: Vec<Value> = Vec::new();
    for term in terms {
        let value = machine.evaluate(term, &mut NoInputs, 0);
        values.push(value.map_err(|it| fault(specification, &it))?);
    }
    Ok(InputValues {
        machine: 0,
        function: function_id,
        values,
    })
}

/// Adds a term for a value of an input.
fn typed(
    specification: &mut Specification,
    codomain: asmotion_lang::hir::TypeId,
    text: &str,
) -> Result<asmotion_lang::hir::AddedTerm, Report> {
    let file = specification.sources.add("--values", text);
    let term = asmotion_lang::syntax::parse_term(file, text)?;
    specification.model.add_typed(&term, codomain, "the value")
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
