//! Terms compiled to code that gives their values.

use super::Compiler;
use super::collection::collect;
use super::rule::program_of;
use crate::code::TermCode;
use crate::fault::FaultKind;
use crate::naming::Naming;
use crate::run::{Run, Truth};
use asmotion_ir::{BodyId, DomainId, Node, Origin, Term};
use asmotion_value::Value;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

impl Compiler<'_> {
    /// A term as code that gives a value.
    pub fn term(&self, term: &Term) -> TermCode {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term))
    }

    fn term_here(&self, term: &Term) -> TermCode {
        let origin = term.origin;
        match &*term.node {
            Node::Constant(value) => {
                let value = value.clone();
                Box::new(move |_| value.clone())
            }
            Node::Unbound => Box::new(move |run| run.fail(FaultKind::Unbound, origin)),
            Node::Local(local) => {
                let local = *local;
                Box::new(move |run| run.local(local).clone())
            }
            Node::Agent => Box::new(|run| run.agent.clone()),
            Node::Slot(function, slot) => self.fixed(*function, *slot, origin),
            Node::Location(function, arguments) => self.location(*function, arguments, origin),
            Node::Call(body, arguments) => self.call_body(*body, arguments),
            Node::Cached(cache, term) => {
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
            Node::Builtin(builtin, arguments) => self.builtin(builtin, arguments, origin),
            Node::Logic(..)
            | Node::Not(_)
            | Node::Equal(..)
            | Node::Compare(..)
            | Node::Quantified(..) => {
                let truth = self.truth(term);
                Box::new(move |run| truth(run).value())
            }
            Node::Arithmetic(..) => {
                let integer = self.integer(term);
                Box::new(move |run| integer.get(run).map_or(Value::Undef, Value::Int))
            }
            Node::Name(element) => {
                let element = self.term(element);
                Box::new(move |run| match element(run) {
                    Value::Undef => Value::Undef,
                    element => Value::text(name(run, &element)),
                })
            }
            Node::Named(domain, text) => {
                let (domain, text) = (*domain, self.term(text));
                Box::new(move |run| {
                    let text = text(run);
                    named(run, domain, &text)
                })
            }
            Node::Tuple(items) => {
                let items = self.terms(items);
                Box::new(move |run| Value::tuple(items.iter().map(|item| item(run))))
            }
            Node::Component(tuple, index) => {
                let (tuple, index) = (self.term(tuple), *index as usize);
                Box::new(move |run| match tuple(run) {
                    Value::Tuple(items) => items.get(index).cloned().unwrap_or_default(),
                    _ => Value::Undef,
                })
            }
            Node::If(guard, then, otherwise) => {
                let guard_origin = guard.origin;
                let guard = self.truth(guard);
                let then = self.term(then);
                let otherwise = self.term(otherwise);
                Box::new(move |run| match guard(run) {
                    Truth::True => then(run),
                    Truth::False => otherwise(run),
                    Truth::Undef => run.fail(FaultKind::UndefinedGuard, guard_origin),
                })
            }
            Node::Switch(subject, cases, otherwise) => {
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
            Node::Let(bindings, body) => {
                let (bindings, body) = (self.bindings(bindings), self.term(body));
                Box::new(move |run| {
                    bindings.bind(run);
                    body(run)
                })
            }
            Node::Listed(collection, items) => {
                let (collection, items) = (*collection, self.terms(items));
                Box::new(move |run| {
                    collect(collection, items.iter().map(|item| item(run)).collect())
                })
            }
            Node::Interval(collection, from, to, step) => {
                self.interval(*collection, from, to, step.as_ref(), origin)
            }
            Node::Collect(collection, binders, guard, item) => {
                let ranges = self.ranges(binders, guard.as_ref(), true);
                self.comprehension(*collection, ranges, item, origin)
            }
            Node::Map(pairs) => {
                let pairs: Vec<_> = pairs
                    .iter()
                    .map(|(key, value)| (self.term(key), self.term(value)))
                    .collect();
                Box::new(move |run| {
                    Value::map(pairs.iter().map(|(key, value)| (key(run), value(run))))
                })
            }
            Node::CollectMap(binders, guard, key, value) => {
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
            Node::Extent(shape) => {
                let shape = shape.clone();
                Box::new(move |run| match run.extent(&shape) {
                    Ok(elements) => Value::set(elements),
                    Err(kind) => run.fail(kind, origin),
                })
            }
            Node::Watched(term) => self.watched_term(term),
            Node::Pre(term) => {
                let term = self.term(term);
                Box::new(move |run| run.before(&term))
            }
            Node::Program(agent) => {
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
            let from = arguments.passed(run);
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
            let from = arguments.stacked(run);
            let result = match builtin.strict && run.stack[from..].iter().any(Value::is_undef) {
                true => Ok(Value::Undef),
                false => {
                    // `naming` borrows the run only in part
                    let names = crate::naming::Naming {
                        program: run.program,
                        reserve: &run.state.store.reserve,
                    };
                    let mut context = asmotion_stdlib::Context {
                        names: &names,
                        now_ns: run.now_ns,
                        printed: &mut run.record.printed,
                    };
                    (builtin.body)(&run.stack[from..], &mut context)
                }
            };
            run.stack.truncate(from);
            match result {
                Ok(value) => value,
                Err(fault) => run.fail(FaultKind::Library(fault), origin),
            }
        })
    }
}

fn name(run: &Run<'_>, element: &Value) -> String {
    let naming = Naming {
        program: run.program,
        reserve: &run.state.store.reserve,
    };
    element.show(&naming).to_string()
}

/// The element of a domain that is called so.
fn named(run: &Run<'_>, domain: DomainId, text: &Value) -> Value {
    let Value::Text(text) = text else {
        return Value::Undef;
    };
    let mut elements = run.state.store.extents[domain.0 as usize].iter();
    elements
        .find(|element| name(run, element) == **text)
        .cloned()
        .unwrap_or_default()
}
