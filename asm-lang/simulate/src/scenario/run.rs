//! Executes the actions of a scenario.

use super::choices::PickedChoices;
use super::inputs::HeldInputs;
use super::plan::{PlannedCondition, ScenarioAction, ScenarioActionKind, ScenarioPlan};
use super::verdict::{ScenarioFailure, ScenarioFailureKind, ScenarioOutcome, Verdict};
use crate::failed_condition::FailedCondition;
use asmotion_diagnostics::Span;
use asmotion_hir::{AddedRule, AddedTerm, Assignment};
use asmotion_ir::{FunctionKind, Origin};
use asmotion_machine::{Machine, StepFault};
use asmotion_value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Options for running a scenario.
#[derive(Clone, Copy, Debug)]
pub struct ScenarioOptions {
    /// Seed for all choices without a pick.
    pub seed: u64,
    /// Limit for the steps of one `step until`.
    pub max_steps: u64,
    /// Nanoseconds by which clocks advance in each step.
    pub period_ns: i64,
}

impl Default for ScenarioOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            max_steps: 100_000,
            period_ns: 1_000_000_000,
        }
    }
}

/// Executes a plan on a machine whose program includes the plan's terms. `origins` are the spans of
/// the program's origins.
pub fn run(
    plan: &ScenarioPlan,
    machine: &mut Machine,
    origins: &[Span],
    options: &ScenarioOptions,
) -> ScenarioOutcome {
    let mut running = ScenarioRun {
        plan,
        machine,
        ranges: ranges(plan, origins),
        inputs: HeldInputs::new(),
        choices: PickedChoices::new(options.seed),
        options,
        steps: 0,
        checks: 0,
        failures: Vec::new(),
        begun: false,
    };
    for action in &plan.actions {
        if running.action(action).is_err() {
            break;
        }
    }
    running.end();
    ScenarioOutcome {
        verdict: running.verdict(),
        steps: running.steps,
        checks: running.checks,
        failures: running.failures,
    }
}

/// Returns the origins of the ranges that a `pick` refers to.
fn ranges(plan: &ScenarioPlan, origins: &[Span]) -> BTreeMap<Span, Origin> {
    let mut expected: BTreeSet<Span> = BTreeSet::new();
    for action in &plan.actions {
        if let ScenarioActionKind::Pick { ranges, .. } = &action.kind {
            expected.extend(ranges);
        }
    }
    let known = origins.iter().enumerate();
    known
        .filter(|(_, span)| expected.contains(span))
        .map(|(index, span)| (*span, Origin(index as u32)))
        .collect()
}

/// Ends the scenario early; the failure was recorded.
struct ScenarioEnded;

struct ScenarioRun<'a> {
    plan: &'a ScenarioPlan,
    machine: &'a mut Machine,
    /// The origins of ranges in picks. A `choose` in unreachable code has none.
    ranges: BTreeMap<Span, Origin>,
    inputs: HeldInputs,
    choices: PickedChoices,
    options: &'a ScenarioOptions,
    steps: u64,
    checks: u64,
    failures: Vec<ScenarioFailure>,
    /// `true` once the initial state was checked.
    begun: bool,
}

impl ScenarioRun<'_> {
    fn action(&mut self, action: &ScenarioAction) -> Result<(), ScenarioEnded> {
        let at = action.span;
        match &action.kind {
            ScenarioActionKind::Set(assignment) => self.set(assignment, at),
            ScenarioActionKind::Check(condition) => self.check(condition, at),
            ScenarioActionKind::Step => {
                self.begin(at)?;
                self.step(at)?;
                self.choices.forget();
                Ok(())
            }
            ScenarioActionKind::StepUntil(condition) => {
                self.begin(at)?;
                self.step_until(condition, at)?;
                self.choices.forget();
                Ok(())
            }
            ScenarioActionKind::Exec(rule) => self.exec(*rule, at),
            ScenarioActionKind::Pick { ranges, value } => self.pick(ranges, *value, at),
        }
    }

    /// Checks the invariants after the commands that follow the last step.
    fn end(&mut self) {
        if self.failures.is_empty()
            && let (true, Some(last)) = (self.begun, self.plan.actions.last())
            && self.invariants(last.span).is_ok()
        {
            let now = self.now();
            let checked = self.machine.check_invariants(&mut self.inputs, now);
            // a violation is recorded as a failure
            let _ = self.done(checked, last.span);
        }
    }

    fn set(&mut self, assignment: &Assignment, at: Span) -> Result<(), ScenarioEnded> {
        let now = self.now();
        let assigned = self.machine.assigned(assignment, &mut self.inputs, now);
        let (function, arguments, value) = self.done(assigned, at)?;
        let set = self.machine.set(function, &arguments, value.clone());
        self.done(set, at)?;
        let kind = self.machine.program().functions[function.0 as usize].kind;
        if kind == FunctionKind::Monitored {
            self.inputs.set(function, &arguments, value);
        }
        Ok(())
    }

    fn check(&mut self, condition: &PlannedCondition, at: Span) -> Result<(), ScenarioEnded> {
        let value = self.value(condition.term, at)?;
        if value == Value::Bool(true) {
            self.checks += 1;
        } else {
            let seen = self.seen(condition, &value);
            self.fail(at, ScenarioFailureKind::Check(seen));
        }
        Ok(())
    }

    /// Checks the initial state before the first step. Returns an error after a failed check, so
    /// that no further step is executed.
    fn begin(&mut self, at: Span) -> Result<(), ScenarioEnded> {
        if !self.failures.is_empty() {
            return Err(ScenarioEnded);
        }
        if !self.begun {
            self.begun = true;
            self.invariants(at)?;
        }
        Ok(())
    }

    fn step(&mut self, at: Span) -> Result<(), ScenarioEnded> {
        let now = self.now();
        let stepped = self.machine.step(&mut self.inputs, &mut self.choices, now);
        let stepped = stepped.map(|_| ());
        self.done(stepped, at)?;
        self.steps += 1;
        self.invariants(at)
    }

    fn step_until(&mut self, condition: &PlannedCondition, at: Span) -> Result<(), ScenarioEnded> {
        let limit = self.options.max_steps;
        for _ in 0..limit {
            if self.value(condition.term, at)? == Value::Bool(true) {
                return Ok(());
            }
            self.step(at)?;
        }
        let value = self.value(condition.term, at)?;
        if value == Value::Bool(true) {
            return Ok(());
        }
        let seen = self.seen(condition, &value);
        self.fail(at, ScenarioFailureKind::Until(limit, seen));
        Err(ScenarioEnded)
    }

    fn exec(&mut self, rule: AddedRule, at: Span) -> Result<(), ScenarioEnded> {
        let now = self.now();
        let fired = self
            .machine
            .fire(rule, &mut self.inputs, &mut self.choices, now);
        let fired = fired.map(|_| ());
        self.done(fired, at)?;
        self.hold_inputs();
        Ok(())
    }

    /// Holds the values that a rule of the scenario wrote to monitored locations.
    fn hold_inputs(&mut self) {
        let (state, program) = (self.machine.state(), self.machine.program());
        for update in self.machine.last_step().updates() {
            if let Some((function, arguments)) = state.location(program, update.slot)
                && program.functions[function.0 as usize].kind == FunctionKind::Monitored
            {
                self.inputs.set(function, &arguments, update.value.clone());
            }
        }
    }

    fn pick(&mut self, ranges: &[Span], value: AddedTerm, at: Span) -> Result<(), ScenarioEnded> {
        let value = self.value(value, at)?;
        for range in ranges {
            if let Some(&origin) = self.ranges.get(range) {
                self.choices.pick(origin, value.clone());
            }
        }
        Ok(())
    }

    fn invariants(&mut self, at: Span) -> Result<(), ScenarioEnded> {
        let plan = self.plan;
        for invariant in &plan.invariants {
            let value = self.value(invariant.condition.term, at)?;
            if value != Value::Bool(true) {
                let seen = self.seen(&invariant.condition, &value);
                self.fail(
                    at,
                    ScenarioFailureKind::Invariant(invariant.name.to_string(), seen),
                );
                return Err(ScenarioEnded);
            }
        }
        Ok(())
    }

    /// Returns the time of the next step; the first one takes place after one period.
    fn now(&self) -> i64 {
        let steps = i64::try_from(self.steps + 1).unwrap_or(i64::MAX);
        steps.saturating_mul(self.options.period_ns)
    }

    fn value(&mut self, term: AddedTerm, at: Span) -> Result<Value, ScenarioEnded> {
        let now = self.now();
        let value = self.machine.evaluate(term, &mut self.inputs, now);
        self.done(value, at)
    }

    fn seen(&mut self, condition: &PlannedCondition, value: &Value) -> FailedCondition {
        let now = self.now();
        let mut parts = Vec::new();
        for &(part, span) in &condition.parts {
            // a part whose evaluation fails is left out
            if let Ok(value) = self.machine.evaluate(part, &mut self.inputs, now) {
                parts.push((span, self.show(&value)));
            }
        }
        let step = self.machine.last_step();
        let written = crate::show::updates(self.machine, &step);
        FailedCondition {
            condition: condition.span,
            value: self.show(value),
            parts,
            written: written
                .into_iter()
                .map(|(location, _, after)| format!("`{location} := {after}`"))
                .collect(),
        }
    }

    fn show(&self, value: &Value) -> String {
        value.show(&self.machine.naming()).to_string()
    }

    fn done<T>(&mut self, result: Result<T, Box<StepFault>>, at: Span) -> Result<T, ScenarioEnded> {
        result.map_err(|fault| {
            self.fail(at, ScenarioFailureKind::Fault(fault));
            ScenarioEnded
        })
    }

    fn fail(&mut self, at: Span, kind: ScenarioFailureKind) {
        self.failures.push(ScenarioFailure {
            at,
            steps: self.steps,
            kind,
        });
    }

    /// Returns the verdict, which the first failure determines.
    fn verdict(&self) -> Verdict {
        let Some(failure) = self.failures.first() else {
            return Verdict::Pass;
        };
        match &failure.kind {
            ScenarioFailureKind::Check(_) | ScenarioFailureKind::Until(..) => Verdict::Fail,
            ScenarioFailureKind::Invariant(..) => Verdict::Invariant,
            ScenarioFailureKind::Fault(fault) => Verdict::of(fault),
        }
    }
}
