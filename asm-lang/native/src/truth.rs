//! Generates code for Boolean terms, mostly as branches.

use crate::bound_range::Counting;
use crate::emit::{Emitter, KnownValue, Ssa};
use crate::static_analysis::counts;
use crate::unroll::PartCount;
use asmotion_ir::{Binder, Comparison, Connective, Quantifier, Term, TermNode, ValueKind};
use asmotion_value::{Value, layout};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::I8;
use cranelift_codegen::ir::{Block, InstBuilder};

impl Emitter<'_> {
    /// Generates a truth value in a register; leaves for the detour if it is undef.
    pub fn truth(&mut self, term: &Term) -> Ssa {
        if let TermNode::Local(local) = &*term.node {
            return match self.scope.locals.get(*local as usize) {
                Some(KnownValue::Bool(truth)) => *truth,
                _ => self.local(*local, layout::BOOL, I8),
            };
        }
        if let TermNode::Slot(..) | TermNode::Location(..) = &*term.node {
            return match self.place_of(term) {
                Some(place) => self.read(&place, layout::BOOL, I8),
                None => self.term_outside(term, layout::BOOL, I8),
            };
        }
        if let TermNode::Constant(Value::Bool(truth)) = &*term.node {
            return self.number(I8, i64::from(*truth));
        }
        let (yes, no, done) = (self.block(), self.block(), self.block());
        let result = self.builder.append_block_param(done, I8);
        self.test(term, yes, no);
        for (block, truth) in [(yes, 1), (no, 0)] {
            self.begin(block);
            let truth = self.number(I8, truth);
            self.jump_with(done, truth);
        }
        self.begin(done);
        result
    }

    /// Generates a branch on a truth value; leaves for the detour if it is undef.
    ///
    /// A connective with an undef operand may still have a truth value, which the detour computes.
    pub fn test(&mut self, term: &Term, yes: Block, no: Block) {
        let unfolded = self.unfolded(term, |this, value| this.test(value, yes, no));
        if unfolded.is_some() {
            return;
        }
        match &*term.node {
            TermNode::Constant(Value::Bool(truth)) => self.jump(if *truth { yes } else { no }),
            TermNode::Not(operand) if self.is_truth(operand) => self.test(operand, no, yes),
            TermNode::Logic(logic, left, right) if self.is_truth(left) && self.is_truth(right) => {
                self.logic(*logic, left, right, yes, no);
            }
            TermNode::Compare(comparison, left, right)
                if self.is_integer(left) && self.is_integer(right) =>
            {
                let (left, right) = (self.integer(left), self.integer(right));
                let condition = match comparison {
                    Comparison::Lt => IntCC::SignedLessThan,
                    Comparison::Le => IntCC::SignedLessThanOrEqual,
                    Comparison::Gt => IntCC::SignedGreaterThan,
                    Comparison::Ge => IntCC::SignedGreaterThanOrEqual,
                };
                let holds = self.builder.ins().icmp(condition, left.value, right.value);
                self.branch(holds, yes, no);
            }
            TermNode::Equal(left, right) => self.equal(term, left, right, yes, no),
            TermNode::Quantified(quantifier, binders, guard) => {
                self.quantified(term, *quantifier, binders, guard.as_ref(), yes, no);
            }
            TermNode::If(guard, then, otherwise)
                if self.is_truth(guard) && self.is_truth(then) && self.is_truth(otherwise) =>
            {
                let (first, second) = (self.block(), self.block());
                self.test(guard, first, second);
                self.begin(first);
                self.test(then, yes, no);
                self.begin(second);
                self.test(otherwise, yes, no);
            }
            TermNode::Local(_) | TermNode::Slot(..) | TermNode::Location(..) => {
                let truth = self.truth(term);
                self.branch(truth, yes, no);
            }
            TermNode::Constant(_)
            | TermNode::Agent
            | TermNode::Call(..)
            | TermNode::Cached(..)
            | TermNode::Builtin(..)
            | TermNode::Logic(..)
            | TermNode::Not(_)
            | TermNode::Compare(..)
            | TermNode::Arithmetic(..)
            | TermNode::Tuple(_)
            | TermNode::Component(..)
            | TermNode::If(..)
            | TermNode::Switch(..)
            | TermNode::Let(..)
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
            | TermNode::Named(..) => self.truth_outside(term, yes, no),
        }
    }

    fn logic(&mut self, logic: Connective, left: &Term, right: &Term, yes: Block, no: Block) {
        let next = self.block();
        match logic {
            Connective::And => self.test(left, next, no),
            Connective::Or => self.test(left, yes, next),
            Connective::Implies => self.test(left, next, yes),
            Connective::Xor | Connective::Iff => {
                let (left, right) = (self.truth(left), self.truth(right));
                let condition = match logic {
                    Connective::Xor => IntCC::NotEqual,
                    Connective::And | Connective::Or | Connective::Implies | Connective::Iff => {
                        IntCC::Equal
                    }
                };
                let holds = self.builder.ins().icmp(condition, left, right);
                return self.branch(holds, yes, no);
            }
        }
        self.begin(next);
        self.test(right, yes, no);
    }

    fn equal(&mut self, term: &Term, left: &Term, right: &Term, yes: Block, no: Block) {
        for (one, other) in [(left, right), (right, left)] {
            if matches!(*other.node, TermNode::Constant(Value::Undef))
                && let Some(place) = self.place_of(one)
                && !place.is_lazy
            {
                let tag = self.tag(&place);
                let is_undef = self.compare(IntCC::Equal, tag, i64::from(layout::UNDEF));
                return self.branch(is_undef, yes, no);
            }
        }
        let kind = self.kind(left);
        if kind != self.kind(right) {
            return self.truth_outside(term, yes, no);
        }
        let (left, right) = match kind {
            ValueKind::Int => (self.integer(left).value, self.integer(right).value),
            ValueKind::Atom => (self.atom(left).value, self.atom(right).value),
            ValueKind::Bool => (self.truth(left), self.truth(right)),
            ValueKind::Real | ValueKind::Other => return self.truth_outside(term, yes, no),
        };
        let same = self.builder.ins().icmp(IntCC::Equal, left, right);
        self.branch(same, yes, no);
    }

    /// Generates code for a quantifier, which ends with the first assignment that decides it.
    fn quantified(
        &mut self,
        term: &Term,
        quantifier: Quantifier,
        binders: &[Binder],
        guard: Option<&Term>,
        yes: Block,
        no: Block,
    ) {
        let decided = match quantifier {
            Quantifier::Forall => no,
            Quantifier::Exists => yes,
            Quantifier::ExistsUnique => return self.truth_outside(term, yes, no),
        };
        let undecided = if decided == yes { no } else { yes };
        let (Some(spans), Some(guard)) = (self.spans(binders), guard) else {
            return self.truth_outside(term, yes, no);
        };
        let counting = if counts(self.program, guard) {
            Counting::EachInTerm
        } else {
            Counting::Together
        };
        let parts = PartCount::of_term(self.program, guard);
        self.each(&spans, counting, Some(parts), &mut |this, next| {
            let found = this.block();
            if this.is_truth(guard) {
                match quantifier {
                    Quantifier::Forall => this.test(guard, next, found),
                    Quantifier::Exists | Quantifier::ExistsUnique => this.test(guard, found, next),
                }
            } else {
                this.bail();
            }
            this.begin(found);
            this.count_up_to_here();
            this.jump(decided);
        });
        self.jump(undecided);
    }
}
