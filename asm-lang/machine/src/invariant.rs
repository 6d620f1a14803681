//! Invariants, checked while a step runs.

use crate::fault::FaultKind;
use crate::run::{KleeneTruth, RuleStopped, StepContext};

impl StepContext<'_> {
    /// Checks the invariants that are assumptions about inputs, or else all others.
    #[inline]
    pub(crate) fn check_invariants(&mut self, assumptions: bool) -> Result<(), RuleStopped> {
        if self.program.invariants.is_empty() {
            Ok(())
        } else {
            self.check_each_invariant(assumptions)
        }
    }

    fn check_each_invariant(&mut self, assumptions: bool) -> Result<(), RuleStopped> {
        let program = self.program;
        for (index, invariant) in program.invariants.iter().enumerate() {
            if invariant.assumes != assumptions {
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
