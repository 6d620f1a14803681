//! Generates code for sequences, whose updates are visible to later rules of the step.
//!
//! Within a sequence, a rule that only updates distinct known slots needs no layer: its updates
//! cannot clash and are applied one by one. Sequences and loops directly within a sequence share
//! its layer, because this does not change their net updates.

use crate::emit::{Emitter, KnownValue, Ssa, UpdateMode};
use asmotion_ir::{AssignTarget, Counter, Origin, Rule, RuleNode, Slot, Term};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::I8;

/// An update of a known slot.
struct SlotUpdate<'r> {
    place: &'r AssignTarget,
    value: &'r Term,
    origin: Origin,
    /// Coverage counter of the update, if any.
    counter: Option<u32>,
}

impl Emitter<'_> {
    /// Generates code for a sequence of rules.
    pub fn sequence(&mut self, rules: impl FnOnce(&mut Self)) {
        if self.mode == UpdateMode::Sequence {
            return rules(self);
        }
        self.call(self.calls.open, &[]);
        let outer = std::mem::replace(&mut self.mode, UpdateMode::Sequence);
        rules(self);
        self.mode = outer;
        if let Some(stopped) = self.call(self.calls.restore, &[]) {
            let stopped = self.compare(IntCC::NotEqual, stopped, 0);
            self.stop_if(stopped);
        }
    }

    /// Generates code for a rule that needs an update set: within a sequence, a layer of its own.
    pub fn as_set(&mut self, rule: impl FnOnce(&mut Self)) {
        match self.mode {
            UpdateMode::Step | UpdateMode::Layer => rule(self),
            UpdateMode::Sequence => {
                self.layer(rule);
            }
        }
    }

    /// Generates a layer within a sequence, applied at its end; returns `true` if its set is empty.
    pub fn layer(&mut self, rule: impl FnOnce(&mut Self)) -> Ssa {
        if self.gives_up() {
            return self.number(I8, 0);
        }
        self.call(self.calls.open, &[]);
        let outer = std::mem::replace(&mut self.mode, UpdateMode::Layer);
        rule(self);
        self.mode = outer;
        match self.call(self.calls.apply, &[]) {
            Some(idle) => idle,
            None => self.number(I8, 0),
        }
    }

    pub fn par_in_sequence(&mut self, rule: &Rule, rules: &[Rule]) {
        let Some(updates) = self.disjoint_updates(rules) else {
            self.layer(|this| rules.iter().for_each(|rule| this.rule(rule)));
            return;
        };
        let counts = self.any_counts(updates.iter().map(|update| update.value));
        let native = |this: &mut Self| {
            let mut values: Vec<KnownValue> = Vec::new();
            for update in &updates {
                let value = this.scalar(update.value);
                this.check_domain(update.place, value);
                values.push(value);
            }
            for (update, value) in updates.iter().zip(values) {
                if let Some(counter) = update.counter {
                    this.count(counter);
                }
                if let Some(target) = this.target(update.place) {
                    this.write(&target, value, update.origin);
                }
            }
        };
        self.straight_unit(counts, native, |this| this.rule_outside(rule));
    }

    /// Returns the updates that the rules consist of, if their slots are distinct.
    fn disjoint_updates<'r>(&self, rules: &'r [Rule]) -> Option<Vec<SlotUpdate<'r>>> {
        let mut slots: Vec<Slot> = Vec::new();
        let mut updates = Vec::new();
        for rule in rules {
            let mut counter = None;
            let mut rule = rule;
            if let RuleNode::Counted(Counter::Count(known), counted) = &*rule.node {
                (rule, counter) = (counted, Some(*known));
            }
            let RuleNode::Update(place, value) = &*rule.node else {
                return None;
            };
            let AssignTarget::Slot(_, slot) = place else {
                return None;
            };
            if slots.contains(slot) || !self.is_native_update(place, value) {
                return None;
            }
            slots.push(*slot);
            updates.push(SlotUpdate {
                place,
                value,
                origin: rule.origin,
                counter,
            });
        }
        Some(updates)
    }
}

/// Returns `true` if a rule always yields an update, unless it stops.
pub(crate) fn always_writes(rule: &Rule) -> bool {
    match &*rule.node {
        RuleNode::Update(..) => true,
        RuleNode::Par(rules) | RuleNode::Seq(rules) => rules.iter().any(always_writes),
        RuleNode::If(_, then, otherwise) => always_writes(then) && always_writes(otherwise),
        RuleNode::Let(_, body) | RuleNode::Counted(_, body) => always_writes(body),
        RuleNode::Skip
        | RuleNode::Assign(..)
        | RuleNode::Call(..)
        | RuleNode::Run(..)
        | RuleNode::RunAgent(..)
        | RuleNode::Switch(..)
        | RuleNode::Choose(..)
        | RuleNode::Forall(..)
        | RuleNode::Extend(..)
        | RuleNode::While { .. }
        | RuleNode::Local { .. }
        | RuleNode::Draw(..)
        | RuleNode::Act(..)
        | RuleNode::Watched(_) => false,
    }
}
