//! Locations of `Real` to which every step adds a constant, so that an exploration cannot end.

use crate::codes::m014::SteadyGrowth;
use asmotion_lang::Value;
use asmotion_lang::hir::{
    FunctionId, Meaning, Model, RuleKind, RuleTerm, Term, TermKind, Type, UpdateTarget,
};
use asmotion_lang::value::RuleId;
use std::collections::BTreeSet;

/// Returns the first location that grows in every step.
pub(crate) fn steady_growth(model: &Model) -> Option<SteadyGrowth> {
    let mut steps = EveryStep {
        model,
        called: BTreeSet::new(),
        updates: Vec::new(),
    };
    steps.call(model.main?);
    let mut updates = steps.updates.into_iter();
    updates.find_map(|(rule, function, value)| {
        let declared = model.function(function);
        let is_real = matches!(model.types.get(declared.codomain), Type::Real);
        let grows = is_real
            && declared.parameters.is_empty()
            && declared.initial.is_some()
            && is_shifted(model, function, value)
            && updates_of(model, function) == 1;
        grows.then(|| SteadyGrowth {
            function: declared.name.to_string(),
            at: rule.span,
            declared: declared.span,
        })
    })
}

/// The updates that every step makes.
struct EveryStep<'m> {
    model: &'m Model,
    called: BTreeSet<u32>,
    updates: Vec<(&'m RuleTerm, FunctionId, &'m Term)>,
}

impl<'m> EveryStep<'m> {
    fn call(&mut self, rule: RuleId) {
        let declared = self.model.rule(rule);
        if let Some(body) = &declared.body
            && declared.act.is_none()
            && self.called.insert(rule.0)
        {
            self.rule(&body.root);
        }
    }

    fn rule(&mut self, rule: &'m RuleTerm) {
        if let RuleKind::Update(UpdateTarget::Location(function, _), value) = &*rule.kind {
            self.updates.push((rule, *function, value));
        } else if let RuleKind::Par(rules) | RuleKind::Seq(rules) = &*rule.kind {
            rules.iter().for_each(|it| self.rule(it));
        } else if let RuleKind::Let(_, body) = &*rule.kind {
            self.rule(body);
        } else if let RuleKind::Call(rule, _) = &*rule.kind {
            self.call(*rule);
        }
    }
}

/// Returns `true` for the function plus or minus a constant other than zero.
fn is_shifted(model: &Model, function: FunctionId, value: &Term) -> bool {
    let TermKind::Apply(operator, operands) = &*value.kind else {
        return false;
    };
    let [left, right] = operands.as_slice() else {
        return false;
    };
    let is_builtin = matches!(model.function(*operator).meaning, Meaning::Builtin(_));
    let is_it = |term: &Term| matches!(&*term.kind, TermKind::Apply(read, arguments) if *read == function && arguments.is_empty());
    // a sum with a tiny constant soon has the value of the location
    let is_constant = |term: &Term| matches!(&*term.kind, TermKind::Value(Value::Real(real)) if real.get().abs() > 1e-6);
    let (is_sum, is_difference) = match &*model.function(*operator).name {
        "plus" => (is_builtin, false),
        "minus" => (false, is_builtin),
        _ => (false, false),
    };
    is_it(left) && is_constant(right) && (is_sum || is_difference)
        || is_sum && is_constant(left) && is_it(right)
}

/// Number of updates of a function in all rules. An update of a parameter counts for every function.
fn updates_of(model: &Model, function: FunctionId) -> usize {
    let bodies = model.rules.iter().filter_map(|it| it.body.as_ref());
    bodies.map(|body| updates_in(&body.root, function)).sum()
}

fn updates_in(rule: &RuleTerm, function: FunctionId) -> usize {
    let target = |target: &UpdateTarget| match target {
        UpdateTarget::Location(updated, _) => usize::from(*updated == function),
        UpdateTarget::Variable(_) => 1,
    };
    let inside = |rule: &RuleTerm| updates_in(rule, function);
    match &*rule.kind {
        RuleKind::Skip | RuleKind::Call(..) | RuleKind::Invalid => 0,
        // the rule may be any
        RuleKind::Run(..) => 1,
        RuleKind::Update(updated, _) | RuleKind::Assign(updated, ..) => target(updated),
        RuleKind::Par(rules) | RuleKind::Seq(rules) => rules.iter().map(inside).sum(),
        RuleKind::If(_, then, otherwise) => inside(then) + otherwise.as_ref().map_or(0, inside),
        RuleKind::Switch(_, cases, otherwise) => {
            let cases: usize = cases.iter().map(|(_, rule)| inside(rule)).sum();
            cases + otherwise.as_ref().map_or(0, inside)
        }
        RuleKind::Choose(_, _, body, otherwise) => {
            inside(body) + otherwise.as_ref().map_or(0, inside)
        }
        RuleKind::Forall(_, _, body)
        | RuleKind::Let(_, body)
        | RuleKind::Extend(_, _, body)
        | RuleKind::While(_, body)
        | RuleKind::WhileRec(_, body)
        | RuleKind::Iterate(body) => inside(body),
        RuleKind::Local(local) => {
            let initial: usize = local.initial.iter().map(inside).sum();
            initial + inside(&local.body)
        }
    }
}
