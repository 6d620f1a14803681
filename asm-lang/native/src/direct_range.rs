//! Ranges in direct rules: loops over a residue class, and `choose` that evaluates each guard once.

use crate::atoms::AtomRange;
use crate::bound_range::{BoundRange, Counting, total};
use crate::direct_frame::PICKED;
use crate::emit::{AtomCode, Emitter, KnownValue, Loops, NativeInt, Ssa};
use crate::range_guard::RangeGuard;
use crate::static_analysis::StaticRange;
use crate::unroll::PartCount;
use asmotion_ir::{
    Arithmetic, IntegerInterval, Local, Origin, Term, TermNode, ValueKind, first_conjunct,
};
use asmotion_value::Value;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I32, I64};
use cranelift_codegen::ir::{Block, InstBuilder};

/// Limit for the number of candidates that are kept in the bits of a word.
const MAX_BITS: u64 = 64;

/// A guard `$i mod k = t and rest`, where *t* does not depend on the variable.
pub(crate) struct ResidueGuard<'t> {
    modulus: i64,
    residue: &'t Term,
    rest: Option<Term>,
}

impl Emitter<'_> {
    /// In a direct rule, returns a guard of a variable over natural numbers as one that selects a residue class.
    pub fn residue_guard<'t>(
        &self,
        spans: &[BoundRange],
        guard: &RangeGuard<'t>,
    ) -> Option<ResidueGuard<'t>> {
        self.direct.as_ref()?;
        let (&[(local, StaticRange::Ints(0.., _), _)], RangeGuard::Term(guard)) = (spans, guard)
        else {
            return None;
        };
        let (equation, rest) = first_conjunct(guard);
        let TermNode::Equal(left, right) = &*equation.node else {
            return None;
        };
        let sides: [(&'t Term, &'t Term); 2] = [(left, right), (right, left)];
        let (modulus, residue) = sides.into_iter().find_map(|(one, other)| {
            let modulus = modulus_of(one, local)?;
            self.is_invariant(other, local).then_some((modulus, other))
        })?;
        Some(ResidueGuard {
            modulus,
            residue,
            rest,
        })
    }

    /// Returns `true` if an integer does not depend on a variable, and evaluating it does not give up.
    fn is_invariant(&self, term: &Term, variable: Local) -> bool {
        match &*term.node {
            TermNode::Constant(Value::Int(_)) => true,
            TermNode::Local(local) => {
                let known = self.scope.locals.get(*local as usize);
                *local != variable && matches!(known, Some(KnownValue::Int(_)))
            }
            TermNode::Slot(function, _) => {
                !self.is_input(*function) && self.value_fact(*function).is_always(ValueKind::Int)
            }
            TermNode::Arithmetic(Arithmetic::Mod, left, right) => {
                matches!(&*right.node, TermNode::Constant(Value::Int(1..)))
                    && self.is_invariant(left, variable)
            }
            TermNode::Constant(_)
            | TermNode::Agent
            | TermNode::Location(..)
            | TermNode::Call(..)
            | TermNode::Cached(..)
            | TermNode::Builtin(..)
            | TermNode::Logic(..)
            | TermNode::Not(_)
            | TermNode::Equal(..)
            | TermNode::Compare(..)
            | TermNode::Arithmetic(..)
            | TermNode::Tuple(_)
            | TermNode::Component(..)
            | TermNode::If(..)
            | TermNode::Switch(..)
            | TermNode::Let(..)
            | TermNode::Quantified(..)
            | TermNode::Listed(..)
            | TermNode::Interval(..)
            | TermNode::Collect(..)
            | TermNode::Map(_)
            | TermNode::CollectMap(..)
            | TermNode::Extent(_)
            | TermNode::Unbound
            | TermNode::Program(_)
            | TermNode::Pre(_)
            | TermNode::Watched(_)
            | TermNode::Name(_)
            | TermNode::Named(..) => false,
        }
    }

    /// Generates a loop over the numbers of a range that satisfy the guard. The others count as bindings as well, at compile
    /// time.
    pub fn each_of_residue(
        &mut self,
        spans: &[BoundRange],
        guard: &ResidueGuard<'_>,
        body: &mut dyn FnMut(&mut Self),
    ) {
        let &[(local, StaticRange::Ints(low, high), _)] = spans else {
            return;
        };
        if !self.counts_bindings(spans) || low > high {
            return;
        }
        let (modulus, count) = (
            guard.modulus,
            spans.iter().map(|(_, span, _)| span.count()).sum(),
        );
        let residue = self.integer(guard.residue).value;
        let (head, next, done) = (self.block(), self.block(), self.block());
        let value = self.builder.append_block_param(head, I64);
        let (inside, start) = (self.block(), self.block());
        let none = self.compare(IntCC::UnsignedGreaterThanOrEqual, residue, modulus);
        self.branch(none, done, inside);
        self.begin(inside);
        // the least number of the class that is not below `low`
        let base = low - low % modulus;
        let first = self.builder.ins().iadd_imm_s(residue, base);
        let later = self.builder.ins().iadd_imm_s(first, modulus);
        let is_below = self.compare(IntCC::SignedLessThan, first, low);
        let first = self.builder.ins().select(is_below, later, first);
        let is_above = self.compare(IntCC::SignedGreaterThan, first, high);
        self.branch(is_above, done, start);
        self.begin(start);
        self.jump_with(head, first);
        self.begin_loop(head);
        let outer = self.scope.locals[local as usize];
        let interval = IntegerInterval { low, high };
        self.scope.locals[local as usize] = KnownValue::Int(NativeInt::new(value, interval));
        self.loops.push(Loops {
            before: None,
            rounds: Vec::new(),
        });
        self.repeated(count, |this| {
            this.guarded(guard.rest.as_ref(), next);
            this.conditionally(&mut *body);
            this.jump(next);
        });
        self.loops.pop();
        self.scope.locals[local as usize] = outer;
        self.begin(next);
        let successor = self.builder.ins().iadd_imm_s(value, modulus);
        let is_last = self.compare(IntCC::SignedGreaterThan, successor, high);
        self.builder
            .ins()
            .brif(is_last, done, &[], head, &[successor.into()]);
        self.begin(done);
    }

    /// Returns `true` if the candidates of a `choose` can be kept in a word, so that each guard is evaluated once.
    pub fn keeps_candidates(&self, spans: &[BoundRange], guard: &RangeGuard<'_>) -> bool {
        let [(_, span, _)] = spans else {
            return false;
        };
        let is_known = match span {
            StaticRange::Ints(..) | StaticRange::Atoms(..) => true,
            StaticRange::Bools | StaticRange::Extent(_) => false,
        };
        self.direct.is_some() && is_known && !guard.is_always() && total(spans) <= MAX_BITS
    }

    /// Generates a `choose` whose candidates are kept in a word; the code that follows is executed if there are none.
    pub fn choose_by_bits(
        &mut self,
        spans: &[BoundRange],
        guard: &RangeGuard<'_>,
        origin: Origin,
        done: Block,
        body: impl FnOnce(&mut Self),
    ) {
        let &[(local, span, range)] = spans else {
            return;
        };
        // other code binds all variables twice: to count the candidates, and to find one
        self.counts_bindings(spans);
        let bits = self.candidate_bits(spans, guard);
        let (some, none) = (self.block(), self.block());
        let range = self.number(I32, i64::from(range.0));
        let count = self.builder.ins().popcnt(bits);
        let origin = self.number(I32, i64::from(origin.0));
        let chosen = match self.call(self.calls.decide, &[range, count, origin]) {
            Some(chosen) => chosen,
            None => self.number(I64, 0),
        };
        let is_picked = self.compare(IntCC::Equal, chosen, PICKED as i64);
        self.bail_if(is_picked);
        self.branch(bits, some, none);
        self.begin(some);
        let index = self.bit_of_number(bits, chosen);
        // within the range even if the host were wrong
        let last = self.number(I64, total(spans).saturating_sub(1) as i64);
        let index = self.builder.ins().umin(index, last);
        let outer = self.scope.locals[local as usize];
        self.scope.locals[local as usize] = match span {
            StaticRange::Ints(low, high) => {
                let value = self.builder.ins().iadd_imm_s(index, low);
                KnownValue::Int(NativeInt::new(value, IntegerInterval { low, high }))
            }
            StaticRange::Atoms(first, count) => {
                let index = self.builder.ins().ireduce(I32, index);
                KnownValue::Atom(AtomCode {
                    value: self.builder.ins().iadd_imm_s(index, i64::from(first)),
                    among: Some(AtomRange::Atoms(first, count)),
                })
            }
            StaticRange::Bools | StaticRange::Extent(_) => KnownValue::Nothing,
        };
        self.conditionally(body);
        self.scope.locals[local as usize] = outer;
        self.jump(done);
        self.begin(none);
    }

    /// Generates a word with a bit for each candidate.
    fn candidate_bits(&mut self, spans: &[BoundRange], guard: &RangeGuard<'_>) -> Ssa {
        let bits = self.builder.declare_var(I64);
        let none = self.number(I64, 0);
        self.builder.def_var(bits, none);
        let parts = PartCount::of_guard(self.program, guard);
        self.each(spans, Counting::Bounded, Some(parts), &mut |this, next| {
            this.range_guarded(guard, false, spans, next);
            let index = this.innermost_index();
            let one = this.number(I64, 1);
            let bit = this.builder.ins().ishl(one, index);
            let so_far = this.builder.use_var(bits);
            let more = this.builder.ins().bor(so_far, bit);
            this.builder.def_var(bits, more);
            this.jump(next);
        });
        self.builder.use_var(bits)
    }

    /// Returns the number of completed iterations of the innermost loop.
    fn innermost_index(&mut self) -> Ssa {
        let innermost = self.loops.last().and_then(|loops| loops.rounds.last());
        match innermost {
            Some((index, _)) => *index,
            None => self.number(I64, 0),
        }
    }

    /// Generates the index of the lowest bit of a word after removing this number of lower ones.
    fn bit_of_number(&mut self, bits: Ssa, number: Ssa) -> Ssa {
        let (head, more, done) = (self.block(), self.block(), self.block());
        let rest = self.builder.append_block_param(head, I64);
        let left = self.builder.append_block_param(head, I64);
        self.advance_updates();
        self.builder.ins().jump(head, &[bits.into(), number.into()]);
        self.begin_loop(head);
        self.branch(left, more, done);
        self.begin(more);
        let below = self.builder.ins().iadd_imm_s(rest, -1);
        let fewer = self.builder.ins().band(rest, below);
        let next = self.builder.ins().iadd_imm_s(left, -1);
        self.builder.ins().jump(head, &[fewer.into(), next.into()]);
        self.begin(done);
        self.builder.ins().ctz(rest)
    }
}

/// Returns the modulus of `$i mod k`.
fn modulus_of(term: &Term, variable: Local) -> Option<i64> {
    let TermNode::Arithmetic(Arithmetic::Mod, left, right) = &*term.node else {
        return None;
    };
    match (&*left.node, &*right.node) {
        (TermNode::Local(local), TermNode::Constant(Value::Int(modulus @ 2..=1_000_000)))
            if *local == variable =>
        {
            Some(*modulus)
        }
        _ => None,
    }
}
