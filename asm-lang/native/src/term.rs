//! Generates code for terms whose values are integers or atoms.

use crate::atoms::AtomRange;
use crate::emit::{AtomCode, Emitter, KnownValue, NativeInt};
use crate::static_analysis::counts;
use asmotion_ir::{Arithmetic, IntegerInterval, Term, TermNode, ValueKind};
use asmotion_value::{Value, layout};
use cranelift_codegen::ir::InstBuilder;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I32, I64};

impl Emitter<'_> {
    /// Generates code for a term that satisfies [`Emitter::is_native`].
    pub fn scalar(&mut self, term: &Term) -> KnownValue {
        match self.kind(term) {
            ValueKind::Int => KnownValue::Int(self.integer(term)),
            ValueKind::Bool => KnownValue::Bool(self.truth(term)),
            ValueKind::Atom => KnownValue::Atom(self.atom(term)),
            ValueKind::Real | ValueKind::Other => KnownValue::Nothing,
        }
    }

    /// Returns `true` if evaluating one of these terms counts bindings.
    pub fn any_counts<'t>(&self, terms: impl IntoIterator<Item = &'t Term>) -> bool {
        let mut terms = terms.into_iter();
        terms.any(|term| counts(self.program, term))
    }

    /// Generates code for an integer; leaves for the detour if it is undef.
    pub fn integer(&mut self, term: &Term) -> NativeInt {
        let anything = |value| NativeInt::new(value, IntegerInterval::ANY);
        if let Some(int) = self.unfolded(term, |this, value| this.integer(value)) {
            return int;
        }
        match &*term.node {
            TermNode::Constant(Value::Int(number)) => {
                let value = self.number(I64, *number);
                NativeInt::new(value, IntegerInterval::of(*number))
            }
            TermNode::Local(local) => match self.scope.locals.get(*local as usize) {
                Some(KnownValue::Int(int)) => *int,
                _ => anything(self.local(*local, layout::INT, I64)),
            },
            TermNode::Arithmetic(operation, left, right)
                if self.is_integer(left) && self.is_integer(right) =>
            {
                let left = self.integer(left);
                let right = self.integer(right);
                self.arithmetic(*operation, left, right)
            }
            TermNode::If(guard, then, otherwise)
                if self.is_truth(guard) && self.is_integer(then) && self.is_integer(otherwise) =>
            {
                let (yes, no, done) = (self.block(), self.block(), self.block());
                let result = self.builder.append_block_param(done, I64);
                self.test(guard, yes, no);
                self.begin(yes);
                let then = self.integer(then);
                self.jump_with(done, then.value);
                self.begin(no);
                let otherwise = self.integer(otherwise);
                self.jump_with(done, otherwise.value);
                self.begin(done);
                NativeInt {
                    is_proven: then.is_proven && otherwise.is_proven,
                    ..NativeInt::new(result, then.interval.or(otherwise.interval))
                }
            }
            TermNode::Slot(..) | TermNode::Location(..) => match self.place_of(term) {
                Some(place) => {
                    let value = self.read(&place, layout::INT, I64);
                    NativeInt {
                        is_proven: false,
                        ..NativeInt::new(value, self.value_fact(place.function).integers())
                    }
                }
                None => anything(self.term_outside(term, layout::INT, I64)),
            },
            TermNode::Constant(_)
            | TermNode::Agent
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
            | TermNode::Named(..) => anything(self.term_outside(term, layout::INT, I64)),
        }
    }

    /// Generates code for an atom; leaves for the detour if it is undef.
    pub fn atom(&mut self, term: &Term) -> AtomCode {
        let anything = |value| AtomCode { value, among: None };
        if let Some(atom) = self.unfolded(term, |this, value| this.atom(value)) {
            return atom;
        }
        match &*term.node {
            TermNode::Constant(Value::Atom(atom)) => AtomCode {
                value: self.number(I32, i64::from(atom.0)),
                among: Some(AtomRange::Atoms(atom.0, 1)),
            },
            TermNode::Local(local) => match self.scope.locals.get(*local as usize) {
                Some(KnownValue::Atom(atom)) => *atom,
                _ => anything(self.local(*local, layout::ATOM, I32)),
            },
            TermNode::Agent => match self.scope.agent {
                Some(agent) => agent,
                None => anything(self.term_outside(term, layout::ATOM, I32)),
            },
            TermNode::Slot(..) | TermNode::Location(..) => match self.place_of(term) {
                Some(place) => anything(self.read(&place, layout::ATOM, I32)),
                None => anything(self.term_outside(term, layout::ATOM, I32)),
            },
            TermNode::Constant(_)
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
            | TermNode::Named(..) => anything(self.term_outside(term, layout::ATOM, I32)),
        }
    }

    /// Loads a local that a closure has stored in memory.
    pub fn local(
        &mut self,
        local: asmotion_ir::Local,
        tag: u8,
        ty: cranelift_codegen::ir::Type,
    ) -> crate::emit::Ssa {
        let locals = self.field(I64, crate::frame::at::LOCALS);
        let offset = self.local_offset(local);
        self.expect(self.memory.locals, locals, offset, tag, ty)
    }

    pub fn is_integer(&self, term: &Term) -> bool {
        self.kind(term) == ValueKind::Int
    }

    pub fn is_truth(&self, term: &Term) -> bool {
        self.kind(term) == ValueKind::Bool
    }

    fn arithmetic(
        &mut self,
        operation: Arithmetic,
        left: NativeInt,
        right: NativeInt,
    ) -> NativeInt {
        let (interval, overflows) =
            IntegerInterval::computed(operation, left.interval, right.interval);
        let fails = match operation {
            Arithmetic::Mod => right.interval.low <= 0,
            Arithmetic::Plus | Arithmetic::Minus | Arithmetic::Mult => overflows,
        };
        let constant = NativeInt {
            is_proven: left.is_proven && right.is_proven,
            ..NativeInt::new(left.value, interval)
        };
        if let (false, Some(constant)) = (fails, constant.constant()) {
            let value = self.number(I64, constant);
            return NativeInt::new(value, interval);
        }
        let (a, b) = (left.value, right.value);
        let value = match (operation, overflows) {
            (Arithmetic::Plus, false) => self.builder.ins().iadd(a, b),
            (Arithmetic::Minus, false) => self.builder.ins().isub(a, b),
            (Arithmetic::Mult, false) => self.builder.ins().imul(a, b),
            (Arithmetic::Plus, true) => self.checked_sum(left, right),
            (Arithmetic::Minus, true) => {
                let (value, over) = self.builder.ins().ssub_overflow(a, b);
                self.bail_if(over);
                value
            }
            (Arithmetic::Mult, true) => {
                let (value, over) = self.builder.ins().smul_overflow(a, b);
                self.bail_if(over);
                value
            }
            (Arithmetic::Mod, _) => self.modulo(left, right),
        };
        let mut int = NativeInt {
            is_proven: left.is_proven && right.is_proven,
            ..NativeInt::new(value, interval)
        };
        // indices that differ by a constant share an address computation
        let constant = right.interval;
        if !overflows && constant.low == constant.high {
            let (root, offset) = left.root;
            let offset = match operation {
                Arithmetic::Plus => offset.checked_add(constant.low),
                Arithmetic::Minus => offset.checked_sub(constant.low),
                Arithmetic::Mult | Arithmetic::Mod => None,
            };
            if let Some(offset) = offset {
                int.root = (root, offset);
            }
        }
        int
    }

    /// Generates a sum; leaves for the detour if it exceeds 64 bits.
    fn checked_sum(&mut self, left: NativeInt, right: NativeInt) -> crate::emit::Ssa {
        let (summand, constant) = match (left.constant(), right.constant()) {
            (_, Some(constant)) => (left.value, constant),
            (Some(constant), None) => (right.value, constant),
            (None, None) => {
                let ins = self.builder.ins();
                let (value, over) = ins.sadd_overflow(left.value, right.value);
                self.bail_if(over);
                return value;
            }
        };
        // a comparison takes fewer instructions than the overflow flag
        let value = self.builder.ins().iadd_imm_s(summand, constant);
        let beyond = if constant < 0 {
            IntCC::SignedGreaterThan
        } else {
            IntCC::SignedLessThan
        };
        let over = self.builder.ins().icmp(beyond, value, summand);
        self.bail_if(over);
        value
    }

    /// Generates code for the remainder, which has the sign of the dividend.
    fn modulo(&mut self, left: NativeInt, right: NativeInt) -> crate::emit::Ssa {
        let (a, b) = (left.value, right.value);
        let divisor = right.interval;
        if divisor.low == divisor.high && divisor.low > 0 {
            if left.interval.within(0, divisor.low.saturating_mul(2) - 1) {
                // one subtraction suffices
                let less = self.builder.ins().isub(a, b);
                let enough = self
                    .builder
                    .ins()
                    .icmp(IntCC::SignedGreaterThanOrEqual, a, b);
                return self.builder.ins().select(enough, less, a);
            }
            return match left.interval.low {
                0.. => self.natural_remainder(left, divisor.low),
                _ => self.builder.ins().srem(a, b),
            };
        }
        if divisor.low <= 0 {
            // zero and negative divisors are rare and left to the detour
            let odd = self.compare(IntCC::SignedLessThanOrEqual, b, 0);
            self.bail_if(odd);
        }
        if left.interval.low >= 0 {
            return self.builder.ins().urem(a, b);
        }
        // unsigned division is faster, and most dividends are not negative
        let (positive, negative, done) = (self.block(), self.cold_block(), self.block());
        let result = self.builder.append_block_param(done, I64);
        let is_negative = self.compare(IntCC::SignedLessThan, a, 0);
        self.branch(is_negative, negative, positive);
        self.begin(positive);
        let rest = self.builder.ins().urem(a, b);
        self.jump_with(done, rest);
        self.begin(negative);
        let rest = self.builder.ins().srem(a, b);
        self.jump_with(done, rest);
        self.begin(done);
        result
    }

    /// Generates the remainder of a natural number and a positive constant, without a division if the number is small enough.
    fn natural_remainder(&mut self, dividend: NativeInt, divisor: i64) -> crate::emit::Ssa {
        let number = dividend.value;
        if divisor.count_ones() == 1 {
            return self.builder.ins().band_imm_s(number, divisor - 1);
        }
        let Some((factor, shift)) = reciprocal(dividend.interval.high, divisor) else {
            let divisor = self.number(I64, divisor);
            return self.builder.ins().urem(number, divisor);
        };
        let quotient = self.builder.ins().imul_imm_s(number, factor);
        let quotient = self.builder.ins().ushr_imm_u(quotient, i64::from(shift));
        let multiple = self.builder.ins().imul_imm_s(quotient, divisor);
        self.builder.ins().isub(number, multiple)
    }
}

/// Returns a factor and a number of bits so that, for each number from 0 to `highest`, the product with the factor, of 64 bits,
/// shifted right by the bits is the quotient by a positive divisor.
///
/// With factor `(2ˢ + e) / d`, the product of *a* exceeds `2ˢ · a / d` by `a · e / d`, which does not reach the next multiple of
/// 2ˢ if `a · e < 2ˢ`.
fn reciprocal(highest: i64, divisor: i64) -> Option<(i64, u32)> {
    let (highest, divisor) = (u128::try_from(highest).ok()?, u128::try_from(divisor).ok()?);
    (1..63).find_map(|shift| {
        let power = 1u128 << shift;
        let factor = power / divisor + 1;
        let excess = factor * divisor - power;
        let is_exact = highest * excess < power && highest * factor < 1 << 64;
        let factor = i64::try_from(factor).ok().filter(|_| is_exact)?;
        Some((factor, shift))
    })
}

#[cfg(test)]
mod tests {
    use super::reciprocal;

    #[test]
    fn a_reciprocal_gives_the_quotient_of_each_number() {
        let highest = [1, 6, 7, 100, 1009, 65_535, 1 << 20, 1 << 31, (1 << 40) + 3];
        let divisors = [
            1,
            3,
            5,
            6,
            7,
            11,
            100,
            1000,
            1009,
            134_456,
            1_000_003,
            1 << 33,
        ];
        let mut found = 0;
        for highest in highest {
            for divisor in divisors {
                let Some((factor, shift)) = reciprocal(highest, divisor) else {
                    continue;
                };
                found += 1;
                // the quotient changes at multiples only
                let step = (highest / divisor / 1000).max(1);
                let multiples = (0..=highest / divisor).step_by(step as usize);
                let near = multiples.flat_map(|it| [it * divisor, it * divisor - 1]);
                for number in near
                    .chain([highest])
                    .filter(|it| (0..=highest).contains(it))
                {
                    let product = (number as u64).checked_mul(factor as u64);
                    let quotient = product.map(|it| it >> shift);
                    assert_eq!(
                        quotient,
                        Some((number / divisor) as u64),
                        "{number} / {divisor}"
                    );
                }
            }
        }
        assert!(found > 80, "{found}");
    }
}
