//! Lints that need all definitions.

use super::facts::{Facts, visit};
use super::uses::unreached_literals;
use crate::codes::w006::StaticChanges;
use crate::codes::w007::DerivedNeverChanges;
use crate::codes::w033::UnreachedElement;
use asmotion_diagnostics::{Diagnostic, Finding, Report, Span};
use asmotion_hir::{
    DomainId, Function, FunctionKind, Meaning, Model, Term, TermKind, Type, TypeId,
};
use std::collections::BTreeMap;

/// Reports static functions that change, derived functions that never do, and literals that no function can take.
pub(super) fn warnings(model: &Model, facts: &Facts) -> Report {
    let mut report = Report::new();
    for (id, function) in model.own_functions() {
        let Meaning::Defined(body) = &function.meaning else {
            continue;
        };
        let finding = match (function.kind, facts.is_static(id)) {
            (FunctionKind::Static, false) => changing(facts, function, &body.root),
            (FunctionKind::Derived, true) if !takes_dynamic(model, function) => {
                constant(function, body.root.span)
            }
            _ => continue,
        };
        report.push(finding);
    }
    for finding in unreached(model) {
        report.push(finding.diagnostic());
    }
    report
}

/// Returns a finding for each literal that is only compared with, and one for those of an enumeration that nothing
/// mentions.
fn unreached(model: &Model) -> Vec<UnreachedElement> {
    let mut found = Vec::new();
    let mut unmentioned: BTreeMap<DomainId, UnreachedElement> = BTreeMap::new();
    for unreached in unreached_literals(model, &|_| None) {
        let Some(literal) = model.atoms.get(unreached.atom.0 as usize) else {
            continue;
        };
        let finding = UnreachedElement {
            literals: vec![literal.name.clone()],
            domain: model.domain(literal.domain).name.clone(),
            declared: literal.span,
            compared: unreached.compared,
        };
        if unreached.compared.is_some() {
            found.push(finding);
        } else if let Some(first) = unmentioned.get_mut(&literal.domain) {
            first.literals.extend(finding.literals);
        } else {
            unmentioned.insert(literal.domain, finding);
        }
    }
    found.extend(unmentioned.into_values());
    found
}

fn changing(facts: &Facts, function: &Function, body: &Term) -> Diagnostic {
    StaticChanges {
        name: function.name.clone(),
        declared: function.span,
        keyword: keyword(function, "static"),
        at: changes(facts, body),
    }
    .diagnostic()
}

fn constant(function: &Function, body: Span) -> Diagnostic {
    DerivedNeverChanges {
        name: function.name.clone(),
        declared: function.span,
        keyword: keyword(function, "derived"),
        body,
    }
    .diagnostic()
}

/// Returns `true` if an argument or the value belongs to a dynamic domain. AsmetaS requires such a
/// function to be derived, and regards `Agent` as dynamic.
fn takes_dynamic(model: &Model, function: &Function) -> bool {
    let is_dynamic = |id: &DomainId| {
        let domain = model.domain(*id);
        domain.dynamic || &*domain.name == "Agent"
    };
    let mut open: Vec<TypeId> = function.parameters.clone();
    open.push(function.codomain);
    while let Some(ty) = open.pop() {
        match model.types.get(ty) {
            Type::Domain(domain) if is_dynamic(domain) => return true,
            Type::Prod(parts) => open.extend(parts),
            Type::Seq(part) | Type::Powerset(part) | Type::Bag(part) => open.push(*part),
            Type::Map(key, value) => open.extend([*key, *value]),
            Type::Domain(_)
            | Type::Invalid
            | Type::Undef
            | Type::Boolean
            | Type::Integer
            | Type::Natural
            | Type::Real
            | Type::Complex
            | Type::Char
            | Type::String
            | Type::Rule => {}
        }
    }
    false
}

/// Returns the span of the first part whose value may change: a location, a function derived from
/// one, or a domain that grows.
fn changes(facts: &Facts, body: &Term) -> Option<Span> {
    let mut found: Option<Span> = None;
    visit(body, &mut |term| {
        let own = match term.kind.function() {
            Some(function) => !facts.is_static(function),
            None => matches!(&*term.kind, TermKind::Extent(_)) && facts.is_dynamic(term),
        };
        if own && found.is_none() {
            found = Some(term.span);
        }
    });
    found
}

/// Returns the span of the declaration's first keyword, `word`.
fn keyword(function: &Function, word: &str) -> Span {
    let declaration = function.declaration;
    Span {
        end: declaration.start + word.len() as u32,
        ..declaration
    }
}
