//! Compilation of terms.

use super::Compiler;
use super::collection::collect;
use super::rule::program_of;
use crate::fault::FaultKind;
use crate::naming::Naming;
use crate::run::code::TermCode;
use crate::run::{KleeneTruth, StepContext};
use asmotion_ir::{BodyId, DomainId, Origin, Term, TermNode};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

impl Compiler<'_> {
    /// Compiles a term to code that returns its value.
    pub fn term(&self, term: &Term) -> TermCode {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term))
    }

    fn term_here(&self, term: &Term) -> TermCode {
        let origin = term.origin;
        match &*term.node {
            TermNode::Constant(value) => {
                let value = value.clone();
                Box::new(move |_| value.clone())
            }
            TermNode::Unbound => Box::new(move |run| run.fail(FaultKind::Unbound, origin)),
            TermNode::Local(local) => {
                let local = *local;
                Box::new(move |run| run.local(local).clone())
            }
            TermNode::Agent => Box::new(|run| run.agent.clone()),
            TermNode::Slot(function, slot) => self.fixed(*function, *slot, origin),
            TermNode::Location(function, arguments) => self.location(*function, arguments, origin),
            TermNode::Call(body, arguments) => self.call_body(*body, arguments),
            TermNode::Cached(cache, term) => {
                let (cache, term) = (*cache as usize, self.term(term));
                Box::new(move |run| {
                    if let Some(value) = &run.state.memo.caches[cache] {
                        return value.clone();
                    }
                    let value = term(run);
                    if run.fault.is_none() {
                        run.state.memo.caches[cache] = Some(value.clone());
                    }
                    value
                })
            }
            TermNode::Builtin(builtin, arguments) => self.builtin(builtin, arguments, origin),
            TermNode::Logic(..)
            | TermNode::Not(_)
            | TermNode::Equal(..)
            | TermNode::Compare(..)
            | TermNode::Quantified(..) => {
                let truth = self.truth(term);
                Box::new(move |run| truth(run).value())
            }
            TermNode::Arithmetic(..) => {
                let integer = self.integer(term);
                Box::new(move |run| integer.get(run).map_or(Value::Undef, Value::Int))
            }
            TermNode::Name(element) => {
                let element = self.term(element);
                Box::new(move |run| {
                    let element = element(run);
                    if element.is_undef() {
                        Value::Undef
                    } else {
                        Value::text(name(run, &element))
                    }
                })
            }
            TermNode::Named(domain, text) => {
                let (domain, text) = (*domain, self.term(text));
                Box::new(move |run| {
                    let text = text(run);
                    named(run, domain, &text)
                })
            }
            TermNode::Tuple(items) => {
                let items = self.terms(items);
                Box::new(move |run| Value::tuple(items.iter().map(|item| item(run))))
            }
            TermNode::Component(tuple, index) => {
                let (tuple, index) = (self.term(tuple), *index as usize);
                Box::new(move |run| {
                    if let Value::Tuple(items) = tuple(run) {
                        items.get(index).cloned().unwrap_or_default()
                    } else {
                        Value::Undef
                    }
                })
            }
            TermNode::If(guard, then, otherwise) => {
                let guard_origin = guard.origin;
                let guard = self.truth(guard);
                let then = self.term(then);
                let otherwise = self.term(otherwise);
                Box::new(move |run| match guard(run) {
                    KleeneTruth::True => then(run),
                    KleeneTruth::False => otherwise(run),
                    KleeneTruth::Undef => run.fail(FaultKind::UndefinedGuard, guard_origin),
                })
            }
            TermNode::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject);
                let cases: Vec<_> = cases
                    .iter()
                    .map(|(case, value)| (self.term(case), self.term(value)))
                    .collect();
                let otherwise = self.term(otherwise);
                Box::new(move |run| {
                    let subject = subject(run);
                    for (case, value) in &cases {
                        if case(run) == subject {
                            return value(run);
                        }
                    }
                    otherwise(run)
                })
            }
            TermNode::Let(bindings, body) => {
                let (bindings, body) = (self.bindings(bindings), self.term(body));
                Box::new(move |run| {
                    bindings.bind(run);
                    body(run)
                })
            }
            TermNode::Listed(collection, items) => {
                let (collection, items) = (*collection, self.terms(items));
                Box::new(move |run| {
                    collect(collection, items.iter().map(|item| item(run)).collect())
                })
            }
            TermNode::Interval(collection, from, to, step) => {
                self.interval(*collection, from, to, step.as_ref(), origin)
            }
            TermNode::Collect(collection, binders, guard, item) => {
                let ranges = self.ranges(binders, guard.as_ref(), true);
                self.comprehension(*collection, ranges, item, origin)
            }
            TermNode::Map(pairs) => {
                let pairs: Vec<_> = pairs
                    .iter()
                    .map(|(key, value)| (self.term(key), self.term(value)))
                    .collect();
                Box::new(move |run| {
                    Value::map(pairs.iter().map(|(key, value)| (key(run), value(run))))
                })
            }
            TermNode::CollectMap(binders, guard, key, value) => {
                let ranges = self.ranges(binders, guard.as_ref(), true);
                let (key, value) = (self.term(key), self.term(value));
                Box::new(move |run| {
                    let mut pairs = BTreeMap::new();
                    ranges.each(run, &mut |run| {
                        let key = key(run);
                        pairs.insert(key, value(run));
                        ControlFlow::Continue(())
                    });
                    Value::Map(Arc::new(pairs))
                })
            }
            TermNode::Extent(shape) => {
                let shape = shape.clone();
                Box::new(move |run| match run.extent(&shape) {
                    Ok(elements) => Value::set(elements),
                    Err(kind) => run.fail(kind, origin),
                })
            }
            TermNode::Watched(term) => self.watched_term(term),
            TermNode::Pre(term) => {
                let term = self.term(term);
                Box::new(move |run| run.in_previous_state(&term))
            }
            TermNode::Program(agent) => {
                let agent = self.term(agent);
                Box::new(move |run| {
                    let agent = agent(run);
                    program_of(run, &agent).map_or(Value::Undef, Value::Rule)
                })
            }
        }
    }

    fn call_body(&self, body: BodyId, arguments: &[Term]) -> TermCode {
        let arguments = self.values(arguments);
        Box::new(move |run| {
            let from = arguments.pass_arguments(run);
            run.call_body(body, from)
        })
    }

    fn builtin(
        &self,
        builtin: &'static asmotion_stdlib::Builtin,
        arguments: &[Term],
        origin: Origin,
    ) -> TermCode {
        let arguments = self.values(arguments);
        Box::new(move |run| {
            let from = arguments.push_all(run);
            let result = if builtin.strict && run.stack[from..].iter().any(Value::is_undef) {
                Ok(Value::Undef)
            } else {
                // built in place, because a method would borrow all of the context
                let names = crate::naming::Naming {
                    program: run.program,
                    reserve: &run.state.store.reserve,
                };
                let mut context = asmotion_stdlib::BuiltinContext {
                    names: &names,
                    now_ns: run.now_ns,
                    printed: &mut run.record.printed,
                };
                (builtin.body)(&run.stack[from..], &mut context)
            };
            run.stack.truncate(from);
            match result {
                Ok(value) => value,
                Err(fault) => run.fail(FaultKind::Library(fault), origin),
            }
        })
    }
}

fn name(run: &StepContext<'_>, element: &Value) -> String {
    let naming = Naming {
        program: run.program,
        reserve: &run.state.store.reserve,
    };
    element.show(&naming).to_string()
}

/// Returns the element of a domain with this name, or undef.
fn named(run: &StepContext<'_>, domain: DomainId, text: &Value) -> Value {
    let Value::Text(text) = text else {
        return Value::Undef;
    };
    let mut elements = run.state.store.extents[domain.0 as usize].iter();
    elements
        .find(|element| name(run, element) == **text)
        .cloned()
        .unwrap_or_default()
}
