//! Sessions: a specification and its machine, with evaluation of terms and rules from outside.
//!
//! Scenarios, the prompt and watch expressions use the same mechanism: a text is parsed, resolved
//! in the scope of the main file, added to the program, and evaluated in the current state.
//!
//! ```
//! # let mut files = asmotion_lang::MemoryFiles::new();
//! # files.add("counter.asm", "asm counter
//! # import StandardLibrary
//! # signature:
//! #   controlled n: Integer
//! # definitions:
//! #   main rule r_Main = n := n + 1
//! # default init s0:
//! #   function n = 0
//! # ");
//! use asmotion_lang::{FirstChoice, NoInputs, Session, Value};
//! let specification = asmotion_lang::open("counter.asm", &files).map_err(|failure| failure.to_string())?;
//! let mut session = Session::new(specification).map_err(|failure| failure.to_string())?;
//! let next = session.watch("n + 1").map_err(|report| format!("{report:?}"))?;
//! session.fire("n := 41", &mut NoInputs, &mut FirstChoice, 0).map_err(|report| format!("{report:?}"))?;
//! let value = session.value(next, &mut NoInputs, 0).map_err(|report| format!("{report:?}"))?;
//! assert_eq!(value, Value::Int(42));
//! # Ok::<(), String>(())
//! ```

use crate::specification::{OpenFailure, Specification};
use asmotion_diagnostics::{FileId, Report};
use asmotion_hir::AddedTerm;
use asmotion_machine::{Chooser, Environment, Machine, Step, StepFault};
use asmotion_value::Value;

/// A running specification that evaluates terms and rules from outside.
pub struct Session {
    /// The specification, to which evaluated texts are added.
    pub specification: Specification,
    /// The machine in its current state.
    pub machine: Machine,
    /// Number of texts evaluated so far, for their names in diagnostics.
    texts: u32,
}

impl Session {
    /// Creates a machine in the initial state.
    ///
    /// # Errors
    /// An initial value cannot be computed, or the initial state violates an invariant.
    pub fn new(specification: Specification) -> Result<Self, OpenFailure> {
        match specification.machine() {
            Ok(machine) => Ok(Self {
                specification,
                machine,
                texts: 0,
            }),
            Err(fault) => {
                let mut report = Report::new();
                report.push(specification.explain(&fault));
                Err(OpenFailure {
                    sources: specification.sources,
                    report,
                })
            }
        }
    }

    /// Adds a term for repeated evaluation.
    ///
    /// # Errors
    /// The text is not a term, or it does not fit the specification.
    pub fn watch(&mut self, text: &str) -> Result<AddedTerm, Report> {
        let file = self.text(text);
        let term = asmotion_syntax::parse_term(file, text)?;
        let added = self.specification.model.add_term(&term)?;
        self.adopt()?;
        Ok(added)
    }

    /// Evaluates a watched term in the current state.
    ///
    /// # Errors
    /// The evaluation fails.
    pub fn value(
        &mut self,
        term: AddedTerm,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<Value, Report> {
        let value = self.machine.evaluate(term, environment, now_ns);
        value.map_err(|fault| self.report(&fault))
    }

    /// Evaluates a term in the current state.
    ///
    /// # Errors
    /// The text is not a term, it does not fit the specification, or its evaluation fails.
    pub fn evaluate(
        &mut self,
        text: &str,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<Value, Report> {
        self.with_temporary(|session| {
            let term = session.watch(text)?;
            session.value(term, environment, now_ns)
        })
    }

    /// Fires a rule in the current state. This is not a step, and invariants are not checked before
    /// the next one.
    ///
    /// # Errors
    /// The text is not a rule, it does not fit the specification, or the rule fails. The state is
    /// unchanged.
    pub fn fire(
        &mut self,
        text: &str,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<Step<'_>, Report> {
        self.with_temporary(|session| {
            let file = session.text(text);
            let rule = asmotion_syntax::parse_rule(file, text)?;
            let added = session.specification.model.add_rule(&rule)?;
            session.adopt()?;
            let fired = session.machine.fire(added, environment, chooser, now_ns);
            match fired.map(|_| ()) {
                Ok(()) => Ok(()),
                Err(fault) => Err(session.report(&fault)),
            }
        })?;
        Ok(self.machine.last_step())
    }

    /// Parses `location := term`, where the location may be monitored, and evaluates both sides.
    /// Returns the function, its arguments and the value. The caller performs the assignment:
    /// [`Machine::set`] updates a location that is not monitored.
    ///
    /// # Errors
    /// The text is not an assignment, it does not fit the specification, or an evaluation fails.
    pub fn assignment(
        &mut self,
        text: &str,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(asmotion_ir::FunctionId, Vec<Value>, Value), Report> {
        self.with_temporary(|session| {
            let file = session.text(text);
            let (target, value) = asmotion_syntax::parse_assignment(file, text)?;
            let assignment = session
                .specification
                .model
                .add_assignment(&target, &value)?;
            session.adopt()?;
            let found = session.machine.assigned(&assignment, environment, now_ns);
            found.map_err(|fault| session.report(&fault))
        })
    }

    /// Enables coverage counters: see [`Specification::calls`].
    ///
    /// # Errors
    /// The program cannot be lowered again; it is unchanged.
    pub fn count(&mut self) -> Result<(), Report> {
        self.specification.lower_covered()?;
        self.go_on();
        Ok(())
    }

    /// Runs `work`, then removes the terms and rules that it added.
    fn with_temporary<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, Report>,
    ) -> Result<T, Report> {
        let added = &self.specification.model.added;
        let (terms, rules) = (added.terms.len(), added.rules.len());
        let result = work(self);
        self.specification.model.forget_added(terms, rules);
        result
    }

    fn text(&mut self, text: &str) -> FileId {
        self.texts += 1;
        let path = format!("<input {}>", self.texts);
        self.specification.sources.add(&path, text)
    }

    /// Lowers the additions and lets the machine continue with the new program.
    fn adopt(&mut self) -> Result<(), Report> {
        self.specification.lower()?;
        self.go_on();
        Ok(())
    }

    /// Lets the machine continue with the program lowered last.
    fn go_on(&mut self) {
        // cannot fail: only terms, rules and counters were added, so the locations are the same
        let _ = self
            .machine
            .replace_program(self.specification.program.clone());
    }

    fn report(&self, fault: &StepFault) -> Report {
        let mut report = Report::new();
        report.push(self.specification.explain_in(fault, &self.machine));
        report
    }
}
