//! Access to the direct parts of terms and rules, for passes over a program.

use crate::code::{AssignTarget, Binder, BinderRange, Rule, RuleNode, Term, TermNode};

impl TermNode {
    /// Returns the direct subterms, in order of evaluation.
    pub fn terms_mut(&mut self) -> Vec<&mut Term> {
        match self {
            Self::Constant(_)
            | Self::Local(_)
            | Self::Agent
            | Self::Slot(..)
            | Self::Extent(_)
            | Self::Unbound => Vec::new(),
            Self::Location(_, terms)
            | Self::Call(_, terms)
            | Self::Builtin(_, terms)
            | Self::Tuple(terms)
            | Self::Listed(_, terms) => terms.iter_mut().collect(),
            Self::Cached(_, term)
            | Self::Watched(term)
            | Self::Pre(term)
            | Self::Not(term)
            | Self::Component(term, _)
            | Self::Program(term)
            | Self::Name(term)
            | Self::Named(_, term) => vec![term],
            Self::Logic(_, left, right)
            | Self::Equal(left, right)
            | Self::Compare(_, left, right)
            | Self::Arithmetic(_, left, right) => vec![left, right],
            Self::If(guard, then, otherwise) => vec![guard, then, otherwise],
            Self::Switch(subject, cases, otherwise) => {
                let cases = cases.iter_mut().flat_map(|(case, value)| [case, value]);
                std::iter::once(subject)
                    .chain(cases)
                    .chain([otherwise])
                    .collect()
            }
            Self::Let(bindings, body) => {
                let bound = bindings.iter_mut().map(|(_, term)| term);
                bound.chain([body]).collect()
            }
            Self::Quantified(_, binders, guard) => ranges(binders).chain(guard).collect(),
            Self::Interval(_, from, to, step) => [from, to].into_iter().chain(step).collect(),
            Self::Collect(_, binders, guard, item) => {
                ranges(binders).chain(guard).chain([item]).collect()
            }
            Self::Map(pairs) => pairs
                .iter_mut()
                .flat_map(|(key, value)| [key, value])
                .collect(),
            Self::CollectMap(binders, guard, key, value) => {
                ranges(binders).chain(guard).chain([key, value]).collect()
            }
        }
    }
}

impl RuleNode {
    /// Returns the direct terms of a rule, in order of evaluation.
    pub fn terms_mut(&mut self) -> Vec<&mut Term> {
        match self {
            Self::Skip
            | Self::Par(_)
            | Self::Seq(_)
            | Self::Extend(..)
            | Self::Local { .. }
            | Self::Draw(..)
            | Self::Watched(_)
            | Self::Counted(..) => Vec::new(),
            Self::Update(place, value) => place.terms_mut().chain([value]).collect(),
            Self::Assign(place, _, arguments) => place
                .iter_mut()
                .flat_map(AssignTarget::terms_mut)
                .chain(arguments)
                .collect(),
            Self::Call(_, arguments) | Self::Act(_, arguments) => arguments.iter_mut().collect(),
            Self::Run(term, arguments) | Self::RunAgent(term, arguments) => {
                std::iter::once(term).chain(arguments).collect()
            }
            Self::If(guard, _, _) => vec![guard],
            Self::While { guard, .. } => guard.iter_mut().collect(),
            Self::Switch(subject, cases, _) => {
                let cases = cases.iter_mut().map(|(case, _)| case);
                std::iter::once(subject).chain(cases).collect()
            }
            Self::Choose(binders, guard, _, _) | Self::Forall(binders, guard, _) => {
                ranges(binders).chain(guard).collect()
            }
            Self::Let(bindings, _) => bindings.iter_mut().map(|(_, term)| term).collect(),
        }
    }

    /// Returns the direct subrules, in order of execution.
    pub fn rules_mut(&mut self) -> Vec<&mut Rule> {
        match self {
            Self::Skip
            | Self::Update(..)
            | Self::Assign(..)
            | Self::Call(..)
            | Self::Act(..)
            | Self::Run(..)
            | Self::RunAgent(..) => Vec::new(),
            Self::Par(rules) | Self::Seq(rules) => rules.iter_mut().collect(),
            Self::If(_, then, otherwise) | Self::Choose(_, _, then, otherwise) => {
                vec![then, otherwise]
            }
            Self::Switch(_, cases, otherwise) => {
                let cases = cases.iter_mut().map(|(_, rule)| rule);
                cases.chain([otherwise]).collect()
            }
            Self::Local { initial, body, .. } => initial.iter_mut().chain([body]).collect(),
            Self::Forall(_, _, body)
            | Self::Let(_, body)
            | Self::Extend(_, _, body)
            | Self::While { body, .. }
            | Self::Draw(_, body)
            | Self::Counted(_, body)
            | Self::Watched(body) => vec![body],
        }
    }
}

impl AssignTarget {
    fn terms_mut(&mut self) -> std::slice::IterMut<'_, Term> {
        match self {
            Self::Slot(..) | Self::Local(_) => [].iter_mut(),
            Self::Location(_, arguments) => arguments.iter_mut(),
        }
    }
}

fn ranges(binders: &mut [Binder]) -> impl Iterator<Item = &mut Term> {
    binders
        .iter_mut()
        .filter_map(|binder| match &mut binder.range {
            BinderRange::Elements(term) => Some(term),
            BinderRange::Ints(..)
            | BinderRange::Atoms(..)
            | BinderRange::Bools
            | BinderRange::Domain(_) => None,
        })
}
