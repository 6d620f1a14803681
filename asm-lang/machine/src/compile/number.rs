//! Compilation of integer terms without intermediate [`Value`]s, used for arithmetic.

use super::Compiler;
use crate::fault::FaultKind;
use crate::run::{KleeneTruth, StepContext};
use asmotion_ir::{Arithmetic, Local, Origin, Term, TermNode};
use asmotion_value::Value;

/// Code that returns an integer, or `None` for undef.
type IntCode = Box<dyn Fn(&mut StepContext<'_>) -> Option<i64> + Send + Sync>;

/// An integer operand. The most frequent kinds need no closure of their own.
pub(super) enum IntTerm {
    Constant(i64),
    Local(Local),
    Slot(usize),
    Code(IntCode),
}

impl IntTerm {
    #[inline]
    pub fn get(&self, run: &mut StepContext<'_>) -> Option<i64> {
        match self {
            Self::Constant(number) => Some(*number),
            Self::Local(local) => as_integer(run.local(*local)),
            Self::Slot(slot) => as_integer(&run.state.store.slots[*slot]),
            Self::Code(code) => code(run),
        }
    }
}

impl Compiler<'_> {
    /// Compiles a term of type Integer.
    pub(super) fn integer(&self, term: &Term) -> IntTerm {
        match &*term.node {
            TermNode::Constant(Value::Int(number)) => IntTerm::Constant(*number),
            TermNode::Local(local) => IntTerm::Local(*local),
            TermNode::Slot(function, slot) if !self.is_input(*function) => {
                IntTerm::Slot(*slot as usize)
            }
            TermNode::Arithmetic(arithmetic, left, right) => {
                IntTerm::Code(self.arithmetic(*arithmetic, left, right, term.origin))
            }
            TermNode::If(guard, then, otherwise) => {
                let origin = guard.origin;
                let (guard, then, otherwise) = (
                    self.truth(guard),
                    self.integer(then),
                    self.integer(otherwise),
                );
                IntTerm::Code(Box::new(move |run| match guard(run) {
                    KleeneTruth::True => then.get(run),
                    KleeneTruth::False => otherwise.get(run),
                    KleeneTruth::Undef => {
                        run.fail(FaultKind::UndefinedGuard, origin);
                        None
                    }
                }))
            }
            TermNode::Constant(_)
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
            | TermNode::Tuple(_)
            | TermNode::Component(..)
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
            | TermNode::Named(..) => IntTerm::Code(match self.stored(term) {
                Some(slot) => Box::new(move |run| {
                    let slot = slot(run) as usize;
                    as_integer(&run.state.store.slots[slot])
                }),
                None => {
                    let code = self.term(term);
                    Box::new(move |run| as_integer(&code(run)))
                }
            }),
        }
    }

    fn arithmetic(
        &self,
        arithmetic: Arithmetic,
        left: &Term,
        right: &Term,
        origin: Origin,
    ) -> IntCode {
        let (left, right) = (self.integer(left), self.integer(right));
        match arithmetic {
            Arithmetic::Plus => computed(left, right, origin, asmotion_stdlib::integer::plus),
            Arithmetic::Minus => computed(left, right, origin, asmotion_stdlib::integer::minus),
            Arithmetic::Mult => computed(left, right, origin, asmotion_stdlib::integer::mult),
            Arithmetic::Mod => computed(left, right, origin, asmotion_stdlib::integer::modulo),
        }
    }
}

/// Compiles an operation on two integers. Each combination of operands gets a closure of its own,
/// which avoids indirect calls.
fn computed(
    left: IntTerm,
    right: IntTerm,
    origin: Origin,
    operation: impl Fn(i64, i64) -> Result<i64, asmotion_stdlib::BuiltinFault> + Send + Sync + 'static,
) -> IntCode {
    Box::new(move |run| {
        let (left, right) = (left.get(run)?, right.get(run)?);
        match operation(left, right) {
            Ok(number) => Some(number),
            Err(fault) => {
                run.fail(FaultKind::Library(fault), origin);
                None
            }
        }
    })
}

#[inline]
fn as_integer(value: &Value) -> Option<i64> {
    if let Value::Int(number) = value {
        Some(*number)
    } else {
        None
    }
}
