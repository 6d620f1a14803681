//! Conditions of watched formulas, evaluated when what they read has changed.

use asmotion_lang::hir::{self, FunctionKind, Meaning, Model, Term};
use asmotion_lang::ir::{AddedTerm, FunctionId};
use asmotion_lang::{Environment, Machine, Value};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A condition that the formulas of a specification contain.
#[derive(Clone, Debug)]
pub(super) struct WatchedCondition {
    pub term: AddedTerm,
    pub text: Arc<str>,
    /// Its value depends on the inputs of a step.
    pub reads_inputs: bool,
    /// It depends on something else than locations: the time, or the machine itself.
    pub is_volatile: bool,
    /// The functions whose locations it reads.
    pub functions: Arc<BTreeSet<FunctionId>>,
    /// Its value has to be determined again.
    pub is_stale: bool,
    /// Its value at the current position; undef counts as false.
    pub value: Option<bool>,
    /// Its value at the position before the last step.
    pub before: Option<bool>,
    /// The number of changes of conditions when it changed last.
    pub changed_at: u64,
}

impl WatchedCondition {
    /// Creates a condition, which has no value yet.
    pub fn new(model: &Model, term: AddedTerm, root: &Term, text: String) -> Self {
        let mut condition = Self {
            term,
            text: text.into(),
            reads_inputs: false,
            is_volatile: false,
            functions: Arc::default(),
            is_stale: true,
            value: None,
            before: None,
            changed_at: 0,
        };
        condition.add_reads(model, root);
        condition
    }

    /// Returns `true` if its value can have changed with the inputs of a step.
    pub fn is_due(&self, is_changed: &dyn Fn(FunctionId) -> bool) -> bool {
        self.is_stale
            || self.is_volatile
            || self.reads_inputs && self.functions.iter().any(|it| is_changed(*it))
    }

    /// Evaluates it in the current state. Undef, and an evaluation that fails, count as false, as in a verification.
    pub fn evaluate(
        &self,
        machine: &mut Machine,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> bool {
        machine.evaluate(self.term, environment, now_ns) == Ok(Value::Bool(true))
    }

    /// Sets its value. Returns 1 if that is a change, and otherwise 0; `changes` is the number of changes so far.
    pub fn assign(&mut self, value: bool, changes: u64) -> u64 {
        self.is_stale = false;
        if self.value == Some(value) {
            return 0;
        }
        (self.value, self.changed_at) = (Some(value), changes + 1);
        1
    }

    /// Adds the functions that a term reads, also in the definitions of others.
    fn add_reads(&mut self, model: &Model, term: &Term) {
        let mut applied = Vec::new();
        asmotion_lang::ir::visit_terms(term, &mut |part| applied.extend(part.kind.function()));
        for id in applied {
            if let Some(function) = model.functions.get(id.0 as usize)
                && Arc::make_mut(&mut self.functions).insert(FunctionId(id.0))
            {
                self.add_function(model, function);
            }
        }
    }

    fn add_function(&mut self, model: &Model, function: &hir::Function) {
        match function.kind {
            FunctionKind::Monitored | FunctionKind::Shared => self.reads_inputs = true,
            FunctionKind::Controlled
            | FunctionKind::Out
            | FunctionKind::Local
            | FunctionKind::Static
            | FunctionKind::Derived => {}
        }
        match &function.meaning {
            Meaning::Defined(body) => self.add_reads(model, &body.root),
            // the time of a step is one of its inputs; `self`, and the messages of agents, are part of the machine
            Meaning::Machine => (self.is_volatile, self.reads_inputs) = (true, true),
            Meaning::Builtin(builtin) if builtin.name.starts_with("currTime") => {
                (self.is_volatile, self.reads_inputs) = (true, true);
            }
            Meaning::State if function.library => self.is_volatile = true,
            Meaning::Builtin(_) | Meaning::State | Meaning::Constant(_) | Meaning::Missing => {}
        }
    }
}
