//! Compilation of Boolean terms to three-valued truth values, used for guards.

use super::Compiler;
use super::range::Ranges;
use crate::fault::FaultKind;
use crate::run::KleeneTruth;
use crate::run::code::TruthCode;
use asmotion_ir::{Comparison, Connective, Quantifier, Term, TermNode, ValueKind};
use std::ops::ControlFlow;

impl Compiler<'_> {
    /// Compiles a term of type Boolean.
    pub fn truth(&self, term: &Term) -> TruthCode {
        match &*term.node {
            TermNode::Logic(logic, left, right) => self.logic(*logic, left, right),
            TermNode::Not(operand) => {
                let operand = self.truth(operand);
                Box::new(move |run| match operand(run) {
                    KleeneTruth::True => KleeneTruth::False,
                    KleeneTruth::False => KleeneTruth::True,
                    KleeneTruth::Undef => KleeneTruth::Undef,
                })
            }
            TermNode::Equal(left, right) => self.equal(left, right),
            TermNode::Compare(comparison, left, right) => self.compare(*comparison, left, right),
            TermNode::Quantified(quantifier, binders, guard) => {
                self.quantified(*quantifier, self.ranges(binders, guard.as_ref(), false))
            }
            TermNode::Slot(function, slot) if !self.is_input(*function) => {
                let slot = *slot as usize;
                Box::new(move |run| KleeneTruth::from_value(&run.state.store.slots[slot]))
            }
            TermNode::If(guard, then, otherwise) => {
                let origin = guard.origin;
                let (guard, then, otherwise) =
                    (self.truth(guard), self.truth(then), self.truth(otherwise));
                Box::new(move |run| match guard(run) {
                    KleeneTruth::True => then(run),
                    KleeneTruth::False => otherwise(run),
                    KleeneTruth::Undef => {
                        run.fail(FaultKind::UndefinedGuard, origin);
                        KleeneTruth::Undef
                    }
                })
            }
            TermNode::Constant(_)
            | TermNode::Local(_)
            | TermNode::Agent
            | TermNode::Slot(..)
            | TermNode::Location(..)
            | TermNode::Call(..)
            | TermNode::Cached(..)
            | TermNode::Builtin(..)
            | TermNode::Arithmetic(..)
            | TermNode::Tuple(_)
            | TermNode::Component(..)
            | TermNode::Switch(..)
            | TermNode::Let(..)
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
            | TermNode::Named(..) => match self.stored(term) {
                Some(slot) => Box::new(move |run| {
                    let slot = slot(run) as usize;
                    KleeneTruth::from_value(&run.state.store.slots[slot])
                }),
                None => {
                    let code = self.term(term);
                    Box::new(move |run| KleeneTruth::from_value(&code(run)))
                }
            },
        }
    }

    /// Compiles a strong Kleene connective. The right operand is skipped if the left one decides
    /// the result.
    fn logic(&self, logic: Connective, left: &Term, right: &Term) -> TruthCode {
        use KleeneTruth::{False, True, Undef};
        let (left, right) = (self.truth(left), self.truth(right));
        match logic {
            Connective::And => Box::new(move |run| match left(run) {
                False => False,
                True => right(run),
                Undef => {
                    if right(run) == False {
                        False
                    } else {
                        Undef
                    }
                }
            }),
            Connective::Or => Box::new(move |run| match left(run) {
                True => True,
                False => right(run),
                Undef => {
                    if right(run) == True {
                        True
                    } else {
                        Undef
                    }
                }
            }),
            Connective::Implies => Box::new(move |run| match left(run) {
                False => True,
                True => right(run),
                Undef => {
                    if right(run) == True {
                        True
                    } else {
                        Undef
                    }
                }
            }),
            Connective::Xor => Box::new(move |run| match (left(run), right(run)) {
                (Undef, _) | (_, Undef) => Undef,
                (left, right) => KleeneTruth::of(left != right),
            }),
            Connective::Iff => Box::new(move |run| match (left(run), right(run)) {
                (Undef, _) | (_, Undef) => Undef,
                (left, right) => KleeneTruth::of(left == right),
            }),
        }
    }

    /// Compiles `=`. Comparing a location with a constant, the most frequent guard, reads the value
    /// in place.
    fn equal(&self, left: &Term, right: &Term) -> TruthCode {
        match (&*left.node, &*right.node) {
            (TermNode::Slot(function, slot), TermNode::Constant(value))
            | (TermNode::Constant(value), TermNode::Slot(function, slot))
                if !self.is_input(*function) =>
            {
                let (slot, value) = (*slot as usize, value.clone());
                Box::new(move |run| KleeneTruth::of(run.state.store.slots[slot] == value))
            }
            (_, TermNode::Constant(value)) => {
                let value = value.clone();
                if let Some(slot) = self.stored(left) {
                    return Box::new(move |run| {
                        let slot = slot(run) as usize;
                        KleeneTruth::of(run.state.store.slots[slot] == value)
                    });
                }
                let left = self.term(left);
                Box::new(move |run| KleeneTruth::of(left(run) == value))
            }
            _ if left.kind == ValueKind::Int && right.kind == ValueKind::Int => {
                let (left, right) = (self.integer(left), self.integer(right));
                Box::new(move |run| KleeneTruth::of(left.get(run) == right.get(run)))
            }
            _ => {
                let (left, right) = (self.term(left), self.term(right));
                Box::new(move |run| {
                    let left = left(run);
                    KleeneTruth::of(left == right(run))
                })
            }
        }
    }

    fn compare(&self, comparison: Comparison, left: &Term, right: &Term) -> TruthCode {
        let (left, right) = (self.integer(left), self.integer(right));
        macro_rules! compared {
            ($operator:tt) => {
                Box::new(move |run| match (left.get(run), right.get(run)) {
                    (Some(left), Some(right)) => KleeneTruth::of(left $operator right),
                    _ => KleeneTruth::Undef,
                })
            };
        }
        match comparison {
            Comparison::Lt => compared!(<),
            Comparison::Le => compared!(<=),
            Comparison::Gt => compared!(>),
            Comparison::Ge => compared!(>=),
        }
    }

    /// Compiles a strong Kleene quantifier: an undef guard makes the result undef unless another
    /// assignment decides it.
    fn quantified(&self, quantifier: Quantifier, ranges: Ranges) -> TruthCode {
        let decided_by = match quantifier {
            Quantifier::Forall => KleeneTruth::False,
            Quantifier::Exists | Quantifier::ExistsUnique => KleeneTruth::True,
        };
        let enough = if quantifier == Quantifier::ExistsUnique {
            2
        } else {
            1
        };
        Box::new(move |run| {
            let mut found = 0;
            let mut open = false;
            ranges.each_guard(run, &mut |_, truth| {
                open |= truth == KleeneTruth::Undef;
                found += usize::from(truth == decided_by);
                if found >= enough {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
            match (quantifier, found) {
                (Quantifier::Forall, 0)
                | (Quantifier::Exists | Quantifier::ExistsUnique, 0)
                | (Quantifier::ExistsUnique, 1)
                    if open =>
                {
                    KleeneTruth::Undef
                }
                (Quantifier::Forall, found) => KleeneTruth::of(found == 0),
                (Quantifier::Exists, found) => KleeneTruth::of(found > 0),
                (Quantifier::ExistsUnique, found) => KleeneTruth::of(found == 1),
            }
        })
    }
}
