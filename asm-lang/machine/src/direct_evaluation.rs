//! Steps evaluated by a direct rule, and steps evaluated without applying them.

use crate::choose::Chooser;
use crate::direct::{DirectResult, DirectStep, RepeatedChoices};
use crate::environment::Environment;
use crate::fault::StepFault;
use crate::machine::Machine;
use crate::updates::Update;

impl Machine {
    /// Evaluates the rules of the next step without applying their updates: the state remains as it is, and so does the
    /// number of steps. Requires [`Machine::can_revert`]. Returns the updates; [`Machine::last_step`] has the rest of the
    /// record, without previous values. Invariants of the next state are not checked.
    ///
    /// Elements created by `extend` do not exist after the evaluation. Where [`crate::Step::extended`] is not empty, a step
    /// is necessary to reach the next state.
    ///
    /// # Errors
    /// The step has no next state.
    pub fn evaluate_step(
        &mut self,
        environment: &mut dyn Environment,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> Result<&[Update], Box<StepFault>> {
        let is_direct = self.direct.is_ready || self.is_direct();
        if is_direct && self.collects_directly(false, chooser, now_ns) {
            return Ok(&self.scratch.updates.list);
        }
        let is_native = self.is_native();
        let choices = &mut self.repeating(chooser);
        self.collect(true, environment, choices, now_ns, |run| {
            run.main_rule(is_native)
        })?;
        let (_, reserve) = self.scratch.begun_at;
        if self.state.store.reserve.len() > reserve {
            // locations of the new elements are forgotten before the next evaluation
            self.state.store.reserve.truncate(reserve);
        } else {
            // accessed locations have no influence on later steps
            self.state.commit();
        }
        Ok(&self.scratch.updates.list)
    }

    /// Collects the updates of a step directly and applies them if `applies` is set. Returns `false` if the rule gave up.
    #[inline(always)]
    pub(crate) fn collects_directly(
        &mut self,
        applies: bool,
        chooser: &mut dyn Chooser,
        now_ns: i64,
    ) -> bool {
        let Some(Some(rule)) = self.code.direct.get() else {
            return false;
        };
        self.direct.tried += 1;
        let scratch = &mut self.scratch;
        if scratch.is_direct {
            scratch.begin_again(self.steps, now_ns);
        } else {
            scratch.begin_directly(self.steps, &mut self.state, now_ns);
        }
        if !self.program.counted.is_empty() {
            scratch.save_counts(self.program.counted.len());
        }
        let mut step = DirectStep {
            state: &mut self.state,
            scratch,
            chooser,
            applies,
        };
        match rule.collect(&mut step) {
            DirectResult::Scalars => true,
            DirectResult::Values => {
                self.scratch.forbid_shortcuts();
                true
            }
            DirectResult::GaveUp => {
                self.give_up();
                false
            }
        }
    }

    #[cold]
    fn give_up(&mut self) {
        self.direct.miss();
        self.scratch.is_direct = false;
        if !self.program.counted.is_empty() {
            std::mem::swap(
                &mut self.scratch.record.counts,
                &mut self.scratch.counts_before,
            );
        }
        self.scratch.missed = std::mem::take(&mut self.scratch.record.choices);
    }

    /// Returns a chooser that first repeats the choices of a direct rule that gave up.
    #[inline]
    pub(crate) fn repeating<'c>(&mut self, chooser: &'c mut dyn Chooser) -> RepeatedChoices<'c> {
        RepeatedChoices {
            made: std::mem::take(&mut self.scratch.missed),
            next: 0,
            chooser,
        }
    }
}
