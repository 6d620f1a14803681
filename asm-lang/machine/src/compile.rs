//! Compilation to closures: each node becomes a closure that captures those of its parts.
//!
//! Closures support every construct on every processor and define the meaning of a step. Native
//! code ([`crate::back_end`]) covers part of them at higher speed.

mod collection;
mod counted;
mod indexed;
mod location;
mod number;
mod pick;
mod range;
mod rule;
mod term;
mod truth;
mod watched;

use crate::packed::Layout;
use crate::run::StepContext;
use crate::run::code::{Compiled, CompiledProgram, TermCode};
use crate::watch::{watched_rule, watched_term};
use asmotion_ir::{DomainId, Local, Program, Rule, SlotAxis, Term};
use std::borrow::Cow;
use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

impl CompiledProgram {
    pub fn of(program: &Program) -> Self {
        Self::compiled(
            program,
            |term| Cow::Borrowed(term),
            |rule| Cow::Borrowed(rule),
        )
    }

    /// Compiles a program with recording of every read and every rule.
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
        let (bodies, routines) = (bodies.collect(), routines.collect());
        Self {
            bodies,
            routines,
            supers: supers.collect(),
            layout: Layout::of(program),
            native: OnceLock::new(),
            direct: OnceLock::new(),
            is_compiling: [const { AtomicBool::new(false) }; 2],
            rules: compiler.rules.get(),
        }
    }
}

/// Terms that are evaluated together, such as arguments.
struct Values(Vec<TermCode>);

impl Values {
    /// Evaluates the terms and pushes their values on the stack; returns the index of the first.
    fn push_all(&self, run: &mut StepContext<'_>) -> usize {
        let from = run.stack.len();
        for term in &self.0 {
            let value = term(run);
            run.stack.push(value);
        }
        from
    }

    /// Evaluates the terms and appends their values to the locals, as arguments of a call; returns
    /// the index of the first.
    fn pass_arguments(&self, run: &mut StepContext<'_>) -> usize {
        let from = run.locals.len();
        for term in &self.0 {
            let value = term(run);
            run.locals.push(value);
        }
        from
    }
}

/// Variables and the terms they are bound to, evaluated in order.
struct LocalBindings(Vec<(Local, TermCode)>);

impl LocalBindings {
    fn bind(&self, run: &mut StepContext<'_>) {
        for (local, term) in &self.0 {
            let value = term(run);
            run.set_local(*local, value);
        }
    }
}

/// Compiles terms and rules of a program to closures.
pub struct Compiler<'a> {
    program: &'a Program,
    /// Number of rules compiled so far.
    rules: Cell<u64>,
    /// The window of each function, indexed by function; `None` if it has none.
    windows: Vec<Option<(usize, Vec<SlotAxis>)>>,
}

impl<'a> Compiler<'a> {
    /// Creates a compiler for terms and rules of this program.
    pub fn of(program: &'a Program) -> Self {
        Self {
            program,
            rules: Cell::new(0),
            windows: crate::windows::windows(program),
        }
    }

    fn terms(&self, terms: &[Term]) -> Vec<TermCode> {
        terms.iter().map(|term| self.term(term)).collect()
    }

    fn values(&self, terms: &[Term]) -> Values {
        Values(self.terms(terms))
    }

    fn bindings(&self, bindings: &[(Local, Term)]) -> LocalBindings {
        let bindings = bindings
            .iter()
            .map(|(local, term)| (*local, self.term(term)));
        LocalBindings(bindings.collect())
    }
}
