//! Final states: those in which the specification may stay, named by comments `//@Final`.

use asmotion_lang::Specification;
use asmotion_lang::hir::{DomainKind, Function, FunctionKind, Meaning, Model, Type};
use std::collections::BTreeSet;

/// Returns a term that is true in final states: all locations of a function have one of the named literals. `None` without such
/// comments.
pub(crate) fn condition(specification: &Specification) -> Option<String> {
    let model = &specification.model;
    let main = model.main.and_then(|id| model.rules.get(id.0 as usize))?;
    let file = main.span.file;
    let parsed = asmotion_lang::syntax::parse(file, specification.sources.text(file));
    let annotations = parsed.file.annotations.iter();
    let named: BTreeSet<&str> = annotations
        .filter(|annotation| &*annotation.name.text == "Final")
        .flat_map(|annotation| {
            let words = annotation
                .rest
                .split(|sign: char| !sign.is_alphanumeric() && sign != '_');
            words.filter(|word| !word.is_empty())
        })
        .collect();
    let functions = model.own_functions();
    let conditions: Vec<String> = functions
        .filter_map(|(_, function)| of_function(model, function, &named))
        .collect();
    (!conditions.is_empty()).then(|| conditions.join(" or "))
}

fn of_function(model: &Model, function: &Function, named: &BTreeSet<&str>) -> Option<String> {
    let is_updated = matches!(function.kind, FunctionKind::Controlled | FunctionKind::Out)
        && matches!(function.meaning, Meaning::State);
    let Type::Domain(domain) = model.types.get(function.codomain) else {
        return None;
    };
    let DomainKind::Enum { first, count } = model.domain(*domain).kind else {
        return None;
    };
    let atoms = model
        .atoms
        .iter()
        .skip(first.0 as usize)
        .take(count as usize);
    let literals: Vec<&str> = atoms
        .map(|atom| &*atom.name)
        .filter(|name| named.contains(name))
        .collect();
    if !is_updated || literals.is_empty() {
        return None;
    }
    let parameters: Vec<String> = (0..function.parameters.len())
        .map(|index| format!("$final{index}"))
        .collect();
    let location = if parameters.is_empty() {
        function.name.to_string()
    } else {
        format!("{}({})", function.name, parameters.join(", "))
    };
    let values: Vec<String> = literals
        .iter()
        .map(|literal| format!("{location} = {literal}"))
        .collect();
    let values = format!("({})", values.join(" or "));
    if parameters.is_empty() {
        return Some(values);
    }
    let binders = parameters.iter().zip(&function.parameters);
    let binders: Vec<String> = binders
        .map(|(parameter, ty)| format!("{parameter} in {}", model.show_type(*ty)))
        .collect();
    Some(format!("(forall {} with {values})", binders.join(", ")))
}
