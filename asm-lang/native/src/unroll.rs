//! Unrolls short loops of direct rules: each iteration becomes code of its own, in which the variable is a constant.

use crate::atoms::AtomRange;
use crate::bound_range::{BoundRange, Counting, total};
use crate::emit::{AtomCode, Emitter, KnownValue, NativeInt};
use crate::limits::{MAX_UNROLLED, MAX_UNROLLED_PARTS};
use crate::range_guard::RangeGuard;
use crate::static_analysis::StaticRange;
use asmotion_ir::{IntegerInterval, Program, Rule, RuleNode, Term, TermNode};
use cranelift_codegen::ir::Block;
use cranelift_codegen::ir::types::{I8, I32, I64};

/// Number of parts of a rule or term, with those of the definitions that it applies, up to a limit.
#[derive(Clone, Copy)]
pub(crate) struct PartCount {
    limit: u64,
    parts: u64,
}

impl PartCount {
    /// Parts of the guard of a range.
    pub fn of_guard(program: &Program, guard: &RangeGuard<'_>) -> Self {
        let mut count = Self {
            limit: MAX_UNROLLED_PARTS,
            parts: 1,
        };
        match guard {
            RangeGuard::Always => {}
            RangeGuard::Term(guard) => count.add_term(program, guard),
            RangeGuard::Indexed(guard) => {
                count.add_term(program, guard.equation);
                if let Some(rest) = &guard.rest {
                    count.add_term(program, rest);
                }
            }
        }
        count
    }

    /// Parts of a term.
    pub fn of_term(program: &Program, term: &Term) -> Self {
        Self::of_guard(program, &RangeGuard::Term(term))
    }

    /// Adds the parts of a rule.
    #[must_use]
    pub fn with_rule(mut self, program: &Program, rule: &Rule) -> Self {
        self.add_rule(program, rule);
        self
    }

    fn add_rule(&mut self, program: &Program, rule: &Rule) {
        // ends at the limit, so that a recursive rule does, too
        rule.any(&mut |rule| {
            self.parts += 1;
            for term in rule.node.terms() {
                self.add_term(program, term);
            }
            if let RuleNode::Call(routine, _) = &*rule.node
                && self.parts <= self.limit
                && let Some(called) = program.routines.get(routine.0 as usize)
            {
                self.add_rule(program, &called.code);
            }
            self.parts > self.limit
        });
    }

    fn add_term(&mut self, program: &Program, term: &Term) {
        self.parts += 1;
        if self.parts > self.limit {
            return;
        }
        if let TermNode::Call(body, _) = &*term.node
            && let Some(body) = program.bodies.get(body.0 as usize)
        {
            self.add_term(program, &body.code);
        }
        for part in term.node.terms() {
            self.add_term(program, part);
        }
    }
}

impl Emitter<'_> {
    /// Returns `true` if loops over these variables are unrolled. `parts` is the size of an iteration.
    pub fn is_unrolled(&self, spans: &[BoundRange], counting: Counting, parts: PartCount) -> bool {
        let is_short = spans.iter().all(|(_, span, _)| match span {
            StaticRange::Ints(..) | StaticRange::Atoms(..) | StaticRange::Bools => true,
            StaticRange::Extent(_) => false,
        });
        counting == Counting::Bounded
            && is_short
            && total(spans) <= MAX_UNROLLED
            && total(spans).saturating_mul(parts.parts) <= MAX_UNROLLED_PARTS
    }

    /// Generates the iterations of nested loops one after the other.
    pub fn unrolled(&mut self, spans: &[BoundRange], body: &mut dyn FnMut(&mut Self, Block)) {
        let Some((&(local, span, _), inner)) = spans.split_first() else {
            return;
        };
        for index in 0..span.count() {
            let next = self.block();
            let known = self.known_element(span, index as i64);
            let outer = std::mem::replace(&mut self.scope.locals[local as usize], known);
            let number = self.number(I64, index as i64);
            if let Some(loops) = self.loops.last_mut() {
                loops.rounds.push((number, total(inner)));
            }
            if inner.is_empty() {
                body(self, next);
            } else {
                self.unrolled(inner, body);
                self.jump(next);
            }
            if let Some(loops) = self.loops.last_mut() {
                loops.rounds.pop();
            }
            self.scope.locals[local as usize] = outer;
            self.begin(next);
        }
    }

    /// Returns an element of a range as a constant.
    fn known_element(&mut self, span: StaticRange, index: i64) -> KnownValue {
        match span {
            StaticRange::Ints(low, _) => {
                let value = self.number(I64, low + index);
                KnownValue::Int(NativeInt::new(value, IntegerInterval::of(low + index)))
            }
            StaticRange::Atoms(first, _) => {
                let atom = first + index as u32;
                KnownValue::Atom(AtomCode {
                    value: self.number(I32, atom.into()),
                    among: Some(AtomRange::Atoms(atom, 1)),
                })
            }
            StaticRange::Bools => KnownValue::Bool(self.number(I8, index)),
            StaticRange::Extent(_) => KnownValue::Nothing,
        }
    }
}
