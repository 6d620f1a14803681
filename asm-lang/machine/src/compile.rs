//! A program compiled to closures: every node becomes a function of the run, its parts captured.
//!
//! This is one back end; another one would offer the same [`Code`]: bodies that give a value and
//! routines that collect updates, both over a [`Run`].

mod collection;
mod location;
mod number;
mod range;
mod rule;
mod term;
mod truth;

use crate::run::{Run, Stopped, Truth};
use ir::{DomainId, Origin, Program};
use value::Value;

/// Gives a value.
pub(crate) type TermCode = Box<dyn Fn(&mut Run<'_>) -> Value + Send + Sync>;
/// Gives a truth value.
pub(crate) type TruthCode = Box<dyn Fn(&mut Run<'_>) -> Truth + Send + Sync>;
/// Gives an integer, or undef.
pub(crate) type IntCode = Box<dyn Fn(&mut Run<'_>) -> Option<i64> + Send + Sync>;
/// Collects updates.
pub(crate) type RuleCode = Box<dyn Fn(&mut Run<'_>) -> Result<(), Stopped> + Send + Sync>;

/// Code with a frame of its own.
pub(crate) struct Compiled<T> {
    pub locals: u32,
    pub arguments: u32,
    pub code: T,
    pub origin: Origin,
}

/// A compiled program.
pub(crate) struct Code {
    pub bodies: Vec<Compiled<TermCode>>,
    pub routines: Vec<Compiled<RuleCode>>,
    /// For each domain the domains its elements belong to, beginning with itself.
    pub supers: Vec<Vec<DomainId>>,
}

impl Code {
    pub fn of(program: &Program) -> Self {
        let compiler = Compiler { program };
        let bodies = program.bodies.iter().map(|body| Compiled {
            locals: body.locals,
            arguments: body.arguments,
            code: compiler.term(&body.code),
            origin: body.origin,
        });
        let routines = program.routines.iter().map(|routine| Compiled {
            locals: routine.locals,
            arguments: routine.arguments,
            code: compiler.rule(&routine.code),
            origin: routine.origin,
        });
        let supers = (0..program.domains.len() as u32).map(|index| {
            let mut chain = vec![DomainId(index)];
            while let Some(base) = chain.last().and_then(|domain| program.domains[domain.0 as usize].base) {
                if chain.contains(&base) {
                    break;
                }
                chain.push(base);
            }
            chain
        });
        Self { bodies: bodies.collect(), routines: routines.collect(), supers: supers.collect() }
    }
}

struct Compiler<'a> {
    program: &'a Program,
}
