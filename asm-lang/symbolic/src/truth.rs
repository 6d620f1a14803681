//! Symbolic evaluation of conditions in strong Kleene logic.

use crate::bdd::{Bdd, BddStore};
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, MAX_COMBINATIONS};
use crate::fault::FaultClass;
use crate::guarded::Guarded;
use crate::term::many;
use asmotion_lang::Value;
use asmotion_lang::ir::{Binder, Comparison, Connective, Quantifier, Term, TermNode};

/// Sets of states in which a condition is true, false and undef; it has no value in others.
pub(crate) struct GuardedTruth {
    pub yes: Bdd,
    pub no: Bdd,
    pub undef: Bdd,
}

impl GuardedTruth {
    fn nowhere(store: &BddStore) -> Self {
        Self {
            yes: store.never(),
            no: store.never(),
            undef: store.never(),
        }
    }

    fn of(store: &BddStore, value: &Guarded) -> Result<Self, SymbolicError> {
        let mut truth = Self::nowhere(store);
        for (value, guard) in value.iter() {
            let place = if *value == Value::Bool(true) {
                &mut truth.yes
            } else if *value == Value::Bool(false) {
                &mut truth.no
            } else {
                &mut truth.undef
            };
            *place = store.or(place, guard)?;
        }
        Ok(truth)
    }

    /// Returns the values.
    pub fn value(&self, store: &BddStore) -> Result<Guarded, SymbolicError> {
        let mut value = Guarded::default();
        value.add(store, Value::Bool(true), &self.yes)?;
        value.add(store, Value::Bool(false), &self.no)?;
        value.add(store, Value::Undef, &self.undef)?;
        Ok(value)
    }

    fn negated(self) -> Self {
        Self {
            yes: self.no,
            no: self.yes,
            undef: self.undef,
        }
    }
}

impl Evaluator<'_> {
    /// Evaluates a condition.
    pub fn truth(&mut self, term: &Term, path: &Bdd) -> Result<GuardedTruth, SymbolicError> {
        if path.is_never() {
            return Ok(GuardedTruth::nowhere(self.store));
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.truth_here(term, path))
    }

    /// Evaluates the guard of a rule or of `if`, which must not be undef.
    pub fn guard(&mut self, term: &Term, path: &Bdd) -> Result<GuardedTruth, SymbolicError> {
        let truth = self.truth(term, path)?;
        self.fail(FaultClass::UndefinedGuard, term.origin, &truth.undef)?;
        Ok(truth)
    }

    fn truth_here(&mut self, term: &Term, path: &Bdd) -> Result<GuardedTruth, SymbolicError> {
        match &*term.node {
            TermNode::Logic(connective, left, right) => self.logic(*connective, left, right, path),
            TermNode::Not(operand) => Ok(self.truth(operand, path)?.negated()),
            TermNode::Equal(left, right) => self.equal(left, right, path),
            TermNode::Compare(comparison, left, right) => {
                self.compare(*comparison, left, right, path)
            }
            TermNode::Quantified(quantifier, binders, guard) => {
                self.quantified(*quantifier, binders, guard.as_ref(), path)
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
            | TermNode::If(..)
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
            | TermNode::Named(..) => {
                let value = self.term(term, path)?;
                GuardedTruth::of(self.store, &value)
            }
        }
    }

    /// The right operand is not evaluated where the left one decides.
    fn logic(
        &mut self,
        connective: Connective,
        left: &Term,
        right: &Term,
        path: &Bdd,
    ) -> Result<GuardedTruth, SymbolicError> {
        let store = self.store;
        let left = self.truth(left, path)?;
        // the values of the left operand with which `and` and the other connectives coincide
        let (decided, open) = match connective {
            Connective::And => (&left.no, &left.yes),
            Connective::Or => (&left.yes, &left.no),
            Connective::Implies => (&left.no, &left.yes),
            Connective::Xor | Connective::Iff => {
                let both = store.or(&left.yes, &left.no)?;
                let all = store.or(&both, &left.undef)?;
                let right = self.truth(right, &all)?;
                let equal = store.or(
                    &store.and(&left.yes, &right.yes)?,
                    &store.and(&left.no, &right.no)?,
                )?;
                let different = store.or(
                    &store.and(&left.yes, &right.no)?,
                    &store.and(&left.no, &right.yes)?,
                )?;
                let undef = store.or(
                    &right.undef,
                    &store.and(&left.undef, &store.or(&right.yes, &right.no)?)?,
                )?;
                let truth = GuardedTruth {
                    yes: equal,
                    no: different,
                    undef,
                };
                return Ok(match connective {
                    Connective::Xor => truth.negated(),
                    Connective::Iff | Connective::And | Connective::Or | Connective::Implies => {
                        truth
                    }
                });
            }
        };
        let rest = store.or(open, &left.undef)?;
        let right = self.truth(right, &rest)?;
        // undef and a deciding right operand is decided, undef and any other is undef
        let (deciding, other) = match connective {
            Connective::And => (&right.no, &right.yes),
            Connective::Or | Connective::Implies | Connective::Xor | Connective::Iff => {
                (&right.yes, &right.no)
            }
        };
        let unknown = store.and(&left.undef, &store.or(other, &right.undef)?)?;
        let undef = store.or(&store.and(open, &right.undef)?, &unknown)?;
        let result_decided = store.or(decided, deciding)?;
        let result_other = store.and(open, other)?;
        Ok(match connective {
            Connective::And => GuardedTruth {
                yes: result_other,
                no: result_decided,
                undef,
            },
            Connective::Or | Connective::Implies | Connective::Xor | Connective::Iff => {
                GuardedTruth {
                    yes: result_decided,
                    no: result_other,
                    undef,
                }
            }
        })
    }

    fn equal(
        &mut self,
        left: &Term,
        right: &Term,
        path: &Bdd,
    ) -> Result<GuardedTruth, SymbolicError> {
        let store = self.store;
        let left = self.term(left, path)?;
        let path = self.alive(path)?;
        let right = self.term(right, &path)?;
        let defined = store.and(&left.defined(store)?, &right.defined(store)?)?;
        let mut yes = store.never();
        for (value, guard) in left.iter() {
            if let Some(same) = right.get(value) {
                yes = store.or(&yes, &store.and(guard, same)?)?;
            }
        }
        let no = store.without(&defined, &yes)?;
        Ok(GuardedTruth {
            yes,
            no,
            undef: store.never(),
        })
    }

    fn compare(
        &mut self,
        comparison: Comparison,
        left: &Term,
        right: &Term,
        path: &Bdd,
    ) -> Result<GuardedTruth, SymbolicError> {
        let store = self.store;
        let origin = left.origin;
        let left = self.term(left, path)?;
        let path = self.alive(path)?;
        let right = self.term(right, &path)?;
        if left.len() * right.len() > MAX_COMBINATIONS {
            return Err(many(origin));
        }
        let mut truth = GuardedTruth::nowhere(store);
        for (first, guard) in left.iter() {
            for (second, condition) in right.iter() {
                let both = store.and(guard, condition)?;
                if both.is_never() {
                    continue;
                }
                let place = match (first, second) {
                    (Value::Int(first), Value::Int(second)) => {
                        let holds = match comparison {
                            Comparison::Lt => first < second,
                            Comparison::Le => first <= second,
                            Comparison::Gt => first > second,
                            Comparison::Ge => first >= second,
                        };
                        if holds { &mut truth.yes } else { &mut truth.no }
                    }
                    _ => &mut truth.undef,
                };
                *place = store.or(place, &both)?;
            }
        }
        Ok(truth)
    }

    /// An undef guard makes the result undef unless another assignment decides it.
    fn quantified(
        &mut self,
        quantifier: Quantifier,
        binders: &[Binder],
        guard: Option<&Term>,
        path: &Bdd,
    ) -> Result<GuardedTruth, SymbolicError> {
        let store = self.store;
        let mut open = store.never();
        let mut once = store.never();
        let mut decided = store.never();
        let rest = self.each(binders, path, &mut |it, path| {
            let truth = match guard {
                Some(guard) => it.truth(guard, path)?,
                None => GuardedTruth {
                    yes: path.clone(),
                    no: store.never(),
                    undef: store.never(),
                },
            };
            open = store.or(&open, &truth.undef)?;
            let (found, other) = match quantifier {
                Quantifier::Forall => (&truth.no, &truth.yes),
                Quantifier::Exists | Quantifier::ExistsUnique => (&truth.yes, &truth.no),
            };
            let others = store.or(other, &truth.undef)?;
            if quantifier != Quantifier::ExistsUnique {
                decided = store.or(&decided, found)?;
                return Ok(others);
            }
            let twice = store.and(&once, found)?;
            decided = store.or(&decided, &twice)?;
            once = store.or(&once, found)?;
            store.or(&others, &store.without(found, &twice)?)
        })?;
        let undef = store.and(&rest, &open)?;
        let rest = store.without(&rest, &open)?;
        Ok(match quantifier {
            Quantifier::Forall => GuardedTruth {
                yes: rest,
                no: decided,
                undef,
            },
            Quantifier::Exists => GuardedTruth {
                yes: decided,
                no: rest,
                undef,
            },
            Quantifier::ExistsUnique => GuardedTruth {
                yes: store.and(&rest, &once)?,
                no: store.or(&decided, &store.without(&rest, &once)?)?,
                undef,
            },
        })
    }
}
