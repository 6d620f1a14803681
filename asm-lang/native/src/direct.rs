//! Generates direct rules: native code that evaluates whole steps, and gives up where other native code has a detour.
//!
//! A direct rule needs neither the context of a step nor its counters: the numbers of bindings, calls and updates are
//! bounded when it is compiled. Functions whose locations are updated at most once need no marks.

use crate::bound_range::{BoundRange, total};
use crate::direct_code::{DirectCode, DirectSequence};
use crate::direct_frame;
use crate::emit::{Emitter, KnownValue, Ssa, UpdateMode};
use crate::frame::at;
use crate::location::Located;
use crate::value_facts::{ValueFact, ValueFacts};
use asmotion_ir::{FunctionId, Origin};
use asmotion_value::layout;
use cranelift_codegen::ir::InstBuilder;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64, I64X2};
use std::sync::Arc;

/// Number of bytes from which on the address of the next update is advanced within a block, so that offsets have few bits.
const MAX_PENDING: i32 = 1 << 16;

impl Emitter<'_> {
    /// Generates a direct rule instead of code with detours.
    pub fn set_direct(&mut self, clash_free: Vec<bool>, facts: Arc<ValueFacts>) {
        self.calls.way.address = direct_frame::way as *const () as usize as i64;
        self.calls.choose.address = direct_frame::choose as *const () as usize as i64;
        let next_update = self.builder.declare_var(I64);
        let first = self.field(I64, at::LIST);
        self.builder.def_var(next_update, first);
        let slots = self.field(I64, at::SLOTS);
        let iterations = self.builder.declare_var(I64);
        let none = self.number(I64, 0);
        self.builder.def_var(iterations, none);
        self.direct = Some(DirectCode {
            next_update,
            pending: 0,
            first_update: first,
            slots,
            iterations,
            holds_scalars: true,
            clash_free,
            facts,
            repetitions: 1,
            updates: 0,
            bindings: 0,
            calls: 0,
            is_futile: false,
            extents: Vec::new(),
            sequence: DirectSequence::default(),
        });
    }

    /// Generates the end of a direct rule: the updates are applied if there is a list for previous values.
    pub fn end_direct(&mut self) {
        self.advance_updates();
        let Some(direct) = &self.direct else {
            return;
        };
        let (first, slots) = (direct.first_update, direct.slots);
        let holds_scalars = direct.holds_scalars;
        let end = self.builder.use_var(direct.next_update);
        self.store(self.memory.frame, end, self.frame, at::LIST);
        let (some, apply, head, done) = (self.block(), self.block(), self.block(), self.block());
        let update = self.builder.append_block_param(head, I64);
        let before = self.builder.append_block_param(head, I64);
        let others = self.builder.append_block_param(head, I8);
        let result = self.builder.append_block_param(done, I8);
        let none = self.number(I8, 0);
        let is_empty = self.builder.ins().icmp(IntCC::Equal, first, end);
        let ins = self.builder.ins();
        ins.brif(is_empty, done, &[none.into()], some, &[]);
        self.begin(some);
        let list = self.field(I64, direct_frame::BEFORE);
        let ins = self.builder.ins();
        ins.brif(list, apply, &[], done, &[none.into()]);
        self.begin(apply);
        let start = [first.into(), list.into(), none.into()];
        self.builder.ins().jump(head, &start);
        self.begin_loop(head);
        let memory = self.memory.updates;
        let slot = self.builder.ins().uload32(memory, update, at::UPDATE_SLOT);
        let bytes = self.scaled(slot, at::VALUE_SIZE);
        let place = self.builder.ins().iadd(slots, bytes);
        let mut found = others;
        if !holds_scalars {
            let tag = self.load(self.memory.slots, I8, place, 0);
            let last = i64::from(layout::LAST_SCALAR);
            let is_other = self.compare(IntCC::UnsignedGreaterThan, tag, last);
            found = self.builder.ins().bor(others, is_other);
        }
        let previous = self.load(self.memory.slots, I64X2, place, 0);
        self.store(self.memory.locals, previous, before, 0);
        for offset in [0, at::PAYLOAD] {
            // not in one load: it would wait for both stores
            let word = self.load(self.memory.updates, I64, update, at::UPDATE_VALUE + offset);
            self.store(self.memory.slots, word, place, offset);
        }
        let next = self.builder.ins().iadd_imm_s(update, at::UPDATE_SIZE);
        let next_before = self.builder.ins().iadd_imm_s(before, at::VALUE_SIZE);
        let is_last = self.builder.ins().icmp(IntCC::Equal, next, end);
        self.builder.ins().brif(
            is_last,
            done,
            &[found.into()],
            head,
            &[next.into(), next_before.into(), found.into()],
        );
        self.begin(done);
        let status = self.builder.ins().imul_imm_s(result, 2);
        self.builder.ins().return_(&[status]);
        let rest = self.block();
        self.begin(rest);
    }

    /// In a direct rule, generates the exit that gives up, and returns `true`. The code that follows is unreachable.
    pub fn gives_up(&mut self) -> bool {
        let is_certain = self.conditions == 0;
        let Some(direct) = &mut self.direct else {
            return false;
        };
        direct.is_futile |= is_certain;
        self.bail();
        let rest = self.block();
        self.begin(rest);
        true
    }

    /// Returns what is known about the values of a function: nothing, except in a direct rule.
    pub fn value_fact(&self, function: FunctionId) -> ValueFact {
        let direct = self.direct.as_ref();
        direct.map_or(ValueFact::ANYTHING, |direct| direct.facts.get(function))
    }

    /// In a direct rule, counts a call at compile time, and returns `true`.
    pub fn counts_call(&mut self) -> bool {
        let Some(direct) = &mut self.direct else {
            return false;
        };
        direct.calls = direct.calls.saturating_add(direct.repetitions);
        true
    }

    /// In a direct rule, counts the bindings of loops at compile time, and returns `true`.
    pub fn counts_bindings(&mut self, spans: &[BoundRange]) -> bool {
        let Some(direct) = &mut self.direct else {
            return false;
        };
        let bindings = total(spans).saturating_mul(direct.repetitions);
        direct.bindings = direct.bindings.saturating_add(bindings);
        true
    }

    /// Generates the body of a loop with this number of iterations.
    pub fn repeated(&mut self, count: u64, body: impl FnOnce(&mut Self)) {
        let outer = self.direct.as_ref().map(|direct| direct.repetitions);
        if let Some(direct) = &mut self.direct {
            direct.repetitions = direct.repetitions.saturating_mul(count);
        }
        body(self);
        if let (Some(direct), Some(outer)) = (&mut self.direct, outer) {
            direct.repetitions = outer;
        }
    }

    /// Generates code that is executed only under a condition.
    pub fn conditionally(&mut self, code: impl FnOnce(&mut Self)) {
        self.conditions += 1;
        code(self);
        self.conditions -= 1;
    }

    /// In a direct rule, generates an update, and returns `true`. Gives up if the location already has one.
    pub fn writes_directly(
        &mut self,
        located: &Located,
        value: KnownValue,
        origin: Origin,
    ) -> bool {
        let mode = self.mode;
        let Some(direct) = &mut self.direct else {
            return false;
        };
        if mode == UpdateMode::Sequence {
            self.write_in_sequence(located, value, origin);
            return true;
        }
        direct.add_updates(direct.repetitions);
        let next_update = direct.next_update;
        direct.holds_scalars &= direct.facts.get(located.function).is_scalar();
        let is_free = direct.is_clash_free(located.function);
        let constant = located.constant();
        let slot = match constant {
            Some(_) if is_free => None,
            Some(_) | None => Some(self.slot(located)),
        };
        if !is_free && let Some(slot) = slot {
            let mark = self.mark(slot);
            let of = self.load(self.memory.updates, I32, mark, at::MARK_EPOCH);
            let epoch = self.field(I32, at::EPOCH);
            let again = self.builder.ins().icmp(IntCC::Equal, of, epoch);
            self.bail_if(again);
            self.store(self.memory.updates, epoch, mark, at::MARK_EPOCH);
        }
        let update = self.builder.use_var(next_update);
        let slot = match (constant, slot) {
            (None, Some(slot)) => self.builder.ins().ireduce(I32, slot),
            (constant, _) => self.number(I32, constant.unwrap_or_default()),
        };
        let offset = self.direct.as_ref().map_or(0, |direct| direct.pending);
        self.put_directly((update, offset), slot, value, origin);
        if let Some(direct) = &mut self.direct {
            direct.pending += at::UPDATE_SIZE as i32;
        }
        if offset > MAX_PENDING {
            self.advance_updates();
        }
        true
    }

    /// Returns `true` unless the address of the next update is still to be advanced.
    pub fn has_advanced(&self) -> bool {
        self.direct
            .as_ref()
            .is_none_or(|direct| direct.pending == 0)
    }

    /// Advances the address of the next update, before a jump or where it is read. The updates of a block have addresses relative to
    /// that at its beginning, so that it advances once.
    pub fn advance_updates(&mut self) {
        let Some(direct) = &mut self.direct else {
            return;
        };
        let (next_update, pending) = (direct.next_update, std::mem::take(&mut direct.pending));
        if pending > 0 {
            let update = self.builder.use_var(next_update);
            let next = self.builder.ins().iadd_imm_s(update, i64::from(pending));
            self.builder.def_var(next_update, next);
        }
    }

    /// Stores an update.
    pub fn put_directly(
        &mut self,
        (update, offset): (Ssa, i32),
        slot: Ssa,
        value: KnownValue,
        origin: Origin,
    ) {
        self.store(self.memory.updates, slot, update, offset + at::UPDATE_SLOT);
        let origin = self.number(I32, i64::from(origin.0));
        let place = offset + at::UPDATE_ORIGIN;
        self.store(self.memory.updates, origin, update, place);
        if let Some((tag, payload)) = self.tag_and_payload(value) {
            // two stores, which the end of the rule loads as they were stored
            let tag = self.number(I64, i64::from(tag));
            let place = offset + at::UPDATE_VALUE;
            self.store(self.memory.updates, tag, update, place);
            let place = place + at::PAYLOAD;
            self.store(self.memory.updates, payload, update, place);
        }
    }
}
