//! Notes updates of out functions: an update has an effect even if it does not change the value.

use crate::error::ModelError;
use asmotion_lang::syntax::ast::{
    Assignee, ChainLink, File, Literal, NameText, Operator, Rule, RuleDeclaration, RuleKind, Term,
    TermKind,
};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Makes each update of these functions also set `given_…` of the same location; where the value is `true`, only if the update
/// changes it.
pub(crate) struct Instrumentation<'a> {
    pub given: &'a BTreeMap<String, bool>,
}

impl Instrumentation<'_> {
    pub fn file(&self, file: &mut File) {
        let rules = file.rules.iter_mut().chain(&mut file.main);
        rules.for_each(|rule| self.rule(&mut rule.body));
    }

    fn rule(&self, rule: &mut Rule) {
        match &mut *rule.kind {
            RuleKind::Update { target, value } => {
                let value = value.clone();
                self.update(target.clone(), Some(value), rule);
            }
            RuleKind::Assign { target, .. } => self.update(target.clone(), None, rule),
            RuleKind::Par(rules) | RuleKind::Seq(rules) => {
                rules.iter_mut().for_each(|it| self.rule(it))
            }
            RuleKind::If {
                then, otherwise, ..
            } => {
                self.rule(then);
                otherwise.iter_mut().for_each(|it| self.rule(it));
            }
            RuleKind::Switch(switch) => {
                switch.cases.iter_mut().for_each(|(_, it)| self.rule(it));
                switch.otherwise.iter_mut().for_each(|it| self.rule(it));
            }
            RuleKind::Choose { body, ifnone, .. } => {
                self.rule(body);
                ifnone.iter_mut().for_each(|it| self.rule(it));
            }
            RuleKind::Forall { body, .. }
            | RuleKind::Let { body, .. }
            | RuleKind::Extend { body, .. }
            | RuleKind::While { body, .. }
            | RuleKind::WhileRec { body, .. }
            | RuleKind::Iterate(body) => self.rule(body),
            RuleKind::Local { functions, body } => {
                functions.iter_mut().for_each(|(_, it)| self.rule(it));
                self.rule(body);
            }
            RuleKind::Skip
            | RuleKind::Macro { .. }
            | RuleKind::Turbo { .. }
            | RuleKind::Term { .. }
            | RuleKind::Invalid => {}
        }
    }

    /// Replaces an update by itself and the note of it.
    fn update(&self, target: Assignee, value: Option<Term>, rule: &mut Rule) {
        let Assignee::Location {
            agent,
            function,
            arguments,
            span,
        } = target
        else {
            return;
        };
        let Some(only_changes) = self.given.get(&*function.text) else {
            return;
        };
        let at = |kind: RuleKind, depth| Rule {
            kind: Box::new(kind),
            span,
            depth,
        };
        let term = |kind: TermKind| Term {
            kind: Box::new(kind),
            span,
            depth: rule.depth,
        };
        let note = at(
            RuleKind::Update {
                target: Assignee::Location {
                    agent,
                    function: NameText {
                        text: Arc::from(format!("given_{}", function.text)),
                        span: function.span,
                    },
                    arguments: arguments.clone(),
                    span,
                },
                value: term(TermKind::Literal(Literal::Bool(true))),
            },
            rule.depth,
        );
        let note = match value.filter(|_| *only_changes) {
            None => note,
            Some(value) => {
                let guard = TermKind::Chain {
                    first: term(TermKind::Apply {
                        name: function,
                        arguments,
                    }),
                    links: vec![ChainLink {
                        operator: Operator::Neq,
                        at: span,
                        operand: value,
                    }],
                };
                let guard = term(guard);
                at(
                    RuleKind::If {
                        guard,
                        then: note,
                        otherwise: None,
                    },
                    rule.depth + 1,
                )
            }
        };
        let original = rule.clone();
        let depth = rule.depth.max(note.depth) + 1;
        *rule = at(RuleKind::Par(vec![original, note]), depth);
    }
}

/// Checks that no macro updates a parameter for which one of these functions is given: the note would be missing.
///
/// # Errors
/// There is such a macro.
pub(crate) fn check_parameters(
    files: &[&File],
    given: &BTreeMap<String, bool>,
) -> Result<(), ModelError> {
    let rules: Vec<&RuleDeclaration> = files
        .iter()
        .flat_map(|it| it.rules.iter().chain(&it.main))
        .collect();
    let mut updated: BTreeSet<(String, usize)> = BTreeSet::new();
    loop {
        let before = updated.len();
        for rule in &rules {
            let mut found = BTreeSet::new();
            visit(&rule.body, &mut |part| match &*part.kind {
                RuleKind::Update { target, .. } | RuleKind::Assign { target, .. } => {
                    if let Assignee::Variable(variable) = target {
                        found.insert(variable.text.clone());
                    }
                }
                RuleKind::Macro { name, arguments } => {
                    for (index, argument) in arguments.iter().enumerate() {
                        if let TermKind::Variable(variable) = &*argument.kind
                            && updated.contains(&(name.text.to_string(), index))
                        {
                            found.insert(variable.text.clone());
                        }
                    }
                }
                RuleKind::Skip
                | RuleKind::Turbo { .. }
                | RuleKind::Term { .. }
                | RuleKind::Par(_)
                | RuleKind::Seq(_)
                | RuleKind::If { .. }
                | RuleKind::Switch(_)
                | RuleKind::Choose { .. }
                | RuleKind::Forall { .. }
                | RuleKind::Let { .. }
                | RuleKind::Extend { .. }
                | RuleKind::While { .. }
                | RuleKind::WhileRec { .. }
                | RuleKind::Iterate(_)
                | RuleKind::Local { .. }
                | RuleKind::Invalid => {}
            });
            for (index, parameter) in rule.parameters.iter().enumerate() {
                if found.contains(&parameter.name.text) {
                    updated.insert((rule.name.text.to_string(), index));
                }
            }
        }
        if updated.len() == before {
            break;
        }
    }
    let mut wrong = None;
    for rule in &rules {
        visit(&rule.body, &mut |part| {
            if let RuleKind::Macro { name, arguments } = &*part.kind {
                for (index, argument) in arguments.iter().enumerate() {
                    if let TermKind::Apply { name: function, .. } = &*argument.kind
                        && given.contains_key(&*function.text)
                        && updated.contains(&(name.text.to_string(), index))
                    {
                        wrong.get_or_insert((function.text.to_string(), name.text.to_string()));
                    }
                }
            }
        });
    }
    match wrong {
        Some((function, rule)) => Err(ModelError::UpdatedParameter { function, rule }),
        None => Ok(()),
    }
}

fn visit(rule: &Rule, see: &mut dyn FnMut(&Rule)) {
    see(rule);
    match &*rule.kind {
        RuleKind::Par(rules) | RuleKind::Seq(rules) => rules.iter().for_each(|it| visit(it, see)),
        RuleKind::If {
            then, otherwise, ..
        } => {
            visit(then, see);
            otherwise.iter().for_each(|it| visit(it, see));
        }
        RuleKind::Switch(switch) => {
            switch.cases.iter().for_each(|(_, it)| visit(it, see));
            switch.otherwise.iter().for_each(|it| visit(it, see));
        }
        RuleKind::Choose { body, ifnone, .. } => {
            visit(body, see);
            ifnone.iter().for_each(|it| visit(it, see));
        }
        RuleKind::Forall { body, .. }
        | RuleKind::Let { body, .. }
        | RuleKind::Extend { body, .. }
        | RuleKind::While { body, .. }
        | RuleKind::WhileRec { body, .. }
        | RuleKind::Iterate(body) => visit(body, see),
        RuleKind::Local { functions, body } => {
            functions.iter().for_each(|(_, it)| visit(it, see));
            visit(body, see);
        }
        RuleKind::Update { .. }
        | RuleKind::Assign { .. }
        | RuleKind::Skip
        | RuleKind::Macro { .. }
        | RuleKind::Turbo { .. }
        | RuleKind::Term { .. }
        | RuleKind::Invalid => {}
    }
}
