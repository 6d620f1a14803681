//! Invariants, checked while a step runs.

use crate::choose::FirstChoice;
use crate::environment::Environment;
use crate::fault::{FaultKind, StepFault};
use crate::machine::Machine;
use crate::run::{KleeneTruth, RuleStopped, StepContext};
use asmotion_ir::Invariant;

impl Machine {
    /// Checks the constraints (`INVAR`) that read inputs, with inputs for the next step, which is not executed.
    ///
    /// The inputs of the first step become part of the initial state where it depends on them, as in [`Machine::step`].
    ///
    /// # Errors
    /// A constraint is false or undef, or its evaluation fails. The last step is then a failed one with these inputs.
    pub fn check_constraints(
        &mut self,
        environment: &mut dyn Environment,
        now_ns: i64,
    ) -> Result<(), Box<StepFault>> {
        self.collect(false, environment, &mut FirstChoice, now_ns, |run| {
            run.check_each_invariant(|it| it.is_constraint)
        })
    }
}

impl StepContext<'_> {
    /// Checks the invariants that are assumptions about inputs, or else all others.
    #[inline]
    pub(crate) fn check_invariants(&mut self, assumptions: bool) -> Result<(), RuleStopped> {
        if self.program.invariants.is_empty() {
            Ok(())
        } else {
            self.check_each_invariant(|it| it.assumes == assumptions)
        }
    }

    fn check_each_invariant(
        &mut self,
        is_checked: impl Fn(&Invariant) -> bool,
    ) -> Result<(), RuleStopped> {
        let program = self.program;
        for (index, invariant) in program.invariants.iter().enumerate() {
            if !is_checked(invariant) {
                continue;
            }
            let from = self.locals.len();
            let value = self.call_body(invariant.body, from);
            self.checked()?;
            if KleeneTruth::from_value(&value) != KleeneTruth::True {
                return Err(self.stop(FaultKind::Invariant { index, value }, invariant.origin));
            }
        }
        Ok(())
    }
}
