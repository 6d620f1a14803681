//! Generates code for ranges of variables: `forall`, `choose`, and loops over all assignments.

use crate::atoms::AtomRange;
use crate::bound_range::{BoundRange, Counting, total};
use crate::emit::{AtomCode, Emitter, KnownValue, Loops, NativeInt, Ssa};
use crate::range_guard::RangeGuard;
use crate::static_analysis::{StaticRange, rule_counts};
use crate::unroll::PartCount;
use asmotion_ir::{Binder, IntegerInterval, Origin, Rule, Term};
use asmotion_machine::back_end::MAX_BINDINGS;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64};
use cranelift_codegen::ir::{Block, InstBuilder, Type};

impl Emitter<'_> {
    pub fn forall(&mut self, rule: &Rule, binders: &[Binder], guard: Option<&Term>, body: &Rule) {
        let Some(spans) = self.spans(binders) else {
            return self.rule_outside(rule);
        };
        let guard = self.range_guard(binders, guard);
        if self.is_left_to_index(&guard, &spans) {
            return self.rule_outside(rule);
        }
        let each = guard.counts(self.program)
            || rule_counts(self.program, body)
            || total(&spans) > u64::from(MAX_BINDINGS);
        let counting = if guard.is_indexed() {
            Counting::Satisfying
        } else if each {
            Counting::EachInRule
        } else {
            Counting::Together
        };
        let native = |this: &mut Self| {
            if let Some(residue) = this.residue_guard(&spans, &guard) {
                return this.each_of_residue(&spans, &residue, &mut |this| this.rule(body));
            }
            let parts = PartCount::of_guard(this.program, &guard).with_rule(this.program, body);
            this.each(&spans, counting, Some(parts), &mut |this, next| {
                this.range_guarded(&guard, true, &spans, next);
                if guard.is_always() {
                    this.rule(body);
                } else {
                    this.conditionally(|this| this.rule(body));
                }
                this.jump(next);
            });
        };
        self.straight_unit(false, native, |this| this.rule_outside(rule));
    }

    /// Generates code for `choose`: counts the candidates, then enumerates them again up to the
    /// chosen one.
    pub fn choose(
        &mut self,
        rule: &Rule,
        binders: &[Binder],
        guard: Option<&Term>,
        body: &Rule,
        ifnone: &Rule,
    ) {
        let Some(spans) = self.spans(binders) else {
            return self.rule_outside(rule);
        };
        let guard = self.range_guard(binders, guard);
        if self.is_left_to_index(&guard, &spans) {
            return self.rule_outside(rule);
        }
        let total = total(&spans);
        let each = guard.counts(self.program) || total > u64::from(MAX_BINDINGS / 2);
        let counting = if guard.is_indexed() {
            Counting::Satisfying
        } else if each {
            Counting::EachInRule
        } else {
            Counting::Checked
        };
        let done = self.block();
        let native = |this: &mut Self| {
            if this.keeps_candidates(&spans, &guard) {
                this.choose_by_bits(&spans, &guard, rule.origin, done, |this| this.rule(body));
                return this.conditionally(|this| this.rule(ifnone));
            }
            if counting == Counting::Checked && this.direct.is_none() {
                let before = this.bindings();
                this.bail_if_many(before, 2 * total);
            }
            let chosen = this.chosen_index(&spans, counting, &guard, rule.origin);
            let seen = this.builder.declare_var(I64);
            let none = this.number(I64, 0);
            this.builder.def_var(seen, none);
            let counts = !guard.is_answered();
            this.each(&spans, counting, None, &mut |this, next| {
                this.range_guarded(&guard, counts, &spans, next);
                let (skip, found) = (this.block(), this.block());
                let so_far = this.builder.use_var(seen);
                let earlier = this
                    .builder
                    .ins()
                    .icmp(IntCC::UnsignedLessThan, so_far, chosen);
                this.branch(earlier, skip, found);
                this.begin(skip);
                let one_more = this.builder.ins().iadd_imm_s(so_far, 1);
                this.builder.def_var(seen, one_more);
                this.jump(next);
                this.begin(found);
                this.count_up_to_here();
                if !counts {
                    this.count_satisfying(&spans);
                }
                this.conditionally(|this| this.rule(body));
                this.jump(done);
            });
            this.conditionally(|this| this.rule(ifnone));
        };
        self.unit(false, native, |this| this.rule_outside(rule), Some(done));
    }

    /// Generates the index of the chosen candidate.
    fn chosen_index(
        &mut self,
        spans: &[BoundRange],
        counting: Counting,
        guard: &RangeGuard<'_>,
        origin: Origin,
    ) -> Ssa {
        let (count_all, ask, known) = (self.block(), self.block(), self.block());
        let chosen = self.builder.append_block_param(known, I64);
        let none = self.number(I64, 0);
        let mut takes_first = self.number(I8, 0);
        for (_, _, range) in spans {
            let range = self.number(I32, i64::from(range.0));
            if let Some(way) = self.call(self.calls.way, &[range]) {
                let is_picked = self.compare(IntCC::Equal, way, 2);
                self.bail_if(is_picked);
                takes_first = way;
            }
        }
        self.advance_updates();
        self.builder
            .ins()
            .brif(takes_first, known, &[none.into()], count_all, &[]);
        self.begin(count_all);
        let count = self.builder.declare_var(I64);
        self.builder.def_var(count, none);
        let counts = !guard.is_answered();
        self.each(spans, counting, None, &mut |this, next| {
            this.range_guarded(guard, counts, spans, next);
            let so_far = this.builder.use_var(count);
            let one_more = this.builder.ins().iadd_imm_s(so_far, 1);
            this.builder.def_var(count, one_more);
            this.jump(next);
        });
        let count = self.builder.use_var(count);
        self.advance_updates();
        self.builder
            .ins()
            .brif(count, ask, &[], known, &[none.into()]);
        self.begin(ask);
        let origin = self.number(I32, i64::from(origin.0));
        if let Some(chosen) = self.call(self.calls.choose, &[count, origin]) {
            self.jump_with(known, chosen);
        }
        self.begin(known);
        chosen
    }

    /// Returns the ranges of variables if native code can enumerate all of them.
    pub fn spans(&self, binders: &[Binder]) -> Option<Vec<BoundRange>> {
        let spanned = |binder: &Binder| {
            let span = self.span(&binder.range)?;
            Some((binder.local, span, binder.origin))
        };
        binders.iter().map(spanned).collect()
    }

    /// Generates nested loops over all variables. `body` gets the block of the next iteration, and
    /// must end with a jump to it or elsewhere. Short loops are unrolled if the size of an iteration is given.
    pub fn each(
        &mut self,
        spans: &[BoundRange],
        counting: Counting,
        parts: Option<PartCount>,
        body: &mut dyn FnMut(&mut Self, Block),
    ) {
        let counting = if self.counts_bindings(spans) {
            Counting::Bounded
        } else {
            counting
        };
        let before = match counting {
            Counting::Together | Counting::Checked => Some(self.bindings()),
            Counting::EachInRule
            | Counting::EachInTerm
            | Counting::Satisfying
            | Counting::Bounded => None,
        };
        if let (Counting::Together, Some(before)) = (counting, before) {
            self.bail_if_many(before, total(spans));
        }
        self.loops.push(Loops {
            before,
            rounds: Vec::new(),
        });
        if parts.is_some_and(|parts| self.is_unrolled(spans, counting, parts)) {
            self.unrolled(spans, body);
        } else {
            self.round(spans, counting, body);
        }
        self.loops.pop();
        if let Some(before) = before {
            let after = self.builder.ins().iadd_imm_s(before, total(spans) as i64);
            self.set_bindings(after);
        }
    }

    fn bail_if_many(&mut self, before: Ssa, more: u64) {
        if more > u64::from(MAX_BINDINGS) {
            let always = self.number(I8, 1);
            return self.bail_if(always);
        }
        let most = i64::from(MAX_BINDINGS) - more as i64;
        let many = self.compare(IntCC::UnsignedGreaterThan, before, most);
        self.bail_if(many);
    }

    pub fn round(
        &mut self,
        spans: &[BoundRange],
        counting: Counting,
        body: &mut dyn FnMut(&mut Self, Block),
    ) {
        let Some((&(local, span, origin), inner)) = spans.split_first() else {
            return;
        };
        if span.count() == 0 {
            return;
        }
        let (ty, first, last): (Type, i64, i64) = match span {
            StaticRange::Ints(low, high) => (I64, low, high),
            StaticRange::Atoms(first, count) => {
                (I32, first.into(), i64::from(first) + i64::from(count) - 1)
            }
            StaticRange::Bools => (I8, 0, 1),
            StaticRange::Extent(domain) => {
                return self.extent_round((local, domain), inner, counting, body);
            }
        };
        let (head, next, done) = (self.block(), self.block(), self.block());
        let value = self.builder.append_block_param(head, ty);
        let start = self.number(ty, first);
        self.jump_with(head, start);
        self.begin_loop(head);
        self.count_one(counting, origin);
        let outer = self.scope.locals[local as usize];
        self.scope.locals[local as usize] = match span {
            StaticRange::Ints(low, high) => {
                KnownValue::Int(NativeInt::new(value, IntegerInterval { low, high }))
            }
            StaticRange::Atoms(first, count) => KnownValue::Atom(AtomCode {
                value,
                among: Some(AtomRange::Atoms(first, count)),
            }),
            StaticRange::Bools | StaticRange::Extent(_) => KnownValue::Bool(value),
        };
        let index = self.builder.ins().iadd_imm_s(value, first.wrapping_neg());
        let index = match ty {
            I64 => index,
            _ => self.builder.ins().uextend(I64, index),
        };
        if let Some(loops) = self.loops.last_mut() {
            loops.rounds.push((index, total(inner)));
        }
        self.repeated(span.count(), |this| {
            if inner.is_empty() {
                body(this, next);
            } else {
                this.round(inner, counting, body);
                this.jump(next);
            }
        });
        if let Some(loops) = self.loops.last_mut() {
            loops.rounds.pop();
        }
        self.scope.locals[local as usize] = outer;
        self.begin(next);
        let is_last = self.compare(IntCC::Equal, value, last);
        let successor = self.builder.ins().iadd_imm_s(value, 1);
        self.builder
            .ins()
            .brif(is_last, done, &[], head, &[successor.into()]);
        self.begin(done);
    }

    /// Counts a binding that satisfies the equation of an index. In a direct rule, all bindings are counted at compile time.
    pub fn count_satisfying(&mut self, spans: &[BoundRange]) {
        if let (None, Some((_, _, origin))) = (&self.direct, spans.first()) {
            self.count_one(Counting::EachInRule, *origin);
        }
    }

    fn count_one(&mut self, counting: Counting, origin: Origin) {
        match counting {
            Counting::Together | Counting::Checked | Counting::Satisfying | Counting::Bounded => {
                return;
            }
            Counting::EachInRule | Counting::EachInTerm => {}
        }
        let before = self.bindings();
        let bindings = self.builder.ins().iadd_imm_s(before, 1);
        self.set_bindings(bindings);
        let many = self.compare(
            IntCC::UnsignedGreaterThan,
            bindings,
            i64::from(MAX_BINDINGS),
        );
        if counting == Counting::EachInTerm {
            return self.bail_if(many);
        }
        self.endless_if(many, MAX_BINDINGS, origin);
    }

    /// Counts the bindings up to the current iteration, before the loops are left early.
    pub fn count_up_to_here(&mut self) {
        let Some(Loops {
            before: Some(before),
            rounds,
        }) = self.loops.last()
        else {
            return;
        };
        let (before, rounds) = (*before, rounds.clone());
        let mut sum = self.builder.ins().uextend(I64, before);
        for (index, within) in rounds {
            let earlier = self.builder.ins().imul_imm_s(index, within as i64 + 1);
            sum = self.builder.ins().iadd(sum, earlier);
            sum = self.builder.ins().iadd_imm_s(sum, 1);
        }
        let sum = self.builder.ins().ireduce(I32, sum);
        self.set_bindings(sum);
    }
}
