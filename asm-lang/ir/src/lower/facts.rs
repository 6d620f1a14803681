//! Static analysis: properties of functions and rules that hold for every call.

use super::needs::recursive;
use asmotion_hir::{
    Body, DomainKind, Function, FunctionId, FunctionKind, Meaning, Model, RuleKind, RuleTerm, Term,
    TermKind, TypeId, UpdateTarget, VarId,
};
use asmotion_value::RuleId;
use std::collections::BTreeSet;

/// The results of the analysis; least sets closed under the rules below.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Functions whose value may differ between states.
    dynamic: BTreeSet<FunctionId>,
    /// Types whose set of elements may grow, because `extend` adds to abstract domains.
    growing: BTreeSet<TypeId>,
    /// Functions whose value may depend on a monitored function or on the time.
    monitored: BTreeSet<FunctionId>,
    /// Functions whose value may depend on a monitored or shared function or on the time.
    inputs: BTreeSet<FunctionId>,
    /// Functions whose initial value may depend on one of those.
    initial_inputs: BTreeSet<FunctionId>,
    /// Variables that a rule, or a macro it calls, assigns: macro parameters that stand for
    /// locations, and variables that are turned into locations.
    assigned: BTreeSet<(RuleId, VarId)>,
    /// Rules that write `result`, directly or in a macro they call.
    returning: BTreeSet<RuleId>,
    /// Parameters whose value a rule uses in every execution.
    pub(super) needed: BTreeSet<(RuleId, VarId)>,
    /// Rules that may call themselves, directly or indirectly.
    recursive: BTreeSet<RuleId>,
    /// Rules with intermediate states (`seq`, loops), directly or in a rule they call.
    sequential: BTreeSet<RuleId>,
    /// Rules that are used as values.
    pub rule_values: BTreeSet<RuleId>,
}

impl Facts {
    pub fn of(model: &Model) -> Self {
        let growing = model.types.ids().filter(|&ty| grows(model, ty));
        let mut facts = Self {
            growing: growing.collect(),
            ..Self::default()
        };
        facts.functions(model);
        facts.rules(model);
        facts
    }

    /// Returns `true` if a function has the same value in all states.
    pub fn is_static(&self, function: FunctionId) -> bool {
        !self.dynamic.contains(&function)
    }

    /// Returns `true` if a rule assigns one of its parameters, of which there are `parameters`.
    pub fn assigns_parameter(&self, rule: RuleId, parameters: usize) -> bool {
        let parameters = (rule, VarId(0))..(rule, VarId(parameters as u32));
        self.assigned.range(parameters).next().is_some()
    }

    /// Returns `true` if a rule assigns this variable.
    pub fn assigns(&self, rule: RuleId, variable: VarId) -> bool {
        self.assigned.contains(&(rule, variable))
    }

    /// Returns `true` if a rule writes `result`.
    pub fn returns(&self, rule: RuleId) -> bool {
        self.returning.contains(&rule)
    }

    /// Returns `true` if a rule uses the value of this parameter in every execution.
    pub fn needs(&self, rule: RuleId, parameter: VarId) -> bool {
        self.needed.contains(&(rule, parameter))
    }

    /// Returns `true` if a rule may call itself.
    pub fn is_recursive(&self, rule: RuleId) -> bool {
        self.recursive.contains(&rule)
    }

    /// Returns `true` if a rule has intermediate states.
    pub fn is_sequential(&self, rule: RuleId) -> bool {
        self.sequential.contains(&rule)
    }

    /// Returns `true` if the value of a term may change during a step.
    pub fn is_dynamic(&self, term: &Term) -> bool {
        let mut ranges_over_growing = false;
        visit(term, &mut |term| {
            if let TermKind::Extent(ty) = &*term.kind {
                ranges_over_growing |= self.growing.contains(ty);
            }
            ranges_over_growing |= matches!(&*term.kind, TermKind::Element(..));
        });
        ranges_over_growing || mentions(term, &|function| self.dynamic.contains(&function))
    }

    /// Returns `true` if the initial value of a function may depend on an input.
    pub fn begins_with_input(&self, function: FunctionId) -> bool {
        self.initial_inputs.contains(&function)
    }

    /// Returns `true` if a term may depend on a monitored function or on the time.
    pub fn reads_monitored(&self, term: &Term) -> bool {
        mentions(term, &|function| self.monitored.contains(&function))
    }

    /// Returns `true` if a term may depend on an input: a monitored or shared function, or the
    /// time.
    pub fn reads_input(&self, term: &Term) -> bool {
        mentions(term, &|function| self.inputs.contains(&function))
    }

    /// Returns `true` if the value of a term in the initial state may depend on an input.
    pub fn may_begin_with_input(&self, term: &Term) -> bool {
        mentions(term, &|function| {
            self.inputs.contains(&function) || self.initial_inputs.contains(&function)
        })
    }

    fn functions(&mut self, model: &Model) {
        for (index, function) in model.functions.iter().enumerate() {
            let id = FunctionId(index as u32);
            match function.meaning {
                Meaning::State | Meaning::Machine => {
                    self.dynamic.insert(id);
                }
                Meaning::Builtin(builtin) if builtin.name.starts_with("currTime") => {
                    self.dynamic.insert(id);
                    self.inputs.insert(id);
                    self.monitored.insert(id);
                }
                Meaning::Defined(_)
                | Meaning::Builtin(_)
                | Meaning::Constant(_)
                | Meaning::Missing => {}
            }
            if matches!(
                function.kind,
                FunctionKind::Monitored | FunctionKind::Shared
            ) {
                self.inputs.insert(id);
            }
            if function.kind == FunctionKind::Monitored {
                self.monitored.insert(id);
            }
        }
        // Propagate to the functions whose definitions use these, up to the fixed point.
        loop {
            let size = |facts: &Self| {
                facts.dynamic.len()
                    + facts.inputs.len()
                    + facts.monitored.len()
                    + facts.initial_inputs.len()
            };
            let before = size(self);
            for (index, function) in model.functions.iter().enumerate() {
                let id = FunctionId(index as u32);
                if let Meaning::Defined(body) = &function.meaning {
                    if self.is_dynamic(&body.root) {
                        self.dynamic.insert(id);
                    }
                    if self.reads_input(&body.root) {
                        self.inputs.insert(id);
                    }
                    if self.reads_monitored(&body.root) {
                        self.monitored.insert(id);
                    }
                }
                for body in definition(function).into_iter().chain(&function.initial) {
                    let begins = |function| {
                        self.inputs.contains(&function) || self.initial_inputs.contains(&function)
                    };
                    if mentions(&body.root, &begins) {
                        self.initial_inputs.insert(id);
                    }
                }
            }
            if size(self) == before {
                return;
            }
        }
    }

    fn rules(&mut self, model: &Model) {
        self.rule_values
            .extend(model.programs.iter().map(|program| program.rule));
        for function in &model.functions {
            for body in definition(function).into_iter().chain(&function.initial) {
                self.rule_values_of(&body.root);
            }
        }
        for program in &model.programs {
            program
                .arguments
                .iter()
                .for_each(|argument| self.rule_values_of(&argument.root));
        }
        for body in &model.added.terms {
            self.rule_values_of(&body.root);
        }
        self.recursive = recursive(model);
        loop {
            let before = self.size();
            for (index, rule) in model.rules.iter().enumerate() {
                if let Some(body) = &rule.body {
                    let id = RuleId(index as u32);
                    self.rule(model, id, body);
                    self.needs_of(model, id, body);
                }
            }
            for (body, id) in model.added.rules.iter().zip(added_rules(model)) {
                self.rule(model, id, body);
            }
            if self.size() == before {
                return;
            }
        }
    }

    /// Returns the number of facts about rules; the fixed point is reached when it no longer grows.
    fn size(&self) -> usize {
        self.assigned.len()
            + self.sequential.len()
            + self.rule_values.len()
            + self.returning.len()
            + self.needed.len()
    }

    fn rule(&mut self, model: &Model, id: RuleId, body: &Body<RuleTerm>) {
        walk(&body.root, &mut |rule| {
            match &*rule.kind {
                RuleKind::Seq(_)
                | RuleKind::While(..)
                | RuleKind::WhileRec(..)
                | RuleKind::Iterate(_)
                | RuleKind::Local(_) => {
                    self.sequential.insert(id);
                }
                RuleKind::Update(target, _) => self.target(model, id, target),
                RuleKind::Assign(target, callee, arguments) => {
                    self.target(model, id, target);
                    self.call(model, id, *callee, arguments);
                }
                RuleKind::Call(callee, arguments) => self.call(model, id, *callee, arguments),
                // the rule is unknown until run time: assume the worst
                RuleKind::Run(..) => {
                    self.sequential.insert(id);
                }
                RuleKind::Skip
                | RuleKind::Par(_)
                | RuleKind::If(..)
                | RuleKind::Switch(..)
                | RuleKind::Choose(..)
                | RuleKind::Forall(..)
                | RuleKind::Let(..)
                | RuleKind::Extend(..)
                | RuleKind::Invalid => {}
            }
            each_term(rule, &mut |term| self.rule_values_of(term));
        });
    }

    fn rule_values_of(&mut self, term: &Term) {
        visit(term, &mut |term| {
            if let TermKind::Rule(rule) = &*term.kind {
                self.rule_values.insert(*rule);
            }
        });
    }

    fn target(&mut self, model: &Model, rule: RuleId, target: &UpdateTarget) {
        match target {
            UpdateTarget::Variable(variable) => drop(self.assigned.insert((rule, *variable))),
            UpdateTarget::Location(function, _) if model.reserved.result == Some(*function) => {
                self.returning.insert(rule);
            }
            UpdateTarget::Location(..) => {}
        }
    }

    /// Propagates the facts about a called rule to the caller. A turbo rule only passes on that it
    /// has intermediate states; its parameters and its result are local.
    fn call(&mut self, model: &Model, caller: RuleId, callee: RuleId, arguments: &[Term]) {
        if self.sequential.contains(&callee) {
            self.sequential.insert(caller);
        }
        if model.rule(callee).turbo {
            return;
        }
        if self.returning.contains(&callee) {
            self.returning.insert(caller);
        }
        for (index, argument) in (0..).zip(arguments) {
            if let TermKind::Variable(variable) = &*argument.kind
                && self.assigned.contains(&(callee, VarId(index)))
            {
                self.assigned.insert((caller, *variable));
            }
        }
    }
}

/// Returns the ids of added rules, which follow those of the declared ones.
pub(super) fn added_rules(model: &Model) -> impl Iterator<Item = RuleId> {
    (model.rules.len() as u32..).map(RuleId)
}

/// Returns the definition of a function, if it has one.
pub(super) fn definition(function: &Function) -> Option<&Body<Term>> {
    match &function.meaning {
        Meaning::Defined(body) => Some(body),
        Meaning::State
        | Meaning::Builtin(_)
        | Meaning::Constant(_)
        | Meaning::Machine
        | Meaning::Missing => None,
    }
}

/// Calls `see` for a rule and, recursively, all rules in it.
pub fn walk<'a>(rule: &'a RuleTerm, see: &mut dyn FnMut(&'a RuleTerm)) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        see(rule);
        match &*rule.kind {
            RuleKind::Par(rules) | RuleKind::Seq(rules) => {
                rules.iter().for_each(|rule| walk(rule, see))
            }
            RuleKind::If(_, then, otherwise) => {
                walk(then, see);
                otherwise.iter().for_each(|rule| walk(rule, see));
            }
            RuleKind::Switch(_, cases, otherwise) => {
                cases.iter().for_each(|(_, rule)| walk(rule, see));
                otherwise.iter().for_each(|rule| walk(rule, see));
            }
            RuleKind::Choose(_, _, body, ifnone) => {
                walk(body, see);
                ifnone.iter().for_each(|rule| walk(rule, see));
            }
            RuleKind::Local(local) => {
                local.initial.iter().for_each(|rule| walk(rule, see));
                walk(&local.body, see);
            }
            RuleKind::Forall(_, _, body)
            | RuleKind::Let(_, body)
            | RuleKind::Extend(_, _, body)
            | RuleKind::While(_, body)
            | RuleKind::WhileRec(_, body)
            | RuleKind::Iterate(body) => walk(body, see),
            RuleKind::Skip
            | RuleKind::Update(..)
            | RuleKind::Assign(..)
            | RuleKind::Call(..)
            | RuleKind::Run(..)
            | RuleKind::Invalid => {}
        }
    });
}

/// Calls `see` for the terms of a rule, without those of the rules in it.
pub(super) fn each_term(rule: &RuleTerm, see: &mut dyn FnMut(&Term)) {
    let mut all = |terms: &[Term]| terms.iter().for_each(&mut *see);
    match &*rule.kind {
        RuleKind::Update(target, value) => {
            if let UpdateTarget::Location(_, arguments) = target {
                all(arguments);
            }
            see(value);
        }
        RuleKind::Assign(target, _, arguments) => {
            if let UpdateTarget::Location(_, places) = target {
                all(places);
            }
            all(arguments);
        }
        RuleKind::Call(_, arguments) => all(arguments),
        RuleKind::Run(term, arguments) => {
            all(arguments);
            see(term);
        }
        RuleKind::If(guard, ..) | RuleKind::While(guard, _) | RuleKind::WhileRec(guard, _) => {
            see(guard);
        }
        RuleKind::Switch(subject, cases, _) => {
            cases.iter().for_each(|(case, _)| see(case));
            see(subject);
        }
        RuleKind::Choose(binders, guard, ..) | RuleKind::Forall(binders, guard, _) => {
            binders.iter().for_each(|binder| see(&binder.range));
            guard.iter().for_each(see);
        }
        RuleKind::Let(bindings, _) => bindings.iter().for_each(|(_, term)| see(term)),
        RuleKind::Skip
        | RuleKind::Par(_)
        | RuleKind::Seq(_)
        | RuleKind::Extend(..)
        | RuleKind::Iterate(_)
        | RuleKind::Local(_)
        | RuleKind::Invalid => {}
    }
}

/// Returns `true` if the set of a type's elements may grow while a machine runs.
fn grows(model: &Model, ty: TypeId) -> bool {
    let mut parts = model.types.reachable_types(ty, &model.domains);
    parts.any(|part| {
        let domain = model.types.get(part).as_domain();
        domain.is_some_and(|domain| model.domain(domain).kind == DomainKind::Abstract)
    })
}

/// Returns `true` if a term applies a function that satisfies `predicate`.
fn mentions(term: &Term, predicate: &dyn Fn(FunctionId) -> bool) -> bool {
    let mut found = false;
    visit(term, &mut |term| {
        found |= term.kind.function().is_some_and(predicate)
    });
    found
}

/// Calls `see` for a term and, recursively, all its subterms.
pub fn visit(term: &Term, see: &mut dyn FnMut(&Term)) {
    stacker::maybe_grow(64 * 1024, 1024 * 1024, || {
        see(term);
        subterms(term, &mut |term| visit(term, see));
    });
}

/// Calls `see` for the direct subterms of a term.
pub(super) fn subterms(term: &Term, see: &mut dyn FnMut(&Term)) {
    match &*term.kind {
        TermKind::Value(_)
        | TermKind::Variable(_)
        | TermKind::Rule(_)
        | TermKind::Extent(_)
        | TermKind::Element(..)
        | TermKind::Unbound
        | TermKind::Invalid => {}
        TermKind::Apply(_, terms) | TermKind::Tuple(terms) | TermKind::Listed(_, terms) => {
            terms.iter().for_each(see);
        }
        TermKind::Spread(_, tuple) => see(tuple),
        TermKind::If(guard, then, otherwise) => {
            see(guard);
            see(then);
            otherwise.iter().for_each(see);
        }
        TermKind::Switch(subject, cases, otherwise) => {
            see(subject);
            for (case, value) in cases {
                see(case);
                see(value);
            }
            otherwise.iter().for_each(see);
        }
        TermKind::Let(bindings, body) => {
            bindings.iter().for_each(|(_, term)| see(term));
            see(body);
        }
        TermKind::Quantified(_, binders, guard) => {
            binders.iter().for_each(|binder| see(&binder.range));
            guard.iter().for_each(see);
        }
        TermKind::Interval(_, from, to, step) => {
            see(from);
            see(to);
            step.iter().for_each(see);
        }
        TermKind::Comprehension(_, binders, guard, item) => {
            binders.iter().for_each(|binder| see(&binder.range));
            guard.iter().for_each(&mut *see);
            see(item);
        }
        TermKind::Map(pairs) => {
            for (key, value) in pairs {
                see(key);
                see(value);
            }
        }
        TermKind::MapComprehension(binders, guard, key, value) => {
            binders.iter().for_each(|binder| see(&binder.range));
            guard.iter().for_each(&mut *see);
            see(key);
            see(value);
        }
    }
}
