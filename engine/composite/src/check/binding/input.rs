//! Checks that the inputs of a composite fit what its specification does with them: bound functions that it never reads,
//! and literals that it expects and no binding yields.

use std::collections::{BTreeMap, BTreeSet};

use asmotion_coordinator::LocationName;
use asmotion_diagnostics::{Report, Span};

use crate::at::At;
use crate::codes::c148::UnreadBoundFunction;
use crate::codes::c149::LiteralWithoutSource;
use crate::finding::Findings;
use crate::model::binding::{Action, Argument, Bind, Call, Effect, Monitored, Source};
use crate::signature::{Codomain, FunctionInfo, FunctionKind, Signature};
use crate::tree::{Branch, Node};

/// Reports bound functions that the specification never reads, and literals with which it compares an input and which
/// no binding yields.
pub(super) fn check(bind: &Bind, signature: &dyn Signature, report: &mut Report) {
    let functions = signature.functions();
    let mut inputs: BTreeMap<String, BoundInput<'_>> = BTreeMap::new();
    for (location, source) in sources(bind) {
        let name = LocationName::from(location.as_str()).function;
        let declared = functions.iter().find(|it| it.name == name);
        let is_input =
            |it: &&FunctionInfo| matches!(it.kind, FunctionKind::Monitored | FunctionKind::Shared);
        if let Some(function) = declared.filter(is_input) {
            let input = inputs.entry(name).or_insert_with(|| BoundInput {
                function,
                at: location.span,
                literals: Some(BTreeSet::new()),
            });
            input.add(source);
        }
    }
    unread(bind, signature, &inputs, report);
    without_source(signature, &inputs, report);
}

/// A monitored or shared function with its bindings.
struct BoundInput<'b> {
    function: &'b FunctionInfo,
    /// Place of the first binding.
    at: Span,
    /// The literals that the bindings yield; `None` if they may yield any.
    literals: Option<BTreeSet<String>>,
}

impl BoundInput<'_> {
    fn add(&mut self, source: InputSource<'_>) {
        let given = match source {
            InputSource::Binding(monitored) => constants(monitored),
            InputSource::Outcome(call) => {
                Some(call.literals().map(|it| it.value.clone()).collect())
            }
        };
        match (&mut self.literals, given) {
            (Some(literals), Some(given)) => literals.extend(given),
            (literals, _) => *literals = None,
        }
    }
}

/// Origin of the values of a bound function.
pub(super) enum InputSource<'b> {
    /// A binding of its own.
    Binding(&'b Monitored),
    /// The outcome of a call.
    Outcome(&'b Call),
}

/// Iterates over all bindings of monitored functions with their locations.
pub(super) fn sources(bind: &Bind) -> impl Iterator<Item = (&At<String>, InputSource<'_>)> {
    let bindings = bind.monitored.iter();
    let bindings = bindings.map(|it| (&it.location, InputSource::Binding(it)));
    let outcomes = bind
        .calls()
        .filter_map(|call| Some((call.event.as_ref()?, InputSource::Outcome(call))));
    bindings.chain(outcomes)
}

/// Returns the literals that a binding to a constant yields; `None` for any other binding.
fn constants(monitored: &Monitored) -> Option<BTreeSet<String>> {
    let Source::Value(value) = &monitored.from else {
        return None;
    };
    let others = [&monitored.none, &monitored.on_stale];
    let all = others.into_iter().flatten().chain([value]);
    all.map(constant).collect()
}

/// Returns the literal that a node names; `None` if it is not known before the run.
fn constant(node: &Node) -> Option<String> {
    if let Branch::Text(text) = &node.value
        && !text.contains("${")
    {
        Some(text.clone())
    } else {
        None
    }
}

fn unread(
    bind: &Bind,
    signature: &dyn Signature,
    inputs: &BTreeMap<String, BoundInput<'_>>,
    report: &mut Report,
) {
    let mut content = UsedContent::default();
    content.collect(bind);
    let Some(read) = signature.read_functions(&content.terms) else {
        return;
    };
    for (name, input) in inputs.iter().filter(|(name, _)| !read.contains(*name)) {
        let bindings = bind.monitored.iter();
        let mut own =
            bindings.filter(|it| LocationName::from(it.location.as_str()).function == *name);
        // without the binding, the request would not be kept
        let is_kept = own.any(|it| {
            matches!(&it.from, Source::Request(end) if content.kept.contains(&*end.component.value))
        });
        if !is_kept {
            report.found(UnreadBoundFunction {
                function: input.function.clone(),
                at: input.at,
            });
        }
    }
}

/// Terms of the specification and kept messages in the bindings.
#[derive(Default)]
struct UsedContent<'b> {
    terms: Vec<&'b str>,
    kept: BTreeSet<&'b str>,
}

impl<'b> UsedContent<'b> {
    fn collect(&mut self, bind: &'b Bind) {
        for monitored in &bind.monitored {
            if let Source::Timer { running, .. } = &monitored.from {
                self.terms.push(&running.value);
            }
            for field in &monitored.matching {
                self.argument(&field.value);
            }
        }
        for call in bind.calls() {
            call.with.iter().for_each(|with| self.argument(with));
            self.kept
                .extend(call.reply.as_ref().map(|it| it.value.as_str()));
        }
        for out in &bind.out {
            let Effect::Literals(cases) = &out.effect else {
                continue;
            };
            for action in cases.iter().flat_map(|(_, actions)| actions) {
                if let Action::Publish { value, .. } = action {
                    self.argument(value);
                }
            }
        }
    }

    fn argument(&mut self, argument: &'b Argument) {
        match argument {
            Argument::Kept { name, .. } => drop(self.kept.insert(&name.value)),
            Argument::Term(term) => self.terms.push(&term.value),
            Argument::Record(_, fields) => {
                fields.iter().for_each(|(_, field)| self.argument(field));
            }
            Argument::Value(_) => {}
        }
    }
}

fn without_source(
    signature: &dyn Signature,
    inputs: &BTreeMap<String, BoundInput<'_>>,
    report: &mut Report,
) {
    let enumerations = inputs.iter().filter_map(|(name, input)| {
        let Codomain::Enum { name: domain, .. } = &input.function.codomain else {
            return None;
        };
        Some((name, domain, input))
    });
    let known = enumerations
        .filter_map(|(name, domain, input)| Some((name, domain, input, input.literals.as_ref()?)));
    let known: Vec<_> = known.collect();
    let given = known
        .iter()
        .map(|(name, .., literals)| ((*name).clone(), (*literals).clone()));
    for missing in signature.missing_literals(&given.collect()) {
        let mut takers = known
            .iter()
            .filter(|(_, domain, ..)| **domain == missing.domain);
        if let Some((_, _, input, literals)) = takers.next() {
            report.found(LiteralWithoutSource {
                literal: missing.literal,
                function: input.function.name.clone(),
                yields: literals.iter().cloned().collect(),
                at: input.at,
                compared: missing.compared,
            });
        }
    }
}
