//! Compilation of recorded terms and rules for a [`Witness`](crate::Witness). Such code repeats a
//! failed step and never runs otherwise.

use super::Compiler;
use crate::run::code::{RuleCode, TermCode};
use asmotion_ir::{Rule, RuleNode, Term, TermNode};

impl Compiler<'_> {
    pub(super) fn watched_term(&self, term: &Term) -> TermCode {
        let (origin, code) = (term.origin, self.term(term));
        let calls = matches!(&*term.node, TermNode::Call(..));
        Box::new(move |run| {
            if let Some(notes) = run.notes.as_mut().filter(|_| calls) {
                notes.enter(origin, true);
            }
            let value = code(run);
            if run.fault.is_none()
                && let Some(notes) = run.notes
            {
                if calls {
                    notes.leave();
                }
                notes.read(origin, &value);
            }
            value
        })
    }

    pub(super) fn watched_rule(&self, rule: &Rule) -> RuleCode {
        let (origin, code) = (rule.origin, self.rule(rule));
        let calls = match &*rule.node {
            RuleNode::Assign(..)
            | RuleNode::Call(..)
            | RuleNode::Run(..)
            | RuleNode::RunAgent(..) => true,
            RuleNode::Skip
            | RuleNode::Update(..)
            | RuleNode::Par(_)
            | RuleNode::Seq(_)
            | RuleNode::If(..)
            | RuleNode::Switch(..)
            | RuleNode::Choose(..)
            | RuleNode::Forall(..)
            | RuleNode::Let(..)
            | RuleNode::Extend(..)
            | RuleNode::While { .. }
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..)
            | RuleNode::Watched(_)
            | RuleNode::Counted(..) => false,
        };
        Box::new(move |run| {
            if let Some(notes) = run.notes {
                notes.enter(origin, calls);
            }
            code(run)?;
            if let Some(notes) = run.notes {
                if let Some(update) = run.updates.list.last() {
                    notes.record_update(update);
                }
                notes.leave();
            }
            Ok(())
        })
    }
}
