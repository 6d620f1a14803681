//! Generates sequences in direct rules: the values of the slots that a sequence updates are in registers until it ends.
//!
//! Each slot has one update, which the first write adds and later ones overwrite in place. Memory keeps the values from before
//! the sequence, so nothing has to be restored.

use crate::direct_code::{DirectCode, DirectSequence, SequenceSlot};
use crate::emit::{Emitter, KnownValue, Ssa, UpdateMode};
use crate::frame::at;
use crate::limits::MAX_INLINED;
use crate::location::Located;
use asmotion_ir::{AssignTarget, FunctionId, Origin, RoutineId, Rule, RuleNode, Slot, ValueKind};
use asmotion_machine::back_end::MAX_ITERATIONS;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64};
use cranelift_codegen::ir::{InstBuilder, Type};
use std::collections::BTreeMap;

/// Limit for the number of slots that a sequence updates.
const MAX_SLOTS: usize = 64;

impl Emitter<'_> {
    /// In a direct rule, generates a sequence, or gives up, and returns `true`.
    pub fn sequence_directly(&mut self, rule: &Rule, rules: impl FnOnce(&mut Self)) -> bool {
        if self.direct.is_none() {
            return false;
        }
        if self.mode == UpdateMode::Sequence {
            rules(self);
        } else if self.begins_sequence(rule) {
            let outer = std::mem::replace(&mut self.mode, UpdateMode::Sequence);
            rules(self);
            self.mode = outer;
            if let Some(direct) = &mut self.direct {
                direct.sequence = DirectSequence::default();
            }
        } else {
            self.gives_up();
        }
        true
    }

    /// Prepares the registers of a sequence; returns `false` if it is not supported.
    fn begins_sequence(&mut self, rule: &Rule) -> bool {
        let mut slots = BTreeMap::new();
        let is_known = self.written(rule, &mut Vec::new(), &mut slots);
        if !is_known || slots.len() > MAX_SLOTS {
            return false;
        }
        let Some(direct) = &self.direct else {
            return false;
        };
        let is_alone = direct.is_executed_once();
        let is_suitable = |function: &FunctionId| {
            direct.is_clash_free(*function) && self.register_of(*function).is_some()
        };
        if !is_alone || !slots.values().all(is_suitable) {
            return false;
        }
        for (slot, function) in slots {
            let Some((_, ty)) = self.register_of(function) else {
                return false;
            };
            let located = self.fixed(function, slot);
            let (value, update) = (self.builder.declare_var(ty), self.builder.declare_var(I64));
            let before = self.payload(&located, ty);
            let none = self.number(I64, 0);
            self.builder.def_var(value, before);
            self.builder.def_var(update, none);
            if let Some(direct) = &mut self.direct {
                direct.add_updates(1);
                let known = SequenceSlot {
                    function,
                    value,
                    update,
                };
                direct.sequence.slots.insert(slot, known);
            }
        }
        true
    }

    /// Returns the tag and the type of a function's values, if all of them are scalars of one kind.
    fn register_of(&self, function: FunctionId) -> Option<(ValueKind, Type)> {
        let fact = self.value_fact(function);
        let types = [
            (ValueKind::Int, I64),
            (ValueKind::Bool, I8),
            (ValueKind::Atom, I32),
        ];
        let mut types = types.into_iter();
        types.find(|(kind, _)| fact.is_always(*kind))
    }

    /// Collects the slots that a rule updates; returns `false` if it contains rules that are not supported.
    fn written(
        &self,
        rule: &Rule,
        inlined: &mut Vec<RoutineId>,
        slots: &mut BTreeMap<Slot, FunctionId>,
    ) -> bool {
        match &*rule.node {
            RuleNode::Skip => true,
            RuleNode::Update(AssignTarget::Slot(function, slot), _) => {
                slots.insert(*slot, *function);
                true
            }
            RuleNode::Par(rules) | RuleNode::Seq(rules) => {
                rules.iter().all(|rule| self.written(rule, inlined, slots))
            }
            RuleNode::If(_, then, otherwise) => {
                self.written(then, inlined, slots) && self.written(otherwise, inlined, slots)
            }
            RuleNode::Switch(_, cases, otherwise) => {
                let mut cases = cases.iter();
                cases.all(|(_, rule)| self.written(rule, inlined, slots))
                    && self.written(otherwise, inlined, slots)
            }
            RuleNode::Let(_, body) | RuleNode::Counted(_, body) | RuleNode::While { body, .. } => {
                self.written(body, inlined, slots)
            }
            RuleNode::Call(routine, _) => {
                if inlined.contains(routine) || inlined.len() > MAX_INLINED {
                    return false;
                }
                inlined.push(*routine);
                let body = &self.program.routines[routine.0 as usize].code;
                let is_known = self.written(body, inlined, slots);
                inlined.pop();
                is_known
            }
            RuleNode::Update(..)
            | RuleNode::Assign(..)
            | RuleNode::Run(..)
            | RuleNode::RunAgent(..)
            | RuleNode::Choose(..)
            | RuleNode::Forall(..)
            | RuleNode::Extend(..)
            | RuleNode::Watched(_)
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..) => false,
        }
    }

    /// Returns the value of a slot that the sequence updates. Gives up for a location that may be such a slot.
    pub fn read_in_sequence(&mut self, located: &Located, ty: Type) -> Option<Ssa> {
        let direct = self.direct.as_ref()?;
        let slots = &direct.sequence.slots;
        match located.constant() {
            Some(slot) => {
                let slot = Slot::try_from(slot).ok()?;
                let value = slots.get(&slot)?.value;
                Some(self.builder.use_var(value))
            }
            None => {
                let mut slots = slots.values();
                if slots.any(|slot| slot.function == located.function) {
                    self.gives_up();
                    return Some(self.number(ty, 0));
                }
                None
            }
        }
    }

    /// In a sequence of a direct rule, generates an update.
    pub fn write_in_sequence(&mut self, located: &Located, value: KnownValue, origin: Origin) {
        self.advance_updates();
        let slot = located.constant().and_then(|it| Slot::try_from(it).ok());
        let direct = self.direct.as_ref();
        let known = direct.and_then(|it| it.sequence.slots.get(&slot?).copied());
        let (Some(known), Some(next_update)) = (known, direct.map(|it| it.next_update())) else {
            self.gives_up();
            return;
        };
        let update = self.builder.use_var(known.update);
        let next = self.builder.use_var(next_update);
        let after = self.builder.ins().iadd_imm_s(next, at::UPDATE_SIZE);
        let is_first = self.compare(IntCC::Equal, update, 0);
        let update = self.builder.ins().select(is_first, next, update);
        let next = self.builder.ins().select(is_first, after, next);
        self.builder.def_var(known.update, update);
        self.builder.def_var(next_update, next);
        let slot = self.number(I32, i64::from(slot.unwrap_or_default()));
        self.put_directly((update, 0), slot, value, origin);
        let payload = match value {
            KnownValue::Int(int) => int.value,
            KnownValue::Bool(truth) => truth,
            KnownValue::Atom(atom) => atom.value,
            KnownValue::Nothing | KnownValue::Memory(_) => return,
        };
        self.builder.def_var(known.value, payload);
        let flags = self.direct.as_ref().map(|it| it.sequence.writes.clone());
        for flag in flags.unwrap_or_default() {
            let yes = self.number(I8, 1);
            self.builder.def_var(flag, yes);
        }
    }

    /// Generates the check of the limit of iterations at the head of a loop.
    fn count_iteration(&mut self) {
        let Some(iterations) = self.direct.as_ref().map(DirectCode::iterations) else {
            return;
        };
        let before = self.builder.use_var(iterations);
        let limit = i64::from(MAX_ITERATIONS);
        let many = self.compare(IntCC::UnsignedGreaterThanOrEqual, before, limit);
        self.bail_if(many);
        let after = self.builder.ins().iadd_imm_s(before, 1);
        self.builder.def_var(iterations, after);
    }

    /// In a direct rule, generates a loop within a sequence, and returns `true`. Gives up if it has too many iterations.
    pub fn repeats_directly(
        &mut self,
        guarded: impl FnOnce(&mut Self, cranelift_codegen::ir::Block),
        body: impl FnOnce(&mut Self),
        until_idle: bool,
    ) -> bool {
        if self.direct.is_none() {
            return false;
        }
        let flag = self.builder.declare_var(I8);
        if let Some(direct) = &mut self.direct {
            direct.sequence.writes.push(flag);
        }
        let (head, done) = (self.block(), self.block());
        self.jump(head);
        self.begin_loop(head);
        self.count_iteration();
        let no = self.number(I8, 0);
        self.builder.def_var(flag, no);
        guarded(self, done);
        self.repeated(u64::from(MAX_ITERATIONS), |this| this.conditionally(body));
        if until_idle {
            let wrote = self.builder.use_var(flag);
            self.branch(wrote, head, done);
        } else {
            self.jump(head);
        }
        self.begin(done);
        if let Some(direct) = &mut self.direct {
            direct.sequence.writes.pop();
        }
        true
    }
}
