//! Mutants of a specification: copies with one small fault, as edits of its text. A property that holds for the specification and
//! is violated by a mutant *kills* it; mutants that survive show what the properties do not say.

use asmotion_diagnostics::Span;
use asmotion_lang::guards::on_one_line;
use asmotion_lang::hir::{DomainKind, Model, RuleKind, RuleTerm, Term, TermKind};
use asmotion_lang::{Specification, Value};

/// A specification with one small fault.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mutant {
    /// The place that is changed.
    pub place: Span,
    /// The text in its place.
    pub text: String,
    /// The change in words, as in "`a < 3` becomes `a <= 3`".
    pub change: String,
}

/// Operators, by the names of their functions, and what a programmer may have written instead.
const CONFUSED: &[(&str, &str)] = &[
    ("eq", "!="),
    ("neq", "="),
    ("lt", "<="),
    ("le", "<"),
    ("gt", ">="),
    ("ge", ">"),
    ("plus", "-"),
    ("minus", "+"),
];

impl Mutant {
    /// Returns the text of a file in which the place is changed.
    pub fn applied_to(&self, file: &str) -> Option<String> {
        let (start, end) = (self.place.start as usize, self.place.end as usize);
        let (before, after) = (file.get(..start)?, file.get(end..)?);
        Some(format!("{before}{}{after}", self.text))
    }
}

/// Returns the mutants of the rules in the main file of a specification, in the order of their places.
pub fn mutants(specification: &Specification) -> Vec<Mutant> {
    let model = &specification.model;
    let main = model.main.and_then(|id| model.rules.get(id.0 as usize));
    let Some(main) = main else {
        return Vec::new();
    };
    let mut mutations = Mutations {
        specification,
        mutants: Vec::new(),
    };
    for rule in &model.rules {
        if rule.span.file != main.span.file {
            continue;
        }
        if let Some(body) = &rule.body {
            asmotion_lang::ir::visit_rules(&body.root, &mut |part| mutations.rule(part));
        }
    }
    let mut mutants = mutations.mutants;
    mutants.sort();
    mutants.dedup();
    mutants
}

struct Mutations<'a> {
    specification: &'a Specification,
    mutants: Vec<Mutant>,
}

impl Mutations<'_> {
    fn snippet(&self, place: Span) -> &str {
        self.specification.sources.snippet(place)
    }

    fn add(&mut self, place: Span, text: String) {
        let before = on_one_line(self.specification, place);
        let words: Vec<&str> = text.split_whitespace().collect();
        let after = words.join(" ");
        if place == Span::default() || before == after {
            return;
        }
        self.mutants.push(Mutant {
            place,
            text,
            change: format!("`{before}` becomes `{after}`"),
        });
    }

    fn rule(&mut self, rule: &RuleTerm) {
        match &*rule.kind {
            RuleKind::Update(_, value) => {
                self.add(rule.span, "skip".to_owned());
                self.value(value);
            }
            RuleKind::Assign(..) | RuleKind::Call(..) | RuleKind::Run(..) => {
                self.add(rule.span, "skip".to_owned());
            }
            RuleKind::If(guard, ..) | RuleKind::While(guard, _) | RuleKind::WhileRec(guard, _) => {
                let negated = format!("not ({})", self.snippet(guard.span));
                self.add(guard.span, negated);
                self.condition(guard);
            }
            RuleKind::Choose(_, Some(guard), ..) | RuleKind::Forall(_, Some(guard), _) => {
                self.condition(guard);
            }
            RuleKind::Switch(_, cases, _) => {
                for (_, body) in cases {
                    self.add(body.span, "skip".to_owned());
                }
            }
            RuleKind::Skip
            | RuleKind::Par(_)
            | RuleKind::Seq(_)
            | RuleKind::Choose(..)
            | RuleKind::Forall(..)
            | RuleKind::Let(..)
            | RuleKind::Extend(..)
            | RuleKind::Iterate(_)
            | RuleKind::Local(_)
            | RuleKind::Invalid => {}
        }
    }

    /// Changes the parts of a condition: operators, and conjuncts and disjuncts that are missing.
    fn condition(&mut self, guard: &Term) {
        let mut parts = Vec::new();
        asmotion_lang::ir::visit_terms(guard, &mut |part| parts.push(part.clone()));
        for part in parts {
            let TermKind::Apply(function, operands) = &*part.kind else {
                continue;
            };
            let function = self.specification.model.functions.get(function.0 as usize);
            let name = function
                .filter(|it| it.library)
                .map(|it| it.name.to_string());
            if let (Some("and" | "or"), [left, right]) = (name.as_deref(), operands.as_slice()) {
                for kept in [left, right] {
                    let kept = self.snippet(kept.span).to_owned();
                    self.add(part.span, kept);
                }
            }
            self.operator(&part);
        }
    }

    /// Changes the operator of a term.
    fn operator(&mut self, term: &Term) {
        let TermKind::Apply(function, operands) = &*term.kind else {
            return;
        };
        let function = self.specification.model.functions.get(function.0 as usize);
        let name = function
            .filter(|it| it.library)
            .map(|it| it.name.to_string());
        let name = name.unwrap_or_default();
        let other = CONFUSED.iter().find(|(known, _)| *known == name);
        let (Some((_, other)), [left, right]) = (other, operands.as_slice()) else {
            return;
        };
        let (left, right) = (self.snippet(left.span), self.snippet(right.span));
        let text = format!("{left} {other} {right}");
        self.add(term.span, text);
    }

    /// Changes the value of an update.
    fn value(&mut self, value: &Term) {
        if let TermKind::Value(constant) = &*value.kind {
            let other = match constant {
                Value::Bool(truth) => Some((!truth).to_string()),
                Value::Int(number) => number.checked_add(1).map(|next| next.to_string()),
                Value::Atom(atom) => next_literal(&self.specification.model, atom.0),
                Value::Undef
                | Value::Real(_)
                | Value::Char(_)
                | Value::Rule(_)
                | Value::Text(_)
                | Value::Complex(_)
                | Value::Tuple(_)
                | Value::Seq(_)
                | Value::Set(_)
                | Value::Bag(_)
                | Value::Map(_) => None,
            };
            if let Some(other) = other {
                self.add(value.span, other);
            }
        }
        self.operator(value);
    }
}

/// Returns the literal that follows in an enumeration, after the last one the first.
fn next_literal(model: &Model, atom: u32) -> Option<String> {
    let domain = model.atoms.get(atom as usize)?.domain;
    let DomainKind::Enum { first, count } = model.domains.get(domain.0 as usize)?.kind else {
        return None;
    };
    let next = first.0 + (atom.checked_sub(first.0)? + 1) % count.max(1);
    let literal = model.atoms.get(next as usize)?;
    Some(literal.name.to_string())
}
