//! Generates code for `switch`.

use crate::emit::{Emitter, KnownValue, Ssa};
use asmotion_ir::{Rule, Term, TermNode};
use asmotion_value::Value;
use cranelift_codegen::ir::Block;
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_frontend::Switch;

/// Number of cases from which on a `switch` uses a table.
const MIN_TABLE: usize = 4;

impl Emitter<'_> {
    /// Generates code for `switch`, comparing the subject with constant cases in order.
    pub fn switch(
        &mut self,
        rule: &Rule,
        subject: &Term,
        cases: &[(Term, Rule)],
        otherwise: &Rule,
    ) {
        let is_constant = |(case, _): &(Term, Rule)| matches!(*case.node, TermNode::Constant(_));
        if !self.is_native(subject) || !cases.iter().all(is_constant) {
            return self.rule_outside(rule);
        }
        let end = self.end.take();
        let done = end.unwrap_or_else(|| self.block());
        let native = |this: &mut Self| {
            let subject = this.scalar(subject);
            if let Some(table) = this.case_table(subject, cases, done) {
                this.begin(table);
            } else {
                this.case_chain(subject, cases, done);
            }
            this.conditionally(|this| this.rule_until(otherwise, done));
        };
        let outside = |this: &mut Self| {
            this.rule_outside(rule);
            this.jump(done);
        };
        let counts = self.any_counts([subject]);
        self.unit(counts, native, outside, None);
        if end.is_none() {
            self.begin(done);
        }
    }

    /// Generates comparisons with the cases in order; the code that follows is executed if there is none.
    fn case_chain(&mut self, subject: KnownValue, cases: &[(Term, Rule)], done: Block) {
        for (case, rule) in cases {
            let Some(same) = self.is_case(subject, case) else {
                continue;
            };
            let (here, next) = (self.block(), self.block());
            self.branch(same, here, next);
            self.begin(here);
            self.conditionally(|this| this.rule_until(rule, done));
            self.begin(next);
        }
    }

    /// Generates a table of many cases, and returns the block for none of them.
    fn case_table(
        &mut self,
        subject: KnownValue,
        cases: &[(Term, Rule)],
        done: Block,
    ) -> Option<Block> {
        if cases.len() < MIN_TABLE {
            return None;
        }
        let value = match subject {
            KnownValue::Int(int) => int.value,
            KnownValue::Atom(atom) => atom.value,
            KnownValue::Nothing | KnownValue::Bool(_) | KnownValue::Memory(_) => return None,
        };
        let mut table = Switch::new();
        let mut rules = Vec::new();
        for (case, rule) in cases {
            let TermNode::Constant(constant) = &*case.node else {
                return None;
            };
            let key = match (subject, constant) {
                // as the bits that the register holds
                (KnownValue::Int(_), Value::Int(number)) => u128::from(*number as u64),
                (KnownValue::Atom(_), Value::Atom(atom)) => u128::from(atom.0),
                _ => continue,
            };
            // the first of equal cases applies
            if !table.entries().contains_key(&key) {
                let here = self.block();
                table.set_entry(key, here);
                rules.push((here, rule));
            }
        }
        let none = self.block();
        self.advance_updates();
        table.emit(&mut self.builder, value, none);
        for (here, rule) in rules {
            self.begin(here);
            self.conditionally(|this| this.rule_until(rule, done));
        }
        Some(none)
    }

    /// Generates the comparison of a subject with a case; `None` if they can never be equal.
    fn is_case(&mut self, subject: KnownValue, case: &Term) -> Option<Ssa> {
        let TermNode::Constant(value) = &*case.node else {
            return None;
        };
        let (subject, value) = match (subject, value) {
            (KnownValue::Int(int), Value::Int(number)) => (int.value, *number),
            (KnownValue::Atom(known), Value::Atom(atom)) => (known.value, i64::from(atom.0)),
            (KnownValue::Bool(known), Value::Bool(truth)) => (known, i64::from(*truth)),
            _ => return None,
        };
        Some(self.compare(IntCC::Equal, subject, value))
    }
}
