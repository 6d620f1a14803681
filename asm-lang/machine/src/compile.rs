//! A program compiled to closures: every node becomes a function of the run, its parts captured.
//!
//! This is one back end; another one would offer the same [`Code`]: bodies that give a value and
//! routines that collect updates, both over a [`Run`].

mod collection;
mod counted;
mod location;
mod number;
mod pick;
mod range;
mod rule;
mod term;
mod truth;
mod watched;

pub(crate) use location::MAX_AXES;
pub(crate) use range::MAX_BINDINGS;
pub(crate) use rule::MAX_ITERATIONS;

use crate::native::Native;
use crate::run::{Run, Stopped, Truth};
use crate::witness::{watched_rule, watched_term};
use asmotion_ir::{Axis, DomainId, Local, Origin, Program, Rule, Term};
use asmotion_value::Value;
use std::borrow::Cow;
use std::sync::OnceLock;

/// Gives a value.
pub(crate) type TermCode = Box<dyn Fn(&mut Run<'_>) -> Value + Send + Sync>;
/// Gives a truth value.
pub(crate) type TruthCode = Box<dyn Fn(&mut Run<'_>) -> Truth + Send + Sync>;
/// Collects updates.
pub(crate) type RuleCode = Box<dyn Fn(&mut Run<'_>) -> Result<(), Stopped> + Send + Sync>;

/// Code with a frame of its own.
pub(crate) struct Compiled<T> {
    pub locals: u32,
    pub arguments: u32,
    pub code: T,
    pub origin: Origin,
    pub open: bool,
}

/// A compiled program.
pub(crate) struct Code {
    pub bodies: Vec<Compiled<TermCode>>,
    pub routines: Vec<Compiled<RuleCode>>,
    /// For each domain the domains its elements belong to, beginning with itself.
    pub supers: Vec<Vec<DomainId>>,
    /// The main rule as native code, once it was compiled; `None` within where that cannot be.
    pub native: OnceLock<Option<Native>>,
}

impl Code {
    pub fn of(program: &Program) -> Self {
        Self::compiled(
            program,
            |term| Cow::Borrowed(term),
            |rule| Cow::Borrowed(rule),
        )
    }

    /// Code in which every read and every rule is watched.
    pub fn watched(program: &Program) -> Self {
        Self::compiled(
            program,
            |term| Cow::Owned(watched_term(term.clone())),
            |rule| Cow::Owned(watched_rule(rule.clone())),
        )
    }

    fn compiled(
        program: &Program,
        term: impl Fn(&Term) -> Cow<'_, Term>,
        rule: impl Fn(&Rule) -> Cow<'_, Rule>,
    ) -> Self {
        let compiler = Compiler::of(program);
        let bodies = program.bodies.iter().map(|body| Compiled {
            locals: body.locals,
            arguments: body.arguments,
            code: compiler.term(&term(&body.code)),
            origin: body.origin,
            open: body.open,
        });
        let routines = program.routines.iter().map(|routine| Compiled {
            locals: routine.locals,
            arguments: routine.arguments,
            code: compiler.rule(&rule(&routine.code)),
            origin: routine.origin,
            open: routine.open,
        });
        let supers = (0..program.domains.len() as u32).map(|index| {
            let mut chain = vec![DomainId(index)];
            while let Some(base) = chain
                .last()
                .and_then(|domain| program.domains[domain.0 as usize].base)
            {
                if chain.contains(&base) {
                    break;
                }
                chain.push(base);
            }
            chain
        });
        Self {
            bodies: bodies.collect(),
            routines: routines.collect(),
            supers: supers.collect(),
            native: OnceLock::new(),
        }
    }
}

/// Terms whose values go somewhere together.
struct Values(Vec<TermCode>);

impl Values {
    /// Puts the values on the stack; gives where they begin.
    fn stacked(&self, run: &mut Run<'_>) -> usize {
        let from = run.stack.len();
        for term in &self.0 {
            let value = term(run);
            run.stack.push(value);
        }
        from
    }

    /// Puts the values behind the locals, as the arguments of a call; gives where they begin.
    fn passed(&self, run: &mut Run<'_>) -> usize {
        let from = run.locals.len();
        for term in &self.0 {
            let value = term(run);
            run.locals.push(value);
        }
        from
    }
}

/// Variables and the terms they are bound to, one after the other.
struct Bindings(Vec<(Local, TermCode)>);

impl Bindings {
    fn bind(&self, run: &mut Run<'_>) {
        for (local, term) in &self.0 {
            let value = term(run);
            run.set_local(*local, value);
        }
    }
}

pub(crate) struct Compiler<'a> {
    program: &'a Program,
    /// By function: its window, if it has one.
    windows: Vec<Option<(usize, Vec<Axis>)>>,
}

impl<'a> Compiler<'a> {
    pub fn of(program: &'a Program) -> Self {
        Self {
            program,
            windows: crate::near::windows(program),
        }
    }

    fn terms(&self, terms: &[Term]) -> Vec<TermCode> {
        terms.iter().map(|term| self.term(term)).collect()
    }

    fn values(&self, terms: &[Term]) -> Values {
        Values(self.terms(terms))
    }

    fn bindings(&self, bindings: &[(Local, Term)]) -> Bindings {
        let bindings = bindings
            .iter()
            .map(|(local, term)| (*local, self.term(term)));
        Bindings(bindings.collect())
    }
}
