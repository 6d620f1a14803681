//! Compilation of rules.

use super::Compiler;
use super::location::SlotCode;
use super::pick::Candidates;
use super::range::Ranges;
use crate::fault::FaultKind;
use crate::messages::PerformedAction;
use crate::record::{StepChoice, TakenCandidate};
use crate::run::code::RuleCode;
use crate::run::{CodomainCheck, KleeneTruth, RuleStopped, StepContext};
use asmotion_ir::{AssignTarget, Endless, Local, Origin, RoutineId, Rule, RuleNode, Term};
use asmotion_value::{RuleId, Value};
use std::ops::ControlFlow;

/// Compiled left-hand side of an update.
enum StoreTarget {
    Location {
        slot: SlotCode,
        codomain: CodomainCheck,
        origin: Origin,
    },
    Local(Local),
}

impl StoreTarget {
    fn write(&self, run: &mut StepContext<'_>, value: Value) -> Result<(), RuleStopped> {
        match self {
            Self::Location {
                slot,
                codomain,
                origin,
            } => {
                let slot = slot(run);
                run.write(slot, value, *codomain, *origin)
            }
            Self::Local(local) => {
                run.set_local(*local, value);
                run.checked()
            }
        }
    }
}

impl Compiler<'_> {
    /// Compiles a rule to code that collects its updates.
    pub fn rule(&self, rule: &Rule) -> RuleCode {
        self.rules.set(self.rules.get() + 1);
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule))
    }

    fn rule_here(&self, rule: &Rule) -> RuleCode {
        let origin = rule.origin;
        match &*rule.node {
            RuleNode::Skip => Box::new(|_| Ok(())),
            RuleNode::Update(place, value) => self.update(place, value, origin),
            RuleNode::Assign(place, routine, arguments) => {
                self.assign(place.as_ref(), *routine, arguments, origin)
            }
            RuleNode::Call(routine, arguments) => self.call(*routine, arguments),
            RuleNode::Run(term, arguments) => self.run(term, arguments, origin),
            RuleNode::RunAgent(agent, arguments) => self.run_agent(agent, arguments, origin),
            RuleNode::Par(rules) => self.par(rules),
            RuleNode::Seq(rules) => self.seq(rules),
            RuleNode::If(guard, then, otherwise) => self.branch(guard, then, otherwise),
            RuleNode::Switch(subject, cases, otherwise) => self.switch(subject, cases, otherwise),
            RuleNode::Choose(binders, guard, body, ifnone) => self.choose(
                self.rule_ranges(binders, guard.as_ref()),
                body,
                ifnone,
                origin,
            ),
            RuleNode::Forall(binders, guard, body) => {
                self.forall(self.rule_ranges(binders, guard.as_ref()), body)
            }
            RuleNode::Let(bindings, body) => {
                let (bindings, body) = (self.bindings(bindings), self.rule(body));
                Box::new(move |run| {
                    bindings.bind(run);
                    run.checked()?;
                    body(run)
                })
            }
            RuleNode::Extend(domain, locals, body) => {
                let (domain, locals, body) = (*domain, locals.clone(), self.rule(body));
                Box::new(move |run| {
                    for &local in &locals {
                        let atom = run.state.store.fresh(run.program, domain);
                        run.updates.extended.push((domain, atom));
                        run.set_local(local, Value::Atom(atom));
                    }
                    body(run)
                })
            }
            RuleNode::Watched(rule) => self.watched_rule(rule),
            RuleNode::Counted(counter, rule) => self.counted_rule(*counter, rule),
            RuleNode::While {
                guard,
                body,
                until_idle,
            } => self.repeat(guard.as_ref(), body, *until_idle, origin),
            RuleNode::Local {
                run: number,
                initial,
                body,
            } => {
                let (number, initial, body) = (*number, self.par(initial), self.rule(body));
                Box::new(move |run| run.with_state(number, &initial, &body))
            }
            RuleNode::Draw(numbers, body) => self.draw(numbers, body, origin),
            RuleNode::Act(act, arguments) => {
                let (act, arguments) = (*act, self.terms(arguments));
                Box::new(move |run| {
                    let arguments = arguments.iter().map(|term| term(run)).collect();
                    run.checked()?;
                    run.record.performed.push(PerformedAction {
                        action: act,
                        arguments,
                        origin,
                    });
                    Ok(())
                })
            }
        }
    }

    fn target(&self, place: &AssignTarget, origin: Origin) -> StoreTarget {
        let (slot, function): (SlotCode, _) = match place {
            AssignTarget::Slot(function, slot) => {
                let slot = *slot;
                (Box::new(move |_| slot), *function)
            }
            AssignTarget::Location(function, arguments) => {
                (self.slot(*function, arguments), *function)
            }
            AssignTarget::Local(local) => return StoreTarget::Local(*local),
        };
        StoreTarget::Location {
            slot,
            codomain: CodomainCheck::of(self.program, function),
            origin,
        }
    }

    fn update(&self, place: &AssignTarget, value: &Term, origin: Origin) -> RuleCode {
        let value = self.term(value);
        if let AssignTarget::Slot(function, slot) = place {
            let (slot, codomain) = (*slot, CodomainCheck::of(self.program, *function));
            return Box::new(move |run| {
                let value = value(run);
                run.write(slot, value, codomain, origin)
            });
        }
        let target = self.target(place, origin);
        Box::new(move |run| {
            let value = value(run);
            target.write(run, value)
        })
    }

    /// Compiles `target <- r_x(…)`: the update of the target to the turbo rule's result.
    fn assign(
        &self,
        place: Option<&AssignTarget>,
        routine: RoutineId,
        arguments: &[Term],
        origin: Origin,
    ) -> RuleCode {
        let target = place.map(|place| self.target(place, origin));
        let call = self.call(routine, arguments);
        Box::new(move |run| {
            let value = run.taking_result(&call)?;
            match &target {
                Some(target) => target.write(run, value),
                None => Ok(()),
            }
        })
    }

    fn call(&self, routine: RoutineId, arguments: &[Term]) -> RuleCode {
        let arguments = self.values(arguments);
        Box::new(move |run| {
            let from = arguments.pass_arguments(run);
            run.call_routine(routine, from)
        })
    }

    fn run(&self, term: &Term, arguments: &[Term], origin: Origin) -> RuleCode {
        let term = self.term(term);
        let arguments = self.values(arguments);
        Box::new(move |run| {
            let rule = term(run);
            run.checked()?;
            let arguments_from = arguments.push_all(run);
            run_value(run, &rule, arguments_from, origin)
        })
    }

    /// Compiles `program(a)`: the agent is `self` while its program runs.
    fn run_agent(&self, agent: &Term, arguments: &[Term], origin: Origin) -> RuleCode {
        let agent = self.term(agent);
        let arguments = self.values(arguments);
        Box::new(move |run| {
            let agent = agent(run);
            run.checked()?;
            let Some(rule) = program_of(run, &agent) else {
                return Err(run.stop(FaultKind::NoProgram(agent), origin));
            };
            // the arguments are evaluated first, while `self` is still the caller
            let arguments_from = arguments.push_all(run);
            let outer = std::mem::replace(&mut run.agent, agent);
            let result = run_value(run, &Value::Rule(rule), arguments_from, origin);
            if !run.program.compatible {
                run.agent = outer;
            }
            result
        })
    }

    fn par(&self, rules: &[Rule]) -> RuleCode {
        let rules: Vec<RuleCode> = rules.iter().map(|rule| self.rule(rule)).collect();
        Box::new(move |run| rules.iter().try_for_each(|rule| rule(run)))
    }

    fn seq(&self, rules: &[Rule]) -> RuleCode {
        let rules: Vec<RuleCode> = rules.iter().map(|rule| self.rule(rule)).collect();
        Box::new(move |run| {
            let sequence = run.updates.open();
            for rule in &rules {
                let layer = run.updates.open();
                rule(run)?;
                run.apply(layer);
            }
            run.restore(sequence)
        })
    }

    /// Compiles a loop. `while` ends if its guard fails or its body yields no update, `iterate` if
    /// its body yields no update (Börger & Stärk, §4.1.1), `whilerec` if its guard fails.
    fn repeat(
        &self,
        guard: Option<&Term>,
        body: &Rule,
        until_idle: bool,
        origin: Origin,
    ) -> RuleCode {
        let guard_origin = guard.map_or(origin, |guard| guard.origin);
        let guard = guard.map(|guard| self.truth(guard));
        let body = self.rule(body);
        Box::new(move |run| {
            let sequence = run.updates.open();
            let limit = run.max_iterations();
            while run.iterations < limit {
                run.iterations += 1;
                let holds = guard.as_ref().map_or(KleeneTruth::True, |guard| guard(run));
                run.checked()?;
                match holds {
                    KleeneTruth::True => {}
                    KleeneTruth::False => return run.restore(sequence),
                    KleeneTruth::Undef => {
                        return Err(run.stop(FaultKind::UndefinedGuard, guard_origin));
                    }
                }
                let layer = run.updates.open();
                body(run)?;
                let idle = until_idle && run.updates.is_empty(&layer);
                run.apply(layer);
                if idle {
                    return run.restore(sequence);
                }
            }
            Err(run.stop(FaultKind::Endless(limit), origin))
        })
    }

    fn branch(&self, guard: &Term, then: &Rule, otherwise: &Rule) -> RuleCode {
        let origin = guard.origin;
        let guard = self.truth(guard);
        let then = self.rule(then);
        let otherwise = self.rule(otherwise);
        Box::new(move |run| {
            let holds = guard(run);
            run.checked()?;
            match holds {
                KleeneTruth::True => then(run),
                KleeneTruth::False => otherwise(run),
                KleeneTruth::Undef => Err(run.stop(FaultKind::UndefinedGuard, origin)),
            }
        })
    }

    fn switch(&self, subject: &Term, cases: &[(Term, Rule)], otherwise: &Rule) -> RuleCode {
        let subject = self.term(subject);
        let cases: Vec<_> = cases
            .iter()
            .map(|(case, rule)| (self.term(case), self.rule(rule)))
            .collect();
        let otherwise = self.rule(otherwise);
        Box::new(move |run| {
            let subject = subject(run);
            run.checked()?;
            for (case, rule) in &cases {
                if case(run) == subject {
                    return rule(run);
                }
            }
            otherwise(run)
        })
    }

    fn forall(&self, ranges: Ranges, body: &Rule) -> RuleCode {
        let body = self.rule(body);
        Box::new(move |run| {
            ranges.each(run, &mut |run| match body(run) {
                Ok(()) => ControlFlow::Continue(()),
                Err(RuleStopped) => ControlFlow::Break(()),
            });
            run.checked()
        })
    }

    /// Compiles the drawing of numbers from infinite domains, with uniform distribution.
    fn draw(&self, numbers: &[(Local, Endless, Origin)], body: &Rule, origin: Origin) -> RuleCode {
        let numbers = numbers.to_vec();
        let body = self.rule(body);
        Box::new(move |run| {
            for (local, endless, range) in &numbers {
                if let Some(picked) = run.chooser.picked(*range) {
                    if !is_number(*endless, &picked) {
                        let picked = vec![picked];
                        return Err(run.stop(FaultKind::NoCandidate(picked), origin));
                    }
                    run.set_local(*local, picked);
                    continue;
                }
                let count = count(*endless);
                let index = run.chooser.choose(count).min(count - 1);
                run.record.choices.push(StepChoice {
                    origin,
                    index,
                    count,
                });
                run.set_local(*local, number(*endless, index));
            }
            body(run)
        })
    }

    /// Compiles `choose` without storing candidates: they are counted first, then enumerated again
    /// up to the chosen one.
    fn choose(&self, ranges: Ranges, body: &Rule, ifnone: &Rule, origin: Origin) -> RuleCode {
        let body = self.rule(body);
        let ifnone = self.rule(ifnone);
        Box::new(move |run| {
            let variables = &ranges.binders;
            let ranges = Candidates::of(&ranges, run);
            let mut chosen = 0;
            let mut choice = None;
            if !run.chooser.takes_first() {
                let count = ranges.count(run);
                run.checked()?;
                if count > 0 {
                    chosen = run.chooser.choose(count).min(count - 1);
                    choice = Some(run.record.choices.len());
                    run.record.choices.push(StepChoice {
                        origin,
                        index: chosen,
                        count,
                    });
                }
            }
            let mut found = false;
            ranges.take(chosen, run, &mut |run| {
                found = true;
                if run.record.keeps_candidates {
                    let values = variables
                        .iter()
                        .map(|(local, ..)| run.local(*local).clone());
                    let values = values.collect();
                    run.record.candidates.push(TakenCandidate {
                        choice,
                        origin,
                        values,
                    });
                }
                // `checked` below finds a fault of the body
                let _ = body(run);
            });
            run.checked()?;
            match ranges.into_picked() {
                _ if found => Ok(()),
                None => ifnone(run),
                Some(picked) => Err(run.stop(FaultKind::NoCandidate(picked), origin)),
            }
        })
    }
}

/// Returns `true` if a value belongs to the infinite domain.
fn is_number(endless: Endless, value: &Value) -> bool {
    match endless {
        Endless::Integer => matches!(value, Value::Int(_)),
        Endless::Natural => matches!(value, Value::Int(0..)),
        Endless::Real => matches!(value, Value::Real(_)),
    }
}

/// Returns the size of the sample from which numbers are drawn.
fn count(endless: Endless) -> usize {
    match endless {
        Endless::Integer | Endless::Natural => 1 << 32,
        Endless::Real => 1 << 53,
    }
}

/// Returns the number at an index of the sample.
fn number(endless: Endless, index: usize) -> Value {
    let index = index as i64;
    match endless {
        // 0, 1, −1, 2, −2, …
        Endless::Integer if index % 2 == 1 => Value::Int(index / 2 + 1),
        Endless::Integer => Value::Int(-(index / 2)),
        Endless::Natural => Value::Int(index),
        Endless::Real => Value::real(index as f64 / count(endless) as f64),
    }
}

/// Returns the program of an agent, according to the domain that it was declared in or created for.
pub(super) fn program_of(run: &StepContext<'_>, agent: &Value) -> Option<RuleId> {
    let Value::Atom(atom) = agent else {
        return None;
    };
    let domain = run.state.store.domain_of(run.program, *atom)?;
    let mut programs = run.program.programs.iter();
    programs
        .find(|(of, _)| *of == domain)
        .map(|(_, rule)| *rule)
}

/// Runs a rule value. The arguments given at the call are on the stack from `arguments_from` on.
fn run_value(
    run: &mut StepContext<'_>,
    rule: &Value,
    given: usize,
    origin: Origin,
) -> Result<(), RuleStopped> {
    let program = run.program;
    let Value::Rule(id) = rule else {
        return Err(run.stop(FaultKind::NotARule(rule.clone()), origin));
    };
    let Some((rule, routine)) = program
        .rules
        .get(id.0 as usize)
        .and_then(|rule| Some((rule, rule.routine?)))
    else {
        return Err(run.stop(FaultKind::NotARule(rule.clone()), origin));
    };
    let from = run.locals.len();
    for &body in &rule.arguments {
        let end = run.locals.len();
        let argument = run.call_body(body, end);
        run.locals.push(argument);
    }
    let given = run.stack.drain(given..);
    run.locals.extend(given);
    let returns = rule.returns;
    let (wanted, actual) = (
        run.code.routines[routine.0 as usize].arguments,
        (run.locals.len() - from) as u32,
    );
    if wanted != actual {
        run.locals.truncate(from);
        return Err(run.stop(
            FaultKind::RuleArity {
                expected: wanted,
                actual,
            },
            origin,
        ));
    }
    if returns {
        run.taking_result(|run| run.call_routine(routine, from))?;
        return Ok(());
    }
    run.call_routine(routine, from)
}
