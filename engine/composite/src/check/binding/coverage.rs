//! Compares the locations of a specification with those that the composite binds.

use std::collections::BTreeMap;

use asmotion_coordinator::LocationName;
use asmotion_diagnostics::{Report, Span};

use super::{Bound, action};
use crate::at::At;
use crate::codes::c097::UnboundMonitored;
use crate::codes::c098::UnboundOut;
use crate::codes::c144::LocationBoundTwice;
use crate::finding::Findings;
use crate::pattern::{function_of, locations};
use crate::signature::{FunctionInfo, FunctionKind, Signature};

/// Reports locations that are bound twice, and monitored and out functions with locations that are not bound.
pub(super) fn check(bound: &Bound<'_>, signature: &dyn Signature, file: Span, report: &mut Report) {
    let bind = &bound.part.bind;
    let mut monitored = BoundSet::default();
    for binding in &bind.monitored {
        monitored.add(&binding.location, signature, report);
    }
    for event in action::events(bind) {
        monitored.complete(event, signature);
    }
    let mut out = BoundSet::default();
    for binding in &bind.out {
        out.add(&binding.location, signature, report);
    }
    for function in signature.functions() {
        let at = file;
        match function.kind {
            FunctionKind::Monitored => {
                if let Some(missing) = monitored.missing(&function) {
                    report.found(UnboundMonitored {
                        function,
                        missing,
                        at,
                    });
                }
            }
            FunctionKind::Out => {
                if let Some(missing) = out.missing(&function) {
                    report.found(UnboundOut {
                        function,
                        missing,
                        at,
                    });
                }
            }
            FunctionKind::Shared
            | FunctionKind::Controlled
            | FunctionKind::Static
            | FunctionKind::Derived
            | FunctionKind::Local => {}
        }
    }
}

/// The bound locations, each with the place of its binding.
#[derive(Default)]
struct BoundSet(BTreeMap<String, Span>);

impl BoundSet {
    /// Adds the locations of a binding; reports the first that is bound already.
    fn add(&mut self, location: &At<String>, signature: &dyn Signature, report: &mut Report) {
        let mut twice = None;
        for name in covered(location, signature) {
            match self.0.get(&name) {
                Some(first) => twice = twice.or(Some((name, *first))),
                None => {
                    self.0.insert(name, location.span);
                }
            }
        }
        if let Some((location_name, first)) = twice {
            report.found(LocationBoundTwice {
                location: location_name,
                at: location.span,
                first,
            });
        }
    }

    /// Adds the location of an event, which may have a binding as well.
    fn complete(&mut self, event: &At<String>, signature: &dyn Signature) {
        for name in covered(event, signature) {
            self.0.entry(name).or_insert(event.span);
        }
    }

    /// Returns the locations of the function that are not bound: none in particular if all of them are not. `None` if
    /// the function is bound.
    fn missing(&self, function: &FunctionInfo) -> Option<Vec<String>> {
        let prefix = format!("{}(", function.name);
        let mut names = self.0.keys();
        let is_bound = |name: &String| *name == function.name || name.starts_with(&prefix);
        if !names.any(is_bound) {
            return Some(Vec::new());
        }
        let all = locations(&function.pattern(), function)?;
        let missing = all.into_iter().filter(|name| !self.0.contains_key(name));
        let missing: Vec<_> = missing.collect();
        (!missing.is_empty()).then_some(missing)
    }
}

/// Returns the names of the locations that a binding covers.
fn covered(location: &At<String>, signature: &dyn Signature) -> Vec<String> {
    let name = LocationName::from(location.as_str());
    let function = function_of(&name, signature);
    let all = function.and_then(|function| locations(&name, &function));
    all.unwrap_or_else(|| vec![name.to_string()])
}
