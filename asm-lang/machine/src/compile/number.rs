//! Terms compiled to code that gives integers: arithmetic takes this way.

use super::{Compiler, IntCode};
use crate::fault::FaultKind;
use crate::run::Truth;
use ir::{Arithmetic, Node, Origin, Term};
use value::Value;

impl Compiler<'_> {
    /// A term as code that gives an integer.
    pub(super) fn integer(&self, term: &Term) -> IntCode {
        match &*term.node {
            Node::Constant(Value::Int(number)) => {
                let number = *number;
                Box::new(move |_| Some(number))
            }
            Node::Local(local) => {
                let local = *local;
                Box::new(move |run| as_integer(run.local(local)))
            }
            Node::Slot(function, slot) if !self.is_input(*function) => {
                let slot = *slot as usize;
                Box::new(move |run| as_integer(&run.state.slots[slot]))
            }
            Node::Arithmetic(arithmetic, left, right) => {
                self.arithmetic(*arithmetic, left, right, term.origin)
            }
            Node::If(guard, then, otherwise) => {
                let origin = guard.origin;
                let (guard, then, otherwise) = (self.truth(guard), self.integer(then), self.integer(otherwise));
                Box::new(move |run| match guard(run) {
                    Truth::True => then(run),
                    Truth::False => otherwise(run),
                    Truth::Undef => {
                        run.fail(FaultKind::UndefinedGuard, origin);
                        None
                    }
                })
            }
            _ => match self.stored(term) {
                Some(slot) => Box::new(move |run| {
                    let slot = slot(run) as usize;
                    as_integer(&run.state.slots[slot])
                }),
                None => {
                    let code = self.term(term);
                    Box::new(move |run| as_integer(&code(run)))
                }
            },
        }
    }

    fn arithmetic(&self, arithmetic: Arithmetic, left: &Term, right: &Term, origin: Origin) -> IntCode {
        let (left, right) = (self.integer(left), self.integer(right));
        let operation = match arithmetic {
            Arithmetic::Plus => stdlib::integer::plus,
            Arithmetic::Minus => stdlib::integer::minus,
            Arithmetic::Mult => stdlib::integer::mult,
            Arithmetic::Mod => stdlib::integer::modulo,
        };
        Box::new(move |run| {
            let (left, right) = (left(run)?, right(run)?);
            match operation(left, right) {
                Ok(number) => Some(number),
                Err(fault) => {
                    run.fail(FaultKind::Library(fault), origin);
                    None
                }
            }
        })
    }
}

fn as_integer(value: &Value) -> Option<i64> {
    match value {
        Value::Int(number) => Some(*number),
        _ => None,
    }
}
