//! Grounding of terms.

use crate::fold;
use crate::grounding::Grounding;
use crate::known::KnownTerm;
use crate::program::{FAULT, GroundTerm, Sort, TableIndex};
use asmotion_ir::{AxisRange, BodyId, FunctionId, Local, Program, Storage, Term, TermNode};
use asmotion_value::Value;

/// The locals of a body or routine.
pub(crate) struct LocalFrame(Vec<KnownTerm>);

impl LocalFrame {
    pub fn new(mut arguments: Vec<KnownTerm>, locals: u32) -> Self {
        arguments.resize(locals as usize, KnownTerm::Value(Value::Undef));
        Self(arguments)
    }

    pub fn known(&self, local: Local) -> Option<&KnownTerm> {
        self.0.get(local as usize)
    }

    pub fn set(&mut self, local: Local, bound: KnownTerm) {
        if let Some(known) = self.0.get_mut(local as usize) {
            *known = bound;
        }
    }
}

impl Grounding<'_> {
    /// Grounds the application of a definition to arguments, which are evaluated first.
    pub fn call(&mut self, body: BodyId, arguments: Vec<KnownTerm>) -> KnownTerm {
        let program: &Program = self.context.program;
        let Some(body) = program.bodies.get(body.0 as usize) else {
            return KnownTerm::Unknown;
        };
        if body.open {
            return KnownTerm::Unknown;
        }
        let Some(first) = loud(&arguments) else {
            return KnownTerm::Unknown;
        };
        let mut frame = LocalFrame::new(arguments, body.locals);
        let result = self.nested(|grounding| grounding.term(&body.code, &mut frame));
        result.map_or(KnownTerm::Unknown, |result| after(first, result))
    }

    pub fn terms(&mut self, terms: &[Term], frame: &mut LocalFrame) -> Vec<KnownTerm> {
        terms.iter().map(|term| self.term(term, frame)).collect()
    }

    /// Grounds a term of type Boolean.
    pub fn truth(&mut self, term: &Term, frame: &mut LocalFrame) -> GroundTerm {
        self.term(term, frame).of_sort(Sort::Bool)
    }

    fn integer(&mut self, term: &Term, frame: &mut LocalFrame) -> GroundTerm {
        self.term(term, frame).of_sort(Sort::Int)
    }

    pub fn term(&mut self, term: &Term, frame: &mut LocalFrame) -> KnownTerm {
        if !self.has_room() {
            return KnownTerm::Unknown;
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.term_here(term, frame))
    }

    fn term_here(&mut self, term: &Term, frame: &mut LocalFrame) -> KnownTerm {
        let truth = |term| KnownTerm::of(term, Sort::Bool);
        match &*term.node {
            TermNode::Constant(value) => KnownTerm::Value(value.clone()),
            TermNode::Local(local) => match frame.known(*local) {
                Some(known) if self.may_copy(known) => known.clone(),
                Some(_) | None => KnownTerm::Unknown,
            },
            TermNode::Agent => self.agent.clone(),
            TermNode::Slot(function, slot) => self.location(*function, *slot),
            TermNode::Location(function, arguments) => {
                let arguments = self.terms(arguments, frame);
                self.computed_location(*function, arguments)
            }
            TermNode::Call(body, arguments) => {
                let arguments = self.terms(arguments, frame);
                self.call(*body, arguments)
            }
            TermNode::Cached(_, term) | TermNode::Watched(term) => self.term(term, frame),
            TermNode::Builtin(builtin, arguments) => {
                let arguments = self.terms(arguments, frame);
                self.library(builtin, arguments)
            }
            TermNode::Logic(connective, left, right) => {
                let (left, right) = (self.truth(left, frame), self.truth(right, frame));
                truth(fold::logic(*connective, left, right))
            }
            TermNode::Not(operand) => truth(fold::not(self.truth(operand, frame))),
            TermNode::Equal(left, right) => {
                let (left, right) = (self.term(left, frame), self.term(right, frame));
                equal(left, right)
            }
            TermNode::Compare(comparison, left, right) => {
                let (left, right) = (self.integer(left, frame), self.integer(right, frame));
                truth(fold::compare(*comparison, left, right))
            }
            TermNode::Arithmetic(operation, left, right) => {
                let (left, right) = (self.integer(left, frame), self.integer(right, frame));
                KnownTerm::of(fold::arithmetic(*operation, left, right), Sort::Int)
            }
            TermNode::Tuple(items) => tuple(self.terms(items, frame)),
            TermNode::Component(term, index) => match self.term(term, frame) {
                KnownTerm::Tuple(items) => {
                    let Some(first) = loud(&items) else {
                        return KnownTerm::Unknown;
                    };
                    let item = items.into_iter().nth(*index as usize);
                    item.map_or(KnownTerm::Unknown, |item| after(first, item))
                }
                KnownTerm::Value(Value::Tuple(items)) => {
                    let item = items.get(*index as usize);
                    KnownTerm::Value(item.cloned().unwrap_or_default())
                }
                KnownTerm::Value(_) => KnownTerm::Value(Value::Undef),
                KnownTerm::Term(..) | KnownTerm::Unknown => KnownTerm::Unknown,
            },
            TermNode::If(guard, then, otherwise) => {
                let guard = self.truth(guard, frame);
                match guard.constant() {
                    Some(1) => self.term(then, frame),
                    Some(0) => self.term(otherwise, frame),
                    Some(_) => KnownTerm::Unknown,
                    None => {
                        let then = self.term(then, frame);
                        let otherwise = self.term(otherwise, frame);
                        branch(guard, then, otherwise)
                    }
                }
            }
            TermNode::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, frame);
                self.switch(subject, cases, otherwise, frame)
            }
            TermNode::Let(bindings, body) => {
                let mut first = Vec::new();
                for (local, term) in bindings {
                    let bound = self.term(term, frame);
                    let Some(evaluated) = loud(std::slice::from_ref(&bound)) else {
                        return KnownTerm::Unknown;
                    };
                    first.extend(evaluated);
                    frame.set(*local, bound);
                }
                let body = self.term(body, frame);
                after(first, body)
            }
            TermNode::Quantified(quantifier, binders, guard) => {
                let instances = self.instances(binders, frame, |grounding, frame| match guard {
                    Some(guard) => grounding.truth(guard, frame),
                    None => GroundTerm::Constant(1),
                });
                match instances {
                    Some(instances) => truth(fold::quantified(*quantifier, instances)),
                    None => KnownTerm::Unknown,
                }
            }
            TermNode::Program(agent) => {
                let KnownTerm::Value(agent) = self.term(agent, frame) else {
                    return KnownTerm::Unknown;
                };
                let rule = self.program_of(&agent);
                KnownTerm::Value(rule.map_or(Value::Undef, Value::Rule))
            }
            TermNode::Listed(..)
            | TermNode::Interval(..)
            | TermNode::Collect(..)
            | TermNode::Map(_)
            | TermNode::CollectMap(..)
            | TermNode::Extent(_) => match self.constant_collection(term, frame) {
                Some(value) => KnownTerm::Value(value),
                None => KnownTerm::Unknown,
            },
            TermNode::Unbound | TermNode::Pre(_) | TermNode::Name(_) | TermNode::Named(..) => {
                KnownTerm::Unknown
            }
        }
    }

    fn switch(
        &mut self,
        subject: KnownTerm,
        cases: &[(Term, Term)],
        otherwise: &Term,
        frame: &mut LocalFrame,
    ) -> KnownTerm {
        let Some(first) = loud(std::slice::from_ref(&subject)) else {
            return KnownTerm::Unknown;
        };
        let mut guarded = Vec::new();
        let mut last = None;
        for (case, value) in cases {
            let case = self.term(case, frame);
            if !self.may_copy(&subject) {
                return KnownTerm::Unknown;
            }
            let guard = equal(subject.clone(), case).of_sort(Sort::Bool);
            match guard.constant() {
                Some(0) => {}
                Some(1) => {
                    last = Some(self.term(value, frame));
                    break;
                }
                Some(_) => return KnownTerm::Unknown,
                None => guarded.push((guard, self.term(value, frame))),
            }
        }
        let last = match last {
            Some(last) => last,
            None => self.term(otherwise, frame),
        };
        let cases = guarded.into_iter().rev();
        let whole = cases.fold(last, |rest, (guard, value)| branch(guard, value, rest));
        after(first, whole)
    }

    /// Grounds the value of a location with computed arguments.
    fn computed_location(&mut self, function: FunctionId, arguments: Vec<KnownTerm>) -> KnownTerm {
        let Some((base, indices, count)) = self.indices(function, arguments) else {
            return KnownTerm::Unknown;
        };
        let positions: Vec<u32> = (0..count).collect();
        let Some((indices, positions)) = fold::resolved(indices, positions) else {
            return KnownTerm::Unknown;
        };
        let mut sort = None;
        let mut elements = Vec::new();
        for position in positions {
            let Some((element, known)) = self.location(function, base + position).scalar() else {
                return KnownTerm::Unknown;
            };
            // a location of another sort than the others cannot occur
            if known.is_some() && sort.is_some() && known != sort {
                return KnownTerm::Unknown;
            }
            sort = sort.or(known);
            if !self.has_room() {
                return KnownTerm::Unknown;
            }
            elements.push(element);
        }
        let Some(sort) = sort else {
            return KnownTerm::Unknown;
        };
        KnownTerm::of(
            fold::table(indices, elements, GroundTerm::Constant(FAULT)),
            sort,
        )
    }

    /// Returns the first slot of a function, the table indices of its arguments, and the number of its locations. `None` unless
    /// its locations have consecutive slots.
    pub fn indices(
        &mut self,
        function: FunctionId,
        arguments: Vec<KnownTerm>,
    ) -> Option<(u32, Vec<TableIndex>, u32)> {
        let Storage::Dense {
            base, count, axes, ..
        } = self.function(function)?.storage.clone()
        else {
            return None;
        };
        let mut indices = Vec::new();
        if arguments.len() != axes.len() {
            return None;
        }
        for (argument, axis) in arguments.into_iter().zip(axes) {
            let (wanted, low) = match axis.over {
                AxisRange::Bool => (Sort::Bool, 0),
                AxisRange::Ints { low, .. } => (Sort::Int, low),
                AxisRange::Atoms { first, .. } => (Sort::Atom, i64::from(first)),
            };
            let term = argument.of_sort(wanted);
            if term == GroundTerm::Constant(FAULT) {
                return None;
            }
            indices.push(TableIndex {
                term,
                low,
                count: axis.over.count(),
                stride: axis.stride,
            });
        }
        Some((base, indices, count))
    }
}

/// Returns the terms among these meanings that must be evaluated even if they are not used, because they can fail or read an
/// input. `None` if one of them needs a machine.
pub(crate) fn loud(bounds: &[KnownTerm]) -> Option<Vec<GroundTerm>> {
    let mut all = Vec::new();
    for bound in bounds {
        match bound {
            KnownTerm::Value(_) => {}
            KnownTerm::Term(term, _) if term.is_silent() => {}
            KnownTerm::Term(term, _) => all.push(term.clone()),
            KnownTerm::Tuple(items) => all.extend(loud(items)?),
            KnownTerm::Unknown => return None,
        }
    }
    Some(all)
}

/// Evaluates terms before another whose value is returned.
fn after(first: Vec<GroundTerm>, last: KnownTerm) -> KnownTerm {
    if first.is_empty() {
        return last;
    }
    match last {
        KnownTerm::Term(term, sort) => KnownTerm::Term(fold::after(first, term), sort),
        KnownTerm::Value(value) => match Sort::number(&value) {
            // constants that are evaluated after something keep their sort only as terms
            Some((Some(sort), number)) => {
                KnownTerm::Term(fold::after(first, GroundTerm::Constant(number)), sort)
            }
            Some((None, _)) | None => KnownTerm::Unknown,
        },
        KnownTerm::Tuple(mut items) => {
            let Some(head) = items.first().cloned() else {
                return KnownTerm::Unknown;
            };
            if let Some(known) = items.first_mut() {
                *known = after(first, head);
            }
            KnownTerm::Tuple(items)
        }
        KnownTerm::Unknown => KnownTerm::Unknown,
    }
}

fn tuple(items: Vec<KnownTerm>) -> KnownTerm {
    let values = items.iter().map(|item| match item {
        KnownTerm::Value(value) => Some(value.clone()),
        KnownTerm::Term(..) | KnownTerm::Tuple(_) | KnownTerm::Unknown => None,
    });
    if let Some(values) = values.collect::<Option<Vec<Value>>>() {
        return KnownTerm::Value(Value::tuple(values));
    }
    if items.iter().any(|item| matches!(item, KnownTerm::Unknown)) {
        return KnownTerm::Unknown;
    }
    KnownTerm::Tuple(items)
}

/// Compares two meanings.
pub(crate) fn equal(left: KnownTerm, right: KnownTerm) -> KnownTerm {
    let parts = |bound: &KnownTerm| match bound {
        KnownTerm::Tuple(items) => Some(items.clone()),
        KnownTerm::Value(Value::Tuple(items)) => {
            Some(items.iter().cloned().map(KnownTerm::Value).collect())
        }
        KnownTerm::Value(_) | KnownTerm::Term(..) | KnownTerm::Unknown => None,
    };
    match (&left, &right) {
        (KnownTerm::Unknown, _) | (_, KnownTerm::Unknown) => return KnownTerm::Unknown,
        (KnownTerm::Value(left), KnownTerm::Value(right)) => {
            return KnownTerm::Value(Value::Bool(left == right));
        }
        _ => {}
    }
    if let (Some(lefts), Some(rights)) = (parts(&left), parts(&right)) {
        // both tuples are evaluated completely
        let (Some(mut first), Some(second)) = (loud(&lefts), loud(&rights)) else {
            return KnownTerm::Unknown;
        };
        first.extend(second);
        if lefts.len() != rights.len() {
            return KnownTerm::Unknown;
        }
        let mut whole = GroundTerm::Constant(1);
        for (left, right) in lefts.into_iter().zip(rights) {
            let part = equal(left, right).of_sort(Sort::Bool);
            whole = fold::logic(asmotion_ir::Connective::And, whole, part);
        }
        return after(first, KnownTerm::of(whole, Sort::Bool));
    }
    let (Some((left, first)), Some((right, second))) = (left.scalar(), right.scalar()) else {
        return KnownTerm::Unknown;
    };
    match (first, second) {
        (Some(first), Some(second)) if first != second => KnownTerm::Unknown,
        _ => KnownTerm::of(fold::equal(left, right), Sort::Bool),
    }
}

fn branch(guard: GroundTerm, then: KnownTerm, otherwise: KnownTerm) -> KnownTerm {
    let (then_term, then_sort) = match then.scalar() {
        Some(known) => known,
        None => (GroundTerm::Constant(FAULT), None),
    };
    let (other_term, other_sort) = match otherwise.scalar() {
        Some(known) => known,
        None => (GroundTerm::Constant(FAULT), None),
    };
    let Some(sort) = then_sort.or(other_sort) else {
        return KnownTerm::Unknown;
    };
    if other_sort.is_some_and(|other| other != sort) {
        return KnownTerm::Unknown;
    }
    KnownTerm::of(fold::branch(guard, then_term, other_term), sort)
}
