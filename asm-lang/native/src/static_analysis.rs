//! Static analysis: kinds of values, ranges of variables, and possible effects of terms.

use crate::emit::{Emitter, KnownValue};
use asmotion_ir::{
    BinderRange, BodyId, DomainElements, DomainId, FunctionKind, MAX_CREATED, Program, RoutineId,
    Rule, RuleNode, Term, TermNode, ValueKind,
};
use asmotion_value::Value;

/// A range that does not depend on the state.
#[derive(Clone, Copy)]
pub(crate) enum StaticRange {
    Ints(i64, i64),
    Atoms(u32, u32),
    Bools,
    /// The elements of a domain that rules extend; only in direct rules.
    Extent(DomainId),
}

impl StaticRange {
    pub fn count(self) -> u64 {
        match self {
            Self::Ints(low, high) if low > high => 0,
            Self::Ints(low, high) => high.abs_diff(low).saturating_add(1),
            Self::Atoms(_, count) => u64::from(count),
            Self::Bools => 2,
            // a direct rule gives up if there are more
            Self::Extent(_) => u64::from(MAX_CREATED),
        }
    }
}

impl Emitter<'_> {
    /// Returns the kind of a term's value, provided that it is not undef.
    pub fn kind(&self, term: &Term) -> ValueKind {
        match &*term.node {
            TermNode::Constant(Value::Bool(_)) => ValueKind::Bool,
            TermNode::Constant(Value::Int(_)) => ValueKind::Int,
            TermNode::Constant(Value::Atom(_)) => ValueKind::Atom,
            TermNode::Constant(_) => ValueKind::Other,
            TermNode::Local(local) => match self.scope.locals.get(*local as usize) {
                Some(KnownValue::Int(_)) => ValueKind::Int,
                Some(KnownValue::Bool(_)) => ValueKind::Bool,
                Some(KnownValue::Atom(_)) => ValueKind::Atom,
                Some(KnownValue::Memory(kind)) => *kind,
                Some(KnownValue::Nothing) | None => ValueKind::Other,
            },
            TermNode::Agent
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
            | TermNode::Listed(..)
            | TermNode::Interval(..)
            | TermNode::Collect(..)
            | TermNode::Map(_)
            | TermNode::CollectMap(..)
            | TermNode::Extent(_)
            | TermNode::Unbound
            | TermNode::Program(_)
            | TermNode::Pre(_)
            | TermNode::Watched(_)
            | TermNode::Name(_)
            | TermNode::Named(..) => term.kind,
        }
    }

    /// Returns `true` if a term has a scalar value and can be evaluated twice without an effect.
    pub fn is_native(&self, term: &Term) -> bool {
        matches!(
            self.kind(term),
            ValueKind::Int | ValueKind::Bool | ValueKind::Atom
        ) && is_repeatable(self.program, term)
    }

    /// Returns `true` if the environment provides values of a function.
    pub fn is_input(&self, function: asmotion_ir::FunctionId) -> bool {
        match self.program.functions[function.0 as usize].kind {
            FunctionKind::Monitored | FunctionKind::Shared => true,
            FunctionKind::Controlled
            | FunctionKind::Out
            | FunctionKind::Local
            | FunctionKind::Fixed => false,
        }
    }

    /// Returns the range of a variable if it is constant.
    pub fn span(&self, range: &BinderRange) -> Option<StaticRange> {
        match range {
            BinderRange::Ints(low, high) => Some(StaticRange::Ints(*low, *high)),
            BinderRange::Atoms(first, count) => Some(StaticRange::Atoms(*first, *count)),
            BinderRange::Bools => Some(StaticRange::Bools),
            BinderRange::Domain(domain) => match self.program.domains[domain.0 as usize].elements {
                DomainElements::Atoms { .. } if self.has_extent(*domain) => {
                    Some(StaticRange::Extent(*domain))
                }
                DomainElements::Atoms { first, count }
                    if !self.program.domains[domain.0 as usize].is_extended =>
                {
                    Some(StaticRange::Atoms(first.0, count))
                }
                DomainElements::Atoms { .. }
                | DomainElements::Ints { .. }
                | DomainElements::Computed(_)
                | DomainElements::Undefined
                | DomainElements::Open => None,
            },
            BinderRange::Elements(_) => None,
        }
    }
}

/// Returns `true` if evaluating a term twice has the same effect as evaluating it once: it neither
/// prints nor records.
pub(crate) fn is_repeatable(program: &Program, term: &Term) -> bool {
    !reaches(program, term, &mut Vec::new(), &|node| {
        if let TermNode::Builtin(builtin, _) = node {
            builtin.prints()
        } else {
            matches!(node, TermNode::Watched(_))
        }
    })
}

/// Returns `true` if evaluating a term may bind variables, which is counted.
pub(crate) fn counts(program: &Program, term: &Term) -> bool {
    reaches(program, term, &mut Vec::new(), &|node| {
        matches!(
            node,
            TermNode::Quantified(..) | TermNode::Collect(..) | TermNode::CollectMap(..)
        )
    })
}

/// Returns `true` if running a rule may bind variables to elements of a range, which is counted.
pub(crate) fn rule_counts(program: &Program, rule: &Rule) -> bool {
    fn search(program: &Program, rule: &Rule, seen: &mut Vec<RoutineId>) -> bool {
        rule.any(&mut |rule| {
            let terms = rule.node.terms();
            if terms.into_iter().any(|term| counts(program, term)) {
                return true;
            }
            match &*rule.node {
                RuleNode::Forall(..)
                | RuleNode::Choose(..)
                | RuleNode::Run(..)
                | RuleNode::RunAgent(..) => true,
                RuleNode::Call(routine, _) | RuleNode::Assign(_, routine, _) => {
                    if seen.contains(routine) {
                        return false;
                    }
                    seen.push(*routine);
                    search(program, &program.routines[routine.0 as usize].code, seen)
                }
                RuleNode::Skip
                | RuleNode::Update(..)
                | RuleNode::Par(_)
                | RuleNode::Seq(_)
                | RuleNode::If(..)
                | RuleNode::Switch(..)
                | RuleNode::Let(..)
                | RuleNode::Extend(..)
                | RuleNode::Watched(_)
                | RuleNode::While { .. }
                | RuleNode::Local { .. }
                | RuleNode::Draw(..)
                | RuleNode::Counted(..)
                | RuleNode::Act(..) => false,
            }
        })
    }
    search(program, rule, &mut Vec::new())
}

/// Returns `true` if a term, or a definition that it applies, contains a node that satisfies
/// `is_it`.
fn reaches(
    program: &Program,
    term: &Term,
    seen: &mut Vec<BodyId>,
    is_it: &dyn Fn(&TermNode) -> bool,
) -> bool {
    if is_it(&term.node) {
        return true;
    }
    if let TermNode::Call(body, _) = &*term.node
        && !seen.contains(body)
    {
        seen.push(*body);
        if reaches(program, &program.bodies[body.0 as usize].code, seen, is_it) {
            return true;
        }
    }
    let mut parts = term.node.terms().into_iter();
    parts.any(|part| reaches(program, part, seen, is_it))
}
