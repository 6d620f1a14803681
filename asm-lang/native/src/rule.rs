//! Generates code for rules.

use crate::emit::{EmitScope, Emitter, KnownValue, Ssa, UpdateMode};
use crate::frame::at;
use crate::limits::MAX_INLINED;
use crate::static_analysis::{counts, is_repeatable};
use asmotion_ir::{AssignTarget, Counter, Local, Origin, RoutineId, Rule, RuleNode, Term};
use asmotion_machine::back_end::{MAX_CALLS, MAX_ITERATIONS};
use cranelift_codegen::ir::condcodes::IntCC;
use cranelift_codegen::ir::types::I32;
use cranelift_codegen::ir::{Block, InstBuilder};

impl Emitter<'_> {
    /// Generates code for a rule; the code that follows continues after it.
    pub fn rule(&mut self, rule: &Rule) {
        let end = self.end.take();
        // these end with rules that can jump there themselves
        let ends_itself = matches!(
            &*rule.node,
            RuleNode::If(..)
                | RuleNode::Switch(..)
                | RuleNode::Par(_)
                | RuleNode::Let(..)
                | RuleNode::Call(..)
                | RuleNode::Counted(Counter::Count(_), _)
        );
        let is_passed = ends_itself && self.mode == UpdateMode::Step;
        self.end = end.filter(|_| is_passed);
        stacker::maybe_grow(128 * 1024, 2 * 1024 * 1024, || self.rule_here(rule));
        let unpassed = end.filter(|_| !is_passed);
        if let Some(end) = unpassed.or_else(|| self.end.take()) {
            self.jump(end);
        }
    }

    /// Generates code for a rule, which ends with a jump. In a direct rule, a branch at its end jumps there at once.
    pub fn rule_until(&mut self, rule: &Rule, end: Block) {
        if self.direct.is_some() {
            self.end = Some(end);
            self.rule(rule);
        } else {
            self.rule(rule);
            self.jump(end);
        }
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
            UpdateMode::Step | UpdateMode::Layer => {
                let Some((last, others)) = rules.split_last() else {
                    return;
                };
                let end = self.end.take();
                others.iter().for_each(|rule| self.rule(rule));
                self.end = end;
                self.rule(last);
            }
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
        let end = self.end.take();
        let done = end.unwrap_or_else(|| self.block());
        let yes = self.block();
        let is_skipped = matches!(&*otherwise.node, RuleNode::Skip);
        let no = (!is_skipped).then(|| self.block());
        self.guard(guard, yes, no.unwrap_or(done));
        self.begin(yes);
        self.conditionally(|this| this.rule_until(then, done));
        if let Some(no) = no {
            self.begin(no);
            self.conditionally(|this| this.rule_until(otherwise, done));
        }
        if end.is_none() {
            self.begin(done);
        }
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
    pub fn count_call(&mut self) {
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

    pub fn may_build_in(&self, routine: RoutineId) -> bool {
        !self.program.routines[routine.0 as usize].open
            && !self.inlined.contains(&routine)
            && self.inlined.len() < MAX_INLINED
    }

    pub fn leave(&mut self, outer: EmitScope) {
        self.scope = outer;
        self.inlined.pop();
    }

    /// Continues only if the guard holds; otherwise jumps.
    pub fn guarded(&mut self, guard: Option<&Term>, otherwise: Block) {
        if let Some(guard) = guard {
            let holds = self.block();
            self.guard(guard, holds, otherwise);
            self.begin(holds);
        }
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
        self.begin_loop(head);
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
