//! Generates code for coverage counters.
//!
//! A rule is counted before its unit begins, so a detour does not count it again.

use crate::emit::{Emitter, Ssa};
use crate::frame::at;
use asmotion_ir::{Counter, Rule};
use cranelift_codegen::ir::InstBuilder;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::I64;

/// Size of a counter in bytes.
const SIZE: i64 = size_of::<u64>() as i64;

impl Emitter<'_> {
    /// Generates code for a rule with a counter.
    pub fn counted_rule(&mut self, counter: Counter, rule: &Rule) {
        match counter {
            Counter::Count(counter) => {
                self.count(counter);
                self.rule(rule);
            }
            Counter::Rounds { round, none } => {
                let before = self.counter(round);
                self.rule(rule);
                let after = self.counter(round);
                let rounds = self.builder.ins().isub(after, before);
                let two = self.number(I64, 2);
                let few = self.compare(IntCC::UnsignedLessThan, rounds, 2);
                let which = self.builder.ins().select(few, rounds, two);
                let bytes = self.builder.ins().imul_imm_s(which, SIZE);
                let counters = self.field(I64, at::COUNTERS);
                let place = self.builder.ins().iadd(counters, bytes);
                self.increment(place, offset(none));
            }
        }
    }

    /// Increments the counter with this index.
    pub fn count(&mut self, counter: u32) {
        let counters = self.field(I64, at::COUNTERS);
        self.increment(counters, offset(counter));
    }

    fn counter(&mut self, counter: u32) -> Ssa {
        let counters = self.field(I64, at::COUNTERS);
        self.load(self.memory.counters, I64, counters, offset(counter))
    }

    fn increment(&mut self, place: Ssa, offset: i32) {
        let before = self.load(self.memory.counters, I64, place, offset);
        let after = self.builder.ins().iadd_imm_s(before, 1);
        self.store(self.memory.counters, after, place, offset);
    }
}

/// Returns the offset of a counter in bytes. Counters number less than the nodes of a program, which fit in memory many
/// times the size of a counter.
fn offset(counter: u32) -> i32 {
    (i64::from(counter) * SIZE) as i32
}
