//! Compilation of rules with a coverage counter.

use super::Compiler;
use crate::run::code::RuleCode;
use asmotion_ir::{Counter, Rule};

impl Compiler<'_> {
    pub(super) fn counted_rule(&self, counter: Counter, rule: &Rule) -> RuleCode {
        let code = self.rule(rule);
        match counter {
            Counter::Count(counter) => Box::new(move |run| {
                run.record.count(counter);
                code(run)
            }),
            Counter::Rounds { round, none } => Box::new(move |run| {
                let before = run.record.counted(round);
                code(run)?;
                let rounds = run.record.counted(round) - before;
                run.record.count(none + rounds.min(2) as u32);
                Ok(())
            }),
        }
    }
}
