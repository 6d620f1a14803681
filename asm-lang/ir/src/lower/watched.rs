//! Properties of a specification that every step of a run checks.

use std::collections::BTreeSet;

use asmotion_hir::{
    FunctionId, FunctionKind, Meaning, Model, PropertyLogic, TemporalProperty, Term,
};

use super::facts::visit;

/// Returns whether every step of a run checks a property: a constraint (`INVAR`) that reads inputs, which is an assumption about
/// them. In the mode of the reference tools, none is checked.
pub fn is_watched(model: &Model, property: &TemporalProperty) -> bool {
    property.logic == PropertyLogic::Constraint
        && !model.compatible
        && property
            .formulas
            .iter()
            .any(|formula| reads_input(model, &formula.root, &mut BTreeSet::new()))
}

/// Returns whether a term reads an input, also in the definition of a function.
fn reads_input(model: &Model, term: &Term, seen: &mut BTreeSet<FunctionId>) -> bool {
    let mut applied = Vec::new();
    visit(term, &mut |part| applied.extend(part.kind.function()));
    applied.into_iter().any(|id| {
        let Some(function) = model.functions.get(id.0 as usize) else {
            return false;
        };
        let is_input = matches!(
            function.kind,
            FunctionKind::Monitored | FunctionKind::Shared
        );
        is_input
            || matches!(&function.meaning, Meaning::Defined(body)
                if seen.insert(id) && reads_input(model, &body.root, seen))
    })
}
