//! Access to the direct parts of terms and rules, for passes over a program: shared and exclusive, from one macro.

use crate::code::{AssignTarget, Binder, BinderRange, Rule, RuleNode, Term, TermNode};

macro_rules! visitors {
    ($terms:ident, $rules:ident, $ranges:ident, $iter:ident, $slice:ident $(, $mutable:tt)?) => {
        impl TermNode {
            /// Returns the direct subterms, in order of evaluation.
            pub fn $terms(&$($mutable)? self) -> Vec<&$($mutable)? Term> {
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
                    | Self::Listed(_, terms) => terms.$iter().collect(),
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
                        let cases = cases.$iter().flat_map(|(case, value)| [case, value]);
                        std::iter::once(subject)
                            .chain(cases)
                            .chain([otherwise])
                            .collect()
                    }
                    Self::Let(bindings, body) => {
                        let bound = bindings.$iter().map(|(_, term)| term);
                        bound.chain([body]).collect()
                    }
                    Self::Quantified(_, binders, guard) => $ranges(binders).chain(guard).collect(),
                    Self::Interval(_, from, to, step) => [from, to].into_iter().chain(step).collect(),
                    Self::Collect(_, binders, guard, item) => {
                        $ranges(binders).chain(guard).chain([item]).collect()
                    }
                    Self::Map(pairs) => pairs
                        .$iter()
                        .flat_map(|(key, value)| [key, value])
                        .collect(),
                    Self::CollectMap(binders, guard, key, value) => {
                        $ranges(binders).chain(guard).chain([key, value]).collect()
                    }
                }
            }
        }

        impl RuleNode {
            /// Returns the direct terms of a rule, in order of evaluation.
            pub fn $terms(&$($mutable)? self) -> Vec<&$($mutable)? Term> {
                match self {
                    Self::Skip
                    | Self::Par(_)
                    | Self::Seq(_)
                    | Self::Extend(..)
                    | Self::Local { .. }
                    | Self::Draw(..)
                    | Self::Watched(_)
                    | Self::Counted(..) => Vec::new(),
                    Self::Update(place, value) => place.$terms().chain([value]).collect(),
                    Self::Assign(place, _, arguments) => place
                        .$iter()
                        .flat_map(AssignTarget::$terms)
                        .chain(arguments)
                        .collect(),
                    Self::Call(_, arguments) | Self::Act(_, arguments) => arguments.$iter().collect(),
                    Self::Run(term, arguments) | Self::RunAgent(term, arguments) => {
                        std::iter::once(term).chain(arguments).collect()
                    }
                    Self::If(guard, _, _) => vec![guard],
                    Self::While { guard, .. } => guard.$iter().collect(),
                    Self::Switch(subject, cases, _) => {
                        let cases = cases.$iter().map(|(case, _)| case);
                        std::iter::once(subject).chain(cases).collect()
                    }
                    Self::Choose(binders, guard, _, _) | Self::Forall(binders, guard, _) => {
                        $ranges(binders).chain(guard).collect()
                    }
                    Self::Let(bindings, _) => bindings.$iter().map(|(_, term)| term).collect(),
                }
            }

            /// Returns the direct subrules, in order of execution.
            pub fn $rules(&$($mutable)? self) -> Vec<&$($mutable)? Rule> {
                match self {
                    Self::Skip
                    | Self::Update(..)
                    | Self::Assign(..)
                    | Self::Call(..)
                    | Self::Act(..)
                    | Self::Run(..)
                    | Self::RunAgent(..) => Vec::new(),
                    Self::Par(rules) | Self::Seq(rules) => rules.$iter().collect(),
                    Self::If(_, then, otherwise) | Self::Choose(_, _, then, otherwise) => {
                        vec![then, otherwise]
                    }
                    Self::Switch(_, cases, otherwise) => {
                        let cases = cases.$iter().map(|(_, rule)| rule);
                        cases.chain([otherwise]).collect()
                    }
                    Self::Local { initial, body, .. } => initial.$iter().chain([body]).collect(),
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
            fn $terms(&$($mutable)? self) -> std::slice::$slice<'_, Term> {
                match self {
                    Self::Slot(..) | Self::Local(_) => [].$iter(),
                    Self::Location(_, arguments) => arguments.$iter(),
                }
            }
        }

        fn $ranges(binders: &$($mutable)? [Binder]) -> impl Iterator<Item = &$($mutable)? Term> {
            binders
                .$iter()
                .filter_map(|binder| match &$($mutable)? binder.range {
                    BinderRange::Elements(term) => Some(term),
                    BinderRange::Ints(..)
                    | BinderRange::Atoms(..)
                    | BinderRange::Bools
                    | BinderRange::Domain(_) => None,
                })
        }
    };
}

visitors!(terms, rules, ranges, iter, Iter);
visitors!(terms_mut, rules_mut, ranges_mut, iter_mut, IterMut, mut);

impl Rule {
    /// Returns `true` if this rule, or one within it, satisfies a condition. Rules that it calls are not searched.
    pub fn any(&self, is_it: &mut dyn FnMut(&Self) -> bool) -> bool {
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            is_it(self) || self.node.rules().into_iter().any(|inner| inner.any(is_it))
        })
    }
}
