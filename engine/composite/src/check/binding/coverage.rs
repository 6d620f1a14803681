//! Compares the locations of a specification with those that the composite binds.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_coordinator::LocationName;
use asmotion_diagnostics::{Report, Span};

use super::{Bound, action};
use crate::at::At;
use crate::codes::c097::UnboundMonitored;
use crate::codes::c098::UnboundOut;
use crate::codes::c144::LocationBoundTwice;
use crate::finding::Findings;
use crate::nearest::nearest_name;
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
    for (set, key) in [(&mut monitored, "monitored"), (&mut out, "out")] {
        set.excuse(bound.scene.member.unread(key));
    }
    for function in signature.functions() {
        let at = file;
        match function.kind {
            FunctionKind::Monitored => {
                if let Some(missing) = monitored.missing(function) {
                    report.found(UnboundMonitored {
                        function: function.clone(),
                        missing,
                        at,
                    });
                }
            }
            FunctionKind::Out => {
                if let Some(missing) = out.missing(function) {
                    report.found(UnboundOut {
                        function: function.clone(),
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
struct BoundSet {
    locations: BTreeMap<String, Span>,
    /// Functions with a binding that is invalid, which is an error of its own.
    excused: BTreeSet<String>,
}

impl BoundSet {
    /// Adds the locations of a binding; reports the first that is bound already.
    fn add(&mut self, location: &At<String>, signature: &dyn Signature, report: &mut Report) {
        let name = LocationName::from(location.as_str());
        if function_of(&name, signature).is_none() {
            // the one that is meant
            let all = signature.functions();
            let known = all.iter().map(|it| it.name.as_str());
            let meant = nearest_name(&name.function, known).map(|it| it.name);
            self.excused.extend(meant);
        }
        let mut twice = None;
        for name in covered(location, signature) {
            match self.locations.get(&name) {
                Some(first) => twice = twice.or(Some((name, *first))),
                None => {
                    self.locations.insert(name, location.span);
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
            self.locations.entry(name).or_insert(event.span);
        }
    }

    /// Notes the locations of invalid bindings.
    fn excuse<'n>(&mut self, locations: impl Iterator<Item = &'n str>) {
        let functions = locations.map(|it| LocationName::from(it).function);
        self.excused.extend(functions);
    }

    /// Returns the locations of the function that are not bound: none in particular if all of them are not. `None` if
    /// the function is bound, or if the key of a binding has other arguments, which is an error of its own.
    fn missing(&self, function: &FunctionInfo) -> Option<Vec<String>> {
        let prefix = format!("{}(", function.name);
        let is_bound = |name: &&String| **name == function.name || name.starts_with(&prefix);
        if self.excused.contains(&function.name) {
            return None;
        }
        let bound: Vec<&String> = self.locations.keys().filter(is_bound).collect();
        if bound.is_empty() {
            return Some(Vec::new());
        }
        let all = locations(&function.pattern(), function)?;
        if bound.iter().any(|name| !all.contains(name)) {
            return None;
        }
        let missing = all
            .into_iter()
            .filter(|name| !self.locations.contains_key(name));
        let missing: Vec<_> = missing.collect();
        (!missing.is_empty()).then_some(missing)
    }
}

/// Returns the names of the locations that a binding covers.
fn covered(location: &At<String>, signature: &dyn Signature) -> Vec<String> {
    let name = LocationName::from(location.as_str());
    let function = function_of(&name, signature);
    let all = function.and_then(|function| locations(&name, function));
    all.unwrap_or_else(|| vec![name.to_string()])
}
