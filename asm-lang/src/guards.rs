//! The guards on the way to an update, with the values that they had.

use crate::specification::Specification;
use asmotion_diagnostics::Span;
use asmotion_hir::{RuleKind, RuleTerm, Term, Variable};
use asmotion_ir::FunctionId;
use asmotion_machine::{Machine, PathEntry, StepAccount, Update};
use asmotion_value::Value;

/// A guard that was evaluated on the way to an update.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassedGuard {
    /// Text of the guard on one line; for a `switch`, an equation of its subject and the case.
    pub text: String,
    /// `true` if the guard was true; `false` if the `else` branch was taken.
    pub holds: bool,
    /// The variables and locations that the guard read, as written, with their values.
    pub values: Vec<(String, String)>,
    /// Place of the guard.
    pub place: Span,
}

/// Limit for the characters of a value; longer ones are cut.
const MAX_SHOWN: usize = 60;

impl Specification {
    /// Returns the guards on the way to the update of a location in the last step of a machine, outermost first. `before` is the
    /// machine before that step. None if the step did not update the location, or cannot be repeated.
    pub fn guards_of_update(
        &self,
        machine: &Machine,
        before: &Machine,
        function: FunctionId,
        arguments: &[Value],
    ) -> Vec<PassedGuard> {
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let slot = machine.state().slot(machine.program(), function, arguments);
        let mut updates = machine.last_step().updates().iter();
        let update = updates.find(|update| Some(update.slot) == slot);
        match (update, machine.account(before)) {
            (Some(update), Some(account)) => guards_of(self, &account, update, &show),
            (None, _) | (_, None) => Vec::new(),
        }
    }
}

/// Returns the guards on the way to an update, outermost first.
pub fn guards_of(
    specification: &Specification,
    account: &StepAccount,
    update: &Update,
    show: &dyn Fn(&Value) -> String,
) -> Vec<PassedGuard> {
    let mut updates = account.updates.iter();
    let Some((_, path)) = updates.find(|(known, _)| known == update) else {
        return Vec::new();
    };
    let spans: Vec<Span> = path
        .iter()
        .map(|entry| specification.span(entry.origin))
        .collect();
    let mut guards = Vec::new();
    for (index, entry) in path.iter().enumerate() {
        let (Some(&span), Some(&next)) = (spans.get(index), spans.get(index + 1)) else {
            break;
        };
        // a coverage counter around a rule has its place
        if next == span {
            continue;
        }
        let has_guard = |kind: &RuleKind| GuardTerm::term_of(kind).is_some();
        let Some((rule, _)) = rule_with(specification, span, &has_guard) else {
            continue;
        };
        let found = GuardTerm::of(rule, next);
        guards.extend(found.map(|guard| guard.shown(specification, entry, show)));
    }
    guards
}

/// Returns the rule with exactly this place for which a condition holds, and the variables of its body.
pub fn rule_with<'a>(
    specification: &'a Specification,
    span: Span,
    is_meant: &dyn Fn(&RuleKind) -> bool,
) -> Option<(&'a RuleTerm, &'a [Variable])> {
    let mut found = None;
    for rule in &specification.model.rules {
        let Some(body) = &rule.body else { continue };
        let root = body.root.span;
        if root.file == span.file && root.start <= span.start && span.end <= root.end {
            asmotion_ir::visit_rules(&body.root, &mut |part| {
                if part.span == span && is_meant(&part.kind) {
                    found = Some((part, body.variables.as_slice()));
                }
            });
        }
    }
    found
}

/// Returns the variables of a `choose` rule, given its place.
pub fn chosen_variables(specification: &Specification, place: Span) -> Vec<String> {
    let is_choose = |kind: &RuleKind| matches!(kind, RuleKind::Choose(..));
    let Some((rule, variables)) = rule_with(specification, place, &is_choose) else {
        return Vec::new();
    };
    let RuleKind::Choose(binders, ..) = &*rule.kind else {
        return Vec::new();
    };
    let names = binders
        .iter()
        .filter_map(|binder| variables.get(binder.variable.0 as usize));
    names.map(|variable| variable.name.to_string()).collect()
}

/// A guard, with the case for a `switch`.
struct GuardTerm<'a> {
    term: &'a Term,
    case: Option<Span>,
    holds: bool,
}

impl<'a> GuardTerm<'a> {
    /// Returns the guard of a rule, or the subject of a `switch`.
    fn term_of(kind: &RuleKind) -> Option<&Term> {
        match kind {
            RuleKind::If(term, ..)
            | RuleKind::Forall(_, Some(term), _)
            | RuleKind::While(term, _)
            | RuleKind::WhileRec(term, _)
            | RuleKind::Switch(term, ..) => Some(term),
            RuleKind::Skip
            | RuleKind::Update(..)
            | RuleKind::Assign(..)
            | RuleKind::Call(..)
            | RuleKind::Run(..)
            | RuleKind::Par(_)
            | RuleKind::Seq(_)
            | RuleKind::Choose(..)
            | RuleKind::Forall(_, None, _)
            | RuleKind::Let(..)
            | RuleKind::Extend(..)
            | RuleKind::Iterate(_)
            | RuleKind::Local(_)
            | RuleKind::Invalid => None,
        }
    }

    /// Returns the guard of a rule whose execution went on at a place.
    fn of(rule: &'a RuleTerm, next: Span) -> Option<Self> {
        let is_in = |part: &RuleTerm| {
            let part = part.span;
            part.file == next.file && part.start <= next.start && next.end <= part.end
        };
        let term = Self::term_of(&rule.kind)?;
        let mut case = None;
        let mut holds = true;
        if let RuleKind::If(_, then, _) = &*rule.kind {
            holds = is_in(then);
        } else if let RuleKind::Switch(_, cases, _) = &*rule.kind {
            let taken = cases.iter().find(|(_, body)| is_in(body));
            case = taken.map(|(case, _)| case.span);
            // in `otherwise`, no case says what the subject is
            holds = case.is_some();
        }
        Some(Self { term, case, holds })
    }

    fn shown(
        &self,
        specification: &Specification,
        entry: &PathEntry,
        show: &dyn Fn(&Value) -> String,
    ) -> PassedGuard {
        let text = |span| on_one_line(specification, span);
        let place = self.term.span;
        let mut values: Vec<(String, String)> = Vec::new();
        for (origin, value) in &entry.reads {
            let span = specification.span(*origin);
            let is_inside =
                span.file == place.file && place.start <= span.start && span.end <= place.end;
            let (name, value) = (text(span), cut(show(value)));
            let is_known = values.iter().any(|(known, _)| *known == name);
            if is_inside && !is_known && !name.is_empty() && name != value {
                values.push((name, value));
            }
        }
        let guard = text(place);
        let guard = match self.case {
            Some(case) => format!("{guard} = {}", text(case)),
            None => guard,
        };
        PassedGuard {
            text: guard,
            holds: self.holds,
            values,
            place,
        }
    }
}

/// Returns the text of a place with single blanks.
pub fn on_one_line(specification: &Specification, place: Span) -> String {
    let words: Vec<&str> = specification
        .sources
        .snippet(place)
        .split_whitespace()
        .collect();
    words.join(" ")
}

fn cut(text: String) -> String {
    match text.char_indices().nth(MAX_SHOWN) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or_default()),
        None => text,
    }
}
