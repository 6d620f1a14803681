//! Generates code for rules.

use crate::agents::{AtomRange, routine_of};
use crate::emit::{AtomCode, EmitScope, Emitter, KnownValue, Loops, NativeInt, Ssa, UpdateMode};
use crate::frame::at;
use crate::limits::MAX_INLINED;
use crate::range_guard::RangeGuard;
use crate::static_analysis::{StaticRange, counts, is_repeatable, rule_counts};
use asmotion_ir::{
    AssignTarget, Binder, IntegerInterval, Local, Origin, RoutineId, Rule, RuleNode, Term, TermNode,
};
use asmotion_machine::back_end::{MAX_BINDINGS, MAX_CALLS, MAX_ITERATIONS};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::{I8, I32, I64};
use cranelift_codegen::ir::{Block, InstBuilder, Type};

/// A variable, its range, and the place of the range.
pub(crate) type BoundRange = (Local, StaticRange, Origin);

/// The way in which the bindings of a loop are counted against the limit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Counting {
    /// All before the loop, which runs to its end; leaves for the detour if the limit could be
    /// exceeded.
    Together,
    /// Like `Together`, but the limit has already been checked.
    Checked,
    /// One by one, in a rule; exceeding the limit is a fault.
    EachInRule,
    /// Not at all: the bindings of a direct rule are counted at compile time.
    Bounded,
    /// One by one, in a term; exceeding the limit is left to the detour.
    EachInTerm,
    /// One by one, in a rule, those that satisfy the equation that an index answers.
    Satisfying,
}

impl Emitter<'_> {
    /// Generates code for a rule; the code that follows continues after it.
    pub fn rule(&mut self, rule: &Rule) {
        stacker::maybe_grow(128 * 1024, 2 * 1024 * 1024, || self.rule_here(rule));
    }

    fn rule_here(&mut self, rule: &Rule) {
        if let RuleNode::Counted(counter, counted) = &*rule.node {
            return self.counted_rule(*counter, counted);
        }
        if !self.has_room() {
            return self.rule_outside(rule);
        }
        match &*rule.node {
            RuleNode::Skip => {}
            RuleNode::Update(place, value) => self.update(rule, place, value),
            RuleNode::Par(rules) => self.par(rule, rules),
            RuleNode::Seq(rules) => {
                let each = |this: &mut Self| rules.iter().for_each(|rule| this.rule(rule));
                if self.direct.is_some() {
                    self.sequence_directly(rule, each);
                } else {
                    self.sequence(each);
                }
            }
            RuleNode::While {
                guard,
                body,
                until_idle,
            } => {
                let guard = guard.as_ref();
                let repeat = |this: &mut Self| this.repeat(guard, body, *until_idle, rule.origin);
                if self.direct.is_some() {
                    self.sequence_directly(rule, repeat);
                } else {
                    self.sequence(repeat);
                }
            }
            RuleNode::If(guard, then, otherwise) => self.choice(guard, then, otherwise),
            RuleNode::Switch(subject, cases, otherwise) => {
                self.switch(rule, subject, cases, otherwise);
            }
            RuleNode::Let(bindings, body) => self.bound(rule, bindings, body),
            RuleNode::Call(routine, arguments) => self.build_in(rule, *routine, arguments),
            RuleNode::RunAgent(agent, arguments) => self.run_agent(rule, agent, arguments),
            RuleNode::Forall(binders, guard, body) => {
                self.as_set(|this| this.forall(rule, binders, guard.as_ref(), body));
            }
            RuleNode::Choose(binders, guard, body, ifnone) => {
                self.as_set(|this| this.choose(rule, binders, guard.as_ref(), body, ifnone));
            }
            RuleNode::Assign(..)
            | RuleNode::Run(..)
            | RuleNode::Extend(..)
            | RuleNode::Local { .. }
            | RuleNode::Draw(..)
            | RuleNode::Act(..)
            | RuleNode::Counted(..)
            | RuleNode::Watched(_) => self.rule_outside(rule),
        }
    }

    /// Returns `true` if native code supports an update.
    pub fn is_native_update(&self, place: &AssignTarget, value: &Term) -> bool {
        self.is_native(value) && self.is_place(place) && self.is_accepted(place, self.kind(value))
    }

    fn update(&mut self, rule: &Rule, place: &AssignTarget, value: &Term) {
        if !self.is_native_update(place, value) {
            return self.rule_outside(rule);
        }
        let counts = match place {
            AssignTarget::Slot(..) | AssignTarget::Local(_) => self.any_counts([value]),
            AssignTarget::Location(_, arguments) => {
                self.any_counts(arguments.iter().chain([value]))
            }
        };
        let native = |this: &mut Self| {
            let value = this.scalar(value);
            if let Some(target) = this.target(place) {
                this.check_domain(place, value);
                this.write(&target, value, rule.origin);
            }
        };
        self.straight_unit(counts, native, |this| this.rule_outside(rule));
    }

    fn par(&mut self, rule: &Rule, rules: &[Rule]) {
        match self.mode {
            UpdateMode::Step | UpdateMode::Layer => rules.iter().for_each(|rule| self.rule(rule)),
            UpdateMode::Sequence => self.par_in_sequence(rule, rules),
        }
    }

    /// Generates code for the guard of a rule, for which undef is a fault.
    pub fn guard(&mut self, guard: &Term, yes: Block, no: Block) {
        if !self.is_truth(guard) || !self.is_native(guard) {
            return self.guard_outside(guard, yes, no);
        }
        let counts = counts(self.program, guard);
        self.unit(
            counts,
            |this| this.test(guard, yes, no),
            |this| this.guard_outside(guard, yes, no),
            None,
        );
    }

    fn choice(&mut self, guard: &Term, then: &Rule, otherwise: &Rule) {
        let (yes, no, done) = (self.block(), self.block(), self.block());
        self.guard(guard, yes, no);
        self.begin(yes);
        self.conditionally(|this| this.rule(then));
        self.jump(done);
        self.begin(no);
        self.conditionally(|this| this.rule(otherwise));
        self.jump(done);
        self.begin(done);
    }

    fn bound(&mut self, rule: &Rule, bindings: &[(Local, Term)], body: &Rule) {
        let mut terms = bindings.iter().map(|(_, term)| term);
        if !terms.all(|term| is_repeatable(self.program, term)) {
            return self.rule_outside(rule);
        }
        let native = |this: &mut Self| {
            let base = this.scope.base;
            for (local, term) in bindings {
                this.scope.locals[*local as usize] = this.argument(term, base + local);
            }
            this.rule(body);
        };
        let counts = self.any_counts(bindings.iter().map(|(_, term)| term));
        self.straight_unit(counts, native, |this| this.rule_outside(rule));
    }

    /// Evaluates an argument to a register, or to the local at `place`.
    fn argument(&mut self, term: &Term, place: u32) -> KnownValue {
        if self.is_native(term) {
            return self.scalar(term);
        }
        let kind = self.kind(term);
        self.bind_outside(term, place);
        KnownValue::Memory(kind)
    }

    /// Inlines a macro into the rule that calls it.
    fn build_in(&mut self, rule: &Rule, routine: RoutineId, arguments: &[Term]) {
        let called = &self.program.routines[routine.0 as usize];
        let may_be = self.may_build_in(routine)
            && called.arguments as usize == arguments.len()
            && arguments
                .iter()
                .all(|argument| is_repeatable(self.program, argument));
        if !may_be {
            return self.rule_outside(rule);
        }
        let native = |this: &mut Self| {
            let base = this.inner_base();
            this.reserve_locals(base + arguments.len() as u32);
            let mut place = base..;
            let known: Vec<KnownValue> = arguments
                .iter()
                .zip(&mut place)
                .map(|(argument, place)| this.argument(argument, place))
                .collect();
            this.count_call();
            let outer = this.enter(routine, known);
            this.rule(&called.code);
            this.leave(outer);
        };
        let counts = self.any_counts(arguments);
        self.straight_unit(counts, native, |this| this.rule_outside(rule));
    }

    /// Counts a call; leaves for the detour if there were too many.
    fn count_call(&mut self) {
        if self.counts_call() {
            return;
        }
        let run = self.run();
        let before = self.load(self.memory.run, I32, run, at::CALLS);
        let many = self.compare(
            IntCC::UnsignedGreaterThanOrEqual,
            before,
            i64::from(MAX_CALLS),
        );
        self.bail_if(many);
        let run = self.run();
        let calls = self.builder.ins().iadd_imm_s(before, 1);
        self.store(self.memory.run, calls, run, at::CALLS);
    }

    fn may_build_in(&self, routine: RoutineId) -> bool {
        !self.program.routines[routine.0 as usize].open
            && !self.inlined.contains(&routine)
            && self.inlined.len() < MAX_INLINED
    }

    fn leave(&mut self, outer: EmitScope) {
        self.scope = outer;
        self.inlined.pop();
    }

    /// Generates code for the program of an agent, if all agents in question have the same one.
    fn run_agent(&mut self, rule: &Rule, agent: &Term, arguments: &[Term]) {
        let Some((agent, routine)) = self.one_program(agent).filter(|_| arguments.is_empty())
        else {
            return self.rule_outside(rule);
        };
        let called = &self.program.routines[routine.0 as usize];
        let native = |this: &mut Self| {
            this.count_call();
            let before = this.direct.is_none().then(|| this.set_agent(agent));
            let outer = this.enter(routine, Vec::new());
            this.scope.agent = Some(agent);
            this.rule(&called.code);
            this.leave(outer);
            if let Some(before) = before {
                this.reset_agent(before);
            }
        };
        self.straight_unit(false, native, |this| this.rule_outside(rule));
    }

    /// Stores the running agent where closures find it, and returns the previous one. That is an atom or undef, so it can
    /// be saved and restored as raw words.
    fn set_agent(&mut self, agent: AtomCode) -> [Ssa; 2] {
        let run = self.run();
        let before =
            [0, at::PAYLOAD].map(|offset| self.load(self.memory.run, I64, run, at::AGENT + offset));
        self.store_scalar(self.memory.run, run, at::AGENT, KnownValue::Atom(agent));
        before
    }

    fn reset_agent(&mut self, before: [Ssa; 2]) {
        let run = self.run();
        for (word, offset) in before.into_iter().zip([0, at::PAYLOAD]) {
            self.store(self.memory.run, word, run, at::AGENT + offset);
        }
    }

    /// Returns the agent, in a register, and the only routine that can be its program.
    fn one_program(&self, agent: &Term) -> Option<(AtomCode, RoutineId)> {
        let TermNode::Local(local) = &*agent.node else {
            return None;
        };
        let Some(KnownValue::Atom(agent)) = self.scope.locals.get(*local as usize) else {
            return None;
        };
        let routine = routine_of(self.program, agent.among?)?;
        let called = &self.program.routines[routine.0 as usize];
        (called.arguments == 0 && self.may_build_in(routine)).then_some((*agent, routine))
    }

    fn forall(&mut self, rule: &Rule, binders: &[Binder], guard: Option<&Term>, body: &Rule) {
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
            this.each(&spans, counting, &mut |this, next| {
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

    /// Continues only if the guard holds; otherwise jumps.
    pub fn guarded(&mut self, guard: Option<&Term>, otherwise: Block) {
        if let Some(guard) = guard {
            let holds = self.block();
            self.guard(guard, holds, otherwise);
            self.begin(holds);
        }
    }

    /// Generates code for `choose`: counts the candidates, then enumerates them again up to the
    /// chosen one.
    fn choose(
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
            this.each(&spans, counting, &mut |this, next| {
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
        self.builder
            .ins()
            .brif(takes_first, known, &[none.into()], count_all, &[]);
        self.begin(count_all);
        let count = self.builder.declare_var(I64);
        self.builder.def_var(count, none);
        let counts = !guard.is_answered();
        self.each(spans, counting, &mut |this, next| {
            this.range_guarded(guard, counts, spans, next);
            let so_far = this.builder.use_var(count);
            let one_more = this.builder.ins().iadd_imm_s(so_far, 1);
            this.builder.def_var(count, one_more);
            this.jump(next);
        });
        let count = self.builder.use_var(count);
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
    /// must end with a jump to it or elsewhere.
    pub fn each(
        &mut self,
        spans: &[BoundRange],
        counting: Counting,
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
        self.round(spans, counting, body);
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
        self.begin(head);
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

    /// Ends the step with the fault of an endless loop if the condition holds.
    pub fn endless_if(&mut self, condition: Ssa, most: u32, origin: Origin) {
        let (many, next) = (self.cold_block(), self.block());
        self.branch(condition, many, next);
        self.begin(many);
        let most = self.number(I32, i64::from(most));
        let origin = self.number(I32, i64::from(origin.0));
        let place = self.call_position();
        self.call(self.calls.endless, &[most, origin, place]);
        self.jump(self.exit);
        self.begin(next);
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

    /// Generates a loop within a sequence.
    fn repeat(&mut self, guard: Option<&Term>, body: &Rule, until_idle: bool, origin: Origin) {
        let is_repeated = self.repeats_directly(
            |this, done| this.guarded(guard, done),
            |this| this.rule(body),
            until_idle,
        );
        if is_repeated {
            return;
        }
        let (head, done) = (self.block(), self.block());
        self.jump(head);
        self.begin(head);
        let run = self.run();
        let before = self.load(self.memory.run, I32, run, at::ITERATIONS);
        let many = self.compare(
            IntCC::UnsignedGreaterThanOrEqual,
            before,
            i64::from(MAX_ITERATIONS),
        );
        self.endless_if(many, MAX_ITERATIONS, origin);
        let run = self.run();
        let iterations = self.builder.ins().iadd_imm_s(before, 1);
        self.store(self.memory.run, iterations, run, at::ITERATIONS);
        self.guarded(guard, done);
        if !until_idle || crate::sequence::always_writes(body) {
            self.rule(body);
            self.jump(head);
        } else {
            let idle = self.layer(|this| this.rule(body));
            self.branch(idle, done, head);
        }
        self.begin(done);
    }
}

/// Returns the number of bindings made by loops over these variables.
pub(crate) fn total(spans: &[BoundRange]) -> u64 {
    spans.iter().rev().fold(0u64, |inner, (_, span, _)| {
        span.count().saturating_mul(inner.saturating_add(1))
    })
}
