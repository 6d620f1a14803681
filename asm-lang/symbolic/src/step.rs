//! The steps of a program, as alternatives that each change few locations.

use crate::bdd::Bdd;
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, Layer, MadeChoice, values};
use crate::guarded::Guarded;
use asmotion_lang::ir::{Rule, RuleNode, Slot};
use std::collections::BTreeMap;

/// Limit for the alternatives of a step; further choices are expressed by variables.
const MAX_ALTERNATIVES: usize = 2000;

/// A part of the steps: those with some of the choices, and under some conditions.
pub(crate) struct Alternative {
    /// The condition under which it is a step.
    pub path: Bdd,
    pub updates: BTreeMap<Slot, Guarded>,
    pub reads: BTreeMap<usize, Bdd>,
    pub choices: Vec<MadeChoice>,
}

impl Evaluator<'_> {
    /// Evaluates a main rule. The alternatives of its first choices and conditions are evaluated one by one.
    pub fn alternatives(
        &mut self,
        rule: &Rule,
        path: &Bdd,
        to: &mut Vec<Alternative>,
    ) -> Result<(), SymbolicError> {
        let path = self.alive(path)?;
        if path.is_never() {
            return Ok(());
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
            self.alternatives_here(rule, &path, to)
        })
    }

    fn alternatives_here(
        &mut self,
        rule: &Rule,
        path: &Bdd,
        to: &mut Vec<Alternative>,
    ) -> Result<(), SymbolicError> {
        let is_split = to.len() < MAX_ALTERNATIVES;
        match &*rule.node {
            RuleNode::Choose(binders, guard, body, ifnone) if is_split => {
                let (candidates, none) = self.candidates((binders, guard.as_ref()), path)?;
                for (locals, guard) in candidates {
                    let before = (self.stopped.clone(), self.reads.clone());
                    for (local, value) in locals {
                        self.set_local(local, value);
                    }
                    self.alternatives(body, &guard, to)?;
                    (self.stopped, self.reads) = before;
                }
                self.alternatives(ifnone, &none, to)
            }
            RuleNode::If(guard, then, otherwise) if is_split => {
                let truth = self.guard(guard, path)?;
                let reads = self.reads.clone();
                self.alternatives(then, &truth.yes, to)?;
                self.reads = reads;
                self.alternatives(otherwise, &truth.no, to)
            }
            RuleNode::Switch(subject, cases, otherwise) if is_split => {
                let subject = self.term(subject, path)?;
                let mut rest = self.alive(path)?;
                for (case, rule) in cases {
                    let (here, others) = self.case(case, &subject, &rest)?;
                    let reads = self.reads.clone();
                    self.alternatives(rule, &here, to)?;
                    self.reads = reads;
                    rest = others;
                }
                self.alternatives(otherwise, &rest, to)
            }
            RuleNode::Let(bindings, body) => {
                let path = self.bind(bindings, path)?;
                self.alternatives(body, &path, to)
            }
            RuleNode::Counted(counter, rule) => {
                self.count(*counter, path)?;
                self.alternatives(rule, path, to)
            }
            RuleNode::Watched(rule) => self.alternatives(rule, path, to),
            RuleNode::Par(rules) | RuleNode::Seq(rules) if rules.len() == 1 => rules
                .iter()
                .try_for_each(|rule| self.alternatives(rule, path, to)),
            RuleNode::Call(routine, arguments) => {
                let arguments = self.terms(arguments, path)?;
                let path = self.alive(path)?;
                let program = self.program;
                let Some(routine) = program.routines.get(routine.0 as usize) else {
                    return Ok(());
                };
                self.enter(arguments, routine.locals, rule.origin)?;
                let done = self.alternatives(&routine.code, &path, to);
                self.leave();
                done
            }
            RuleNode::Skip
            | RuleNode::Update(..)
            | RuleNode::Assign(..)
            | RuleNode::Run(..)
            | RuleNode::RunAgent(..)
            | RuleNode::Par(_)
            | RuleNode::Seq(_)
            | RuleNode::If(..)
            | RuleNode::Switch(..)
            | RuleNode::Choose(..)
            | RuleNode::Forall(..)
            | RuleNode::Extend(..)
            | RuleNode::While { .. }
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..) => self.whole(rule, path, to),
        }
    }

    /// Evaluates a rule as one alternative.
    fn whole(
        &mut self,
        rule: &Rule,
        path: &Bdd,
        to: &mut Vec<Alternative>,
    ) -> Result<(), SymbolicError> {
        self.layers = vec![Layer::new()];
        self.view.clear();
        self.choices.clear();
        let path = self.rule(rule, path)?;
        let updates = self.close();
        if path.is_never() {
            return Ok(());
        }
        let mut kept = BTreeMap::new();
        for (slot, written) in updates {
            let value = values(self.store, &written)?.under(self.store, &path)?;
            if value.len() > 0 {
                kept.insert(slot, value);
            }
        }
        to.push(Alternative {
            path,
            updates: kept,
            reads: self.reads.clone(),
            choices: std::mem::take(&mut self.choices),
        });
        Ok(())
    }
}
