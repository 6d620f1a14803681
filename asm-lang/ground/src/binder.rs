//! Expansion of variables over finite ranges, and collections that are the same in every state.

use crate::grounding::Grounding;
use crate::known::KnownTerm;
use crate::program::GroundTerm;
use crate::term::LocalFrame;
use asmotion_ir::{
    Binder, BinderRange, Collection, DomainElements, DomainId, Term, TermNode, ValueShape,
};
use asmotion_value::{Atom, RuleId, Value};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Limit for the elements of a range.
const MAX_RANGE: u64 = 1 << 16;

impl Grounding<'_> {
    /// Grounds something for each assignment of the variables, in ascending order. `None` if a range depends on the state.
    pub fn instances<T>(
        &mut self,
        binders: &[Binder],
        frame: &mut LocalFrame,
        mut instance: impl FnMut(&mut Self, &mut LocalFrame) -> T,
    ) -> Option<Vec<T>> {
        let mut instances = Vec::new();
        self.nest(binders, frame, &mut |grounding, frame| {
            instances.push(instance(grounding, frame));
        })?;
        Some(instances)
    }

    fn nest(
        &mut self,
        binders: &[Binder],
        frame: &mut LocalFrame,
        visit: &mut dyn FnMut(&mut Self, &mut LocalFrame),
    ) -> Option<()> {
        let Some((binder, rest)) = binders.split_first() else {
            visit(self, frame);
            return Some(());
        };
        for value in self.range(&binder.range, frame)? {
            if !self.has_room() {
                return None;
            }
            frame.set(binder.local, KnownTerm::Value(value));
            self.nest(rest, frame, visit)?;
        }
        Some(())
    }

    /// Returns the elements of a range in ascending order.
    fn range(&mut self, range: &BinderRange, frame: &mut LocalFrame) -> Option<Vec<Value>> {
        match range {
            BinderRange::Ints(low, high) => ints(*low, *high),
            BinderRange::Atoms(first, count) => {
                let last = first.checked_add(*count)?;
                Some((*first..last).map(|atom| Value::Atom(Atom(atom))).collect())
            }
            BinderRange::Bools => Some(vec![Value::Bool(false), Value::Bool(true)]),
            BinderRange::Domain(domain) => self.domain(*domain),
            BinderRange::Elements(term) => {
                if let TermNode::Extent(shape) = &*term.node {
                    return self.shape(shape);
                }
                match self.term(term, frame) {
                    KnownTerm::Value(Value::Set(elements)) => {
                        Some(elements.iter().cloned().collect())
                    }
                    KnownTerm::Value(Value::Seq(elements)) => Some(elements.to_vec()),
                    KnownTerm::Value(_)
                    | KnownTerm::Term(..)
                    | KnownTerm::Tuple(_)
                    | KnownTerm::Unknown => None,
                }
            }
        }
    }

    fn domain(&self, domain: DomainId) -> Option<Vec<Value>> {
        match self
            .context
            .program
            .domains
            .get(domain.0 as usize)?
            .elements
        {
            DomainElements::Ints { low, high } => ints(low, high),
            DomainElements::Atoms { .. } | DomainElements::Computed(_) => {
                Some((self.context.extent)(domain))
            }
            DomainElements::Undefined | DomainElements::Open => None,
        }
    }

    fn shape(&self, shape: &ValueShape) -> Option<Vec<Value>> {
        match shape {
            ValueShape::Bool => Some(vec![Value::Bool(false), Value::Bool(true)]),
            ValueShape::Domain(domain) => self.domain(*domain),
            ValueShape::Tuple(items) => {
                let mut all: Vec<Vec<Value>> = vec![Vec::new()];
                for item in items {
                    let items = self.shape(item)?;
                    if all.len() as u64 * items.len() as u64 > MAX_RANGE {
                        return None;
                    }
                    let longer = |tuple: &Vec<Value>, value: &Value| {
                        let mut tuple = tuple.clone();
                        tuple.push(value.clone());
                        tuple
                    };
                    let extended = all
                        .iter()
                        .flat_map(|tuple| items.iter().map(move |value| longer(tuple, value)));
                    all = extended.collect();
                }
                Some(all.into_iter().map(Value::tuple).collect())
            }
            ValueShape::Int
            | ValueShape::Natural
            | ValueShape::Real
            | ValueShape::Char
            | ValueShape::Text
            | ValueShape::Complex
            | ValueShape::Rule
            | ValueShape::Seq(_)
            | ValueShape::Set(_)
            | ValueShape::Bag(_)
            | ValueShape::Map(..)
            | ValueShape::Any => None,
        }
    }

    /// Returns the value of a collection term that is the same in every state.
    pub fn constant_collection(&mut self, term: &Term, frame: &mut LocalFrame) -> Option<Value> {
        match &*term.node {
            TermNode::Listed(collection, items) => {
                let items = self.terms(items, frame);
                collected(*collection, values(items)?)
            }
            TermNode::Interval(collection, from, to, None) => {
                let (from, to) = (self.term(from, frame), self.term(to, frame));
                let (KnownTerm::Value(Value::Int(from)), KnownTerm::Value(Value::Int(to))) =
                    (from, to)
                else {
                    return None;
                };
                collected(*collection, ints(from, to)?)
            }
            TermNode::Collect(collection, binders, guard, item) => {
                let items = self.instances(binders, frame, |grounding, frame| {
                    let included = match guard {
                        Some(guard) => grounding.truth(guard, frame),
                        None => GroundTerm::Constant(1),
                    };
                    match included.constant() {
                        Some(0) => Some(None),
                        Some(1) => match grounding.term(item, frame) {
                            KnownTerm::Value(value) => Some(Some(value)),
                            KnownTerm::Term(..) | KnownTerm::Tuple(_) | KnownTerm::Unknown => None,
                        },
                        Some(_) | None => None,
                    }
                })?;
                let items = items.into_iter().collect::<Option<Vec<Option<Value>>>>()?;
                collected(*collection, items.into_iter().flatten().collect())
            }
            TermNode::Extent(shape) => Some(Value::set(self.shape(shape)?)),
            TermNode::Map(pairs) => {
                let mut all = Vec::new();
                for (key, value) in pairs {
                    let pair = values(vec![self.term(key, frame), self.term(value, frame)])?;
                    if let [key, value] = pair.as_slice() {
                        all.push((key.clone(), value.clone()));
                    }
                }
                Some(Value::map(all))
            }
            TermNode::Constant(_)
            | TermNode::Local(_)
            | TermNode::Agent
            | TermNode::Slot(..)
            | TermNode::Location(..)
            | TermNode::Call(..)
            | TermNode::Cached(..)
            | TermNode::Builtin(..)
            | TermNode::Logic(..)
            | TermNode::Not(_)
            | TermNode::Equal(..)
            | TermNode::Compare(..)
            | TermNode::Arithmetic(..)
            | TermNode::Tuple(_)
            | TermNode::Component(..)
            | TermNode::If(..)
            | TermNode::Switch(..)
            | TermNode::Let(..)
            | TermNode::Quantified(..)
            | TermNode::Interval(_, _, _, Some(_))
            | TermNode::CollectMap(..)
            | TermNode::Unbound
            | TermNode::Program(_)
            | TermNode::Pre(_)
            | TermNode::Watched(_)
            | TermNode::Name(_)
            | TermNode::Named(..) => None,
        }
    }

    /// Returns the program of an agent.
    pub fn program_of(&self, agent: &Value) -> Option<RuleId> {
        let Value::Atom(atom) = agent else {
            return None;
        };
        let program = self.context.program;
        let domain = program.atom_domains.get(atom.0 as usize)?;
        let mut programs = program.programs.iter();
        programs.find(|(of, _)| of == domain).map(|(_, rule)| *rule)
    }
}

/// Returns the values if all meanings are the same in every state.
pub(crate) fn values(bounds: Vec<KnownTerm>) -> Option<Vec<Value>> {
    let value = |bound| match bound {
        KnownTerm::Value(value) => Some(value),
        KnownTerm::Term(..) | KnownTerm::Tuple(_) | KnownTerm::Unknown => None,
    };
    bounds.into_iter().map(value).collect()
}

fn collected(collection: Collection, items: Vec<Value>) -> Option<Value> {
    match collection {
        Collection::Set => Some(Value::Set(Arc::new(
            items.into_iter().collect::<BTreeSet<Value>>(),
        ))),
        Collection::Seq => Some(Value::seq(items)),
        Collection::Bag => Some(Value::bag(items)),
    }
}

fn ints(low: i64, high: i64) -> Option<Vec<Value>> {
    if low > high {
        return Some(Vec::new());
    }
    (high.abs_diff(low) < MAX_RANGE).then(|| (low..=high).map(Value::Int).collect())
}
