//! Symbolic evaluation of rules: the updates of all steps at once.

use crate::bdd::Bdd;
use crate::encoding::Code;
use crate::error::SymbolicError;
use crate::evaluator::{Evaluator, Layer, MadeChoice, values};
use crate::fault::FaultClass;
use crate::guarded::Guarded;
use crate::truth::GuardedTruth;
use asmotion_lang::Value;
use asmotion_lang::ir::{
    AssignTarget, Binder, Counter, DomainElements, DomainId, Function, FunctionId, FunctionKind,
    Local, Origin, RoutineId, Rule, RuleNode, Slot, Term, ValueShape,
};

/// Limit for the iterations of a loop.
const MAX_ITERATIONS: usize = 1000;

/// An assignment of the variables of a `choose`, with the condition under which it is a candidate.
pub(crate) type Candidate = (Vec<(Local, Guarded)>, Bdd);

impl<'a> Evaluator<'a> {
    /// Evaluates a rule where `path` is true. Returns the part of the path on which it does not fail.
    pub fn rule(&mut self, rule: &Rule, path: &Bdd) -> Result<Bdd, SymbolicError> {
        let path = self.alive(path)?;
        if path.is_never() {
            return Ok(path);
        }
        stacker::maybe_grow(64 * 1024, 1024 * 1024, || self.rule_here(rule, &path))?;
        self.alive(&path)
    }

    fn rule_here(&mut self, rule: &Rule, path: &Bdd) -> Result<(), SymbolicError> {
        let origin = rule.origin;
        match &*rule.node {
            RuleNode::Skip => {}
            RuleNode::Update(target, value) => {
                let value = self.term(value, path)?;
                let path = self.alive(path)?;
                self.assign(target, &value, origin, &path)?;
            }
            RuleNode::Assign(target, routine, arguments) => {
                let value = self.result(*routine, arguments, origin, path)?;
                let path = self.alive(path)?;
                if let Some(target) = target {
                    self.assign(target, &value, origin, &path)?;
                }
            }
            RuleNode::Call(routine, arguments) => {
                let arguments = self.terms(arguments, path)?;
                let path = self.alive(path)?;
                self.call(*routine, arguments, origin, &path)?;
            }
            RuleNode::Run(term, arguments) => {
                let rule = self.term(term, path)?;
                let path = self.alive(path)?;
                let arguments = self.terms(arguments, &path)?;
                for (value, guard) in rule.iter() {
                    let guard = self.alive(guard)?;
                    self.run(value, &arguments, origin, &guard)?;
                }
            }
            RuleNode::RunAgent(agent, arguments) => {
                let agents = self.term(agent, path)?;
                let path = self.alive(path)?;
                let arguments = self.terms(arguments, &path)?;
                for (agent, guard) in agents.iter() {
                    let guard = self.alive(guard)?;
                    self.run_agent(agent, &arguments, origin, &guard)?;
                }
            }
            RuleNode::Par(rules) => {
                let mut path = path.clone();
                for rule in rules {
                    path = self.rule(rule, &path)?;
                }
            }
            RuleNode::Seq(rules) => {
                let before = self.view.clone();
                let mut all = Layer::new();
                let mut path = path.clone();
                for rule in rules {
                    self.open();
                    path = self.rule(rule, &path)?;
                    let layer = self.close();
                    self.apply(&layer)?;
                    self.replace(&mut all, layer)?;
                }
                self.view = before;
                self.merge(all)?;
            }
            RuleNode::If(guard, then, otherwise) => {
                let truth = self.guard(guard, path)?;
                self.rule(then, &truth.yes)?;
                self.rule(otherwise, &truth.no)?;
            }
            RuleNode::Switch(subject, cases, otherwise) => {
                let subject = self.term(subject, path)?;
                let mut rest = self.alive(path)?;
                for (case, rule) in cases {
                    let (here, others) = self.case(case, &subject, &rest)?;
                    self.rule(rule, &here)?;
                    rest = others;
                }
                self.rule(otherwise, &rest)?;
            }
            RuleNode::Choose(binders, guard, body, ifnone) => {
                self.choose((binders, guard.as_ref()), body, ifnone, path)?;
            }
            RuleNode::Forall(binders, guard, body) => {
                self.each(binders, path, &mut |it, path| {
                    let truth = it.satisfied(guard.as_ref(), path)?;
                    let done = it.rule(body, &truth.yes)?;
                    it.store.or(&done, &truth.no)
                })?;
            }
            RuleNode::Let(bindings, body) => {
                let path = self.bind(bindings, path)?;
                self.rule(body, &path)?;
            }
            RuleNode::Watched(rule) => {
                self.rule(rule, path)?;
            }
            RuleNode::Counted(counter, rule) => {
                self.count(*counter, path)?;
                self.rule(rule, path)?;
            }
            RuleNode::While {
                guard,
                body,
                until_idle,
            } => self.repeat(guard.as_ref(), body, *until_idle, origin, path)?,
            RuleNode::Extend(..) => {
                return Err(SymbolicError::unsupported(origin, "`extend`"));
            }
            RuleNode::Local { .. } => {
                return Err(SymbolicError::unsupported(
                    origin,
                    "a rule with local functions",
                ));
            }
            RuleNode::Draw(..) => {
                let construct = "a choice from an infinite domain";
                return Err(SymbolicError::unsupported(origin, construct));
            }
            RuleNode::Act(..) => {
                return Err(SymbolicError::unsupported(
                    origin,
                    "an operation on messages",
                ));
            }
        }
        Ok(())
    }

    /// Evaluates the optional guard of variables in a rule, which must not be undef.
    pub fn satisfied(
        &mut self,
        guard: Option<&Term>,
        path: &Bdd,
    ) -> Result<GuardedTruth, SymbolicError> {
        match guard {
            Some(guard) => self.guard(guard, path),
            None => Ok(GuardedTruth {
                yes: path.clone(),
                no: self.store.never(),
                undef: self.store.never(),
            }),
        }
    }

    /// Binds variables; returns the part of the path on which this does not fail.
    pub fn bind(&mut self, bindings: &[(Local, Term)], path: &Bdd) -> Result<Bdd, SymbolicError> {
        let mut path = path.clone();
        for (local, term) in bindings {
            let value = self.term(term, &path)?;
            path = self.alive(&path)?;
            self.set_local(*local, value);
        }
        Ok(path)
    }

    /// Records that a counted rule runs.
    pub fn count(&mut self, counter: Counter, path: &Bdd) -> Result<(), SymbolicError> {
        if let Counter::Count(counter) = counter {
            let store = self.store;
            let known = self.counted.entry(counter).or_insert_with(|| store.never());
            *known = store.or(known, path)?;
        }
        Ok(())
    }

    fn assign(
        &mut self,
        target: &AssignTarget,
        value: &Guarded,
        origin: Origin,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        match target {
            AssignTarget::Slot(function, slot) if *slot < self.program.eager => {
                self.update(*function, *slot, value, origin)
            }
            AssignTarget::Slot(..) => {
                let construct = "an update of a location that is created during the run";
                Err(SymbolicError::unsupported(origin, construct))
            }
            AssignTarget::Location(function, arguments) => {
                for (arguments, guard) in self.combinations(arguments, origin, path)? {
                    let value = value.under(self.store, &guard)?;
                    if let Some(slot) = self.slot(*function, &arguments) {
                        self.update(*function, slot, &value, origin)?;
                    } else if self.is_misplaced(*function, &arguments) {
                        self.fail(FaultClass::OutsideArgument, origin, &guard)?;
                    } else {
                        let construct = "an update of a location without finitely many arguments";
                        return Err(SymbolicError::unsupported(origin, construct));
                    }
                }
                Ok(())
            }
            AssignTarget::Local(_) => Err(SymbolicError::unsupported(
                origin,
                "the assignment of a variable",
            )),
        }
    }

    /// Returns `true` if the update of a location is a fault, because an argument is outside the function's domain.
    fn is_misplaced(&self, function: FunctionId, arguments: &[Value]) -> bool {
        let Some(declared) = self.program.functions.get(function.0 as usize) else {
            return false;
        };
        let mut pairs = declared.parameters.iter().zip(arguments);
        declared.narrow
            && pairs.any(|(shape, value)| {
                let ValueShape::Domain(domain) = shape else {
                    return false;
                };
                let known = self.program.domains.get(domain.0 as usize);
                known.is_some_and(|it| !it.grows && it.elements != DomainElements::Undefined)
                    && !value.is_undef()
                    && !self.is_element(*domain, value)
            })
    }

    /// Returns `true` if the update of a location to a value is a fault, because a part of the value is outside the codomain.
    fn is_outside(&self, declared: &Function, value: &Value) -> bool {
        if let Some(domain) = declared.within {
            return !value.is_undef() && !self.is_element(domain, value);
        }
        declared.restricted
            && !self.program.compatible
            && self.has_outsider(&declared.codomain, value)
    }

    /// Returns `true` if a part of a value is outside its domain. A domain without a definition imposes no restriction.
    fn has_outsider(&self, shape: &ValueShape, value: &Value) -> bool {
        let is_element = |domain: DomainId, value: &Value| {
            let known = self.program.domains.get(domain.0 as usize);
            known.is_none_or(|it| it.elements == DomainElements::Undefined)
                || self.is_element(domain, value)
        };
        shape.outsider(value, &is_element).is_some()
    }

    fn update(
        &mut self,
        function: FunctionId,
        slot: Slot,
        value: &Guarded,
        origin: Origin,
    ) -> Result<(), SymbolicError> {
        let Some(declared) = self.program.functions.get(function.0 as usize) else {
            return Ok(());
        };
        if declared.kind == FunctionKind::Shared {
            let construct = "an update of a shared function";
            return Err(SymbolicError::unsupported(origin, construct));
        }
        let mut accepted = Guarded::default();
        for (value, guard) in value.iter() {
            if self.is_outside(declared, value) {
                self.fail(FaultClass::Outside, origin, guard)?;
            } else {
                self.note(slot, value, origin);
                accepted.add(self.store, value.clone(), guard)?;
            }
        }
        self.write(slot, &accepted, origin)
    }

    /// Adds the updates of a sequence to those around it.
    fn merge(&mut self, layer: Layer) -> Result<(), SymbolicError> {
        for (slot, written) in &layer {
            for (origin, value) in written {
                self.write(*slot, value, *origin)?;
            }
        }
        Ok(())
    }

    /// Runs a routine with these arguments.
    pub fn call(
        &mut self,
        routine: RoutineId,
        arguments: Vec<Guarded>,
        origin: Origin,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        let program = self.program;
        let Some(routine) = program.routines.get(routine.0 as usize) else {
            return Ok(());
        };
        self.enter(arguments, routine.locals, origin)?;
        let done = self.rule(&routine.code, path);
        self.leave();
        done.map(|_| ())
    }

    /// Runs a turbo rule and returns the value of `result`, which is hidden from its caller.
    fn result(
        &mut self,
        routine: RoutineId,
        arguments: &[Term],
        origin: Origin,
        path: &Bdd,
    ) -> Result<Guarded, SymbolicError> {
        let arguments = self.terms(arguments, path)?;
        let path = self.alive(path)?;
        let result = self.program.result;
        let undef = Guarded::of(Value::Undef, &self.store.always());
        let hidden = self.view.insert(result, undef);
        self.open();
        self.call(routine, arguments, origin, &path)?;
        let mut layer = self.close();
        match hidden {
            Some(hidden) => self.view.insert(result, hidden),
            None => self.view.remove(&result),
        };
        let path = self.alive(&path)?;
        let written = values(self.store, &layer.remove(&result).unwrap_or_default())?;
        let mut value = written.under(self.store, &path)?;
        let rest = self.store.without(&path, &value.defined(self.store)?)?;
        value.add(self.store, Value::Undef, &rest)?;
        self.merge(layer)?;
        Ok(value)
    }

    /// Runs a rule value with these arguments.
    fn run(
        &mut self,
        rule: &Value,
        given: &[Guarded],
        origin: Origin,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        let program = self.program;
        let known = if let Value::Rule(id) = rule {
            program.rules.get(id.0 as usize)
        } else {
            None
        };
        let Some((rule, routine)) = known.and_then(|rule| Some((rule, rule.routine?))) else {
            return self.fail(FaultClass::NotARule, origin, path);
        };
        let mut arguments = Vec::new();
        for body in &rule.arguments {
            arguments.push(self.call_body(*body, Vec::new(), origin, path)?);
        }
        arguments.extend_from_slice(given);
        let expected = program
            .routines
            .get(routine.0 as usize)
            .map(|it| it.arguments);
        if expected != Some(arguments.len() as u32) {
            return self.fail(FaultClass::RuleArity, origin, path);
        }
        if !rule.returns {
            return self.call(routine, arguments, origin, path);
        }
        self.open();
        self.call(routine, arguments, origin, path)?;
        let mut layer = self.close();
        layer.remove(&program.result);
        self.merge(layer)
    }

    /// Runs the program of an agent.
    pub fn run_agent(
        &mut self,
        agent: &Value,
        arguments: &[Guarded],
        origin: Origin,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        let Some(rule) = self.program_of(agent) else {
            return self.fail(FaultClass::NoProgram, origin, path);
        };
        let itself = Guarded::of(agent.clone(), &self.store.always());
        let outer = std::mem::replace(&mut self.agent, itself);
        let done = self.run(&Value::Rule(rule), arguments, origin, path);
        self.agent = outer;
        done
    }

    /// Returns the candidates of a `choose`, and the part of the path on which there is none.
    pub fn candidates(
        &mut self,
        (binders, guard): (&[Binder], Option<&Term>),
        path: &Bdd,
    ) -> Result<(Vec<Candidate>, Bdd), SymbolicError> {
        let mut found: Vec<Candidate> = Vec::new();
        let done = self.each(binders, path, &mut |it, path| {
            let truth = it.satisfied(guard, path)?;
            if !truth.yes.is_never() {
                let locals = binders.iter().filter_map(|binder| {
                    let value = it.local(binder.local)?;
                    Some((binder.local, value.clone()))
                });
                found.push((locals.collect(), truth.yes.clone()));
            }
            it.store.or(&truth.yes, &truth.no)
        })?;
        let mut none = done.clone();
        for (_, guard) in &mut found {
            *guard = self.store.and(guard, &done)?;
            none = self.store.without(&none, guard)?;
        }
        found.retain(|(_, guard)| !guard.is_never());
        Ok((found, none))
    }

    fn choose(
        &mut self,
        candidates: (&[Binder], Option<&Term>),
        body: &Rule,
        ifnone: &Rule,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        let (candidates, none) = self.candidates(candidates, path)?;
        if let [(locals, guard)] = candidates.as_slice() {
            for (local, value) in locals {
                self.set_local(*local, value.clone());
            }
            self.rule(body, guard)?;
        } else if !candidates.is_empty() {
            let code = Code::add(self.store, candidates.len())?;
            self.choices.push(MadeChoice {
                made: self.store.without(path, &none)?,
                code: code.clone(),
            });
            let mut other = self.store.without(path, &none)?;
            for ((_, guard), taken) in candidates.iter().zip(&code.values) {
                let guard = self.store.and(guard, taken)?;
                other = self.store.without(&other, &guard)?;
            }
            self.exclude(&other)?;
            for ((locals, guard), taken) in candidates.iter().zip(&code.values) {
                for (local, value) in locals {
                    self.set_local(*local, value.clone());
                }
                let guard = self.store.and(guard, taken)?;
                self.rule(body, &guard)?;
            }
        }
        self.rule(ifnone, &none)?;
        Ok(())
    }

    fn repeat(
        &mut self,
        guard: Option<&Term>,
        body: &Rule,
        until_idle: bool,
        origin: Origin,
        path: &Bdd,
    ) -> Result<(), SymbolicError> {
        let before = self.view.clone();
        let mut all = Layer::new();
        let mut active = path.clone();
        let mut iterations = 0;
        while !active.is_never() {
            iterations += 1;
            if iterations > MAX_ITERATIONS {
                let construct = "a loop with this many iterations";
                return Err(SymbolicError::unsupported(origin, construct));
            }
            active = self.satisfied(guard, &active)?.yes;
            self.open();
            active = self.rule(body, &active)?;
            let layer = self.close();
            if until_idle {
                let mut written = self.store.never();
                for changed in layer.values() {
                    let changed = values(self.store, changed)?;
                    written = self.store.or(&written, &changed.defined(self.store)?)?;
                }
                active = self.store.and(&active, &written)?;
            }
            self.apply(&layer)?;
            self.replace(&mut all, layer)?;
        }
        self.view = before;
        self.merge(all)
    }
}
