//! Builds the nodes of rules.

use super::Nodes;
use super::term::{applied, bound, deepest, optional, ranges};
use crate::ast::*;
use crate::codes::l034::SeveralRules;
use crate::codes::l039::NestedTooDeep;
use crate::codes::l053::UnknownWord;
use crate::codes::l072::FewRules;
use crate::edits::SpannedText;
use crate::spelling::nearest;
use asmotion_diagnostics::{Edit, Span};

/// The part of a `choose` before its `do`.
pub(crate) struct Choose {
    /// Variables with their ranges.
    pub(crate) binders: Vec<Binder>,
    /// Condition on the candidates.
    pub(crate) guard: Option<Term>,
}

impl Choose {
    /// Completes the rule with its body.
    pub(crate) fn kind(self, body: Rule, ifnone: Option<Rule>) -> RuleKind {
        RuleKind::Choose {
            binders: self.binders,
            guard: self.guard,
            body,
            ifnone,
        }
    }
}

impl Nodes<'_, '_> {
    /// Builds a rule, or `Invalid` if it is nested too deeply.
    pub(crate) fn rule(&self, start: usize, kind: RuleKind, end: usize) -> Rule {
        let span = self.span(start, end);
        let depth = 1 + rule_depth(&kind);
        if depth > MAX_DEPTH {
            self.findings.report(NestedTooDeep { at: span });
            return Rule {
                kind: Box::new(RuleKind::Invalid),
                span,
                depth: 1,
            };
        }
        Rule {
            kind: Box::new(kind),
            span,
            depth,
        }
    }

    /// Builds `local f: D [R] S`; merges consecutive declarations into one rule.
    pub(crate) fn local(&self, function: Function, init: Rule, body: Rule) -> RuleKind {
        let mut functions = vec![(function, init)];
        if let RuleKind::Local {
            functions: more,
            body,
        } = *body.kind
        {
            functions.extend(more);
            RuleKind::Local { functions, body }
        } else {
            RuleKind::Local { functions, body }
        }
    }

    /// Builds a rule that consists of a term.
    pub(crate) fn term_as_rule(&self, term: Assignee, arguments: Option<Vec<Term>>) -> RuleKind {
        let span = match &term {
            Assignee::Variable(name) => name.span,
            Assignee::Location { span, .. } => *span,
        };
        let term = self.spanned_term(applied(term), span);
        RuleKind::Term {
            term,
            arguments: arguments.unwrap_or_default(),
        }
    }

    /// Builds `par … endpar`.
    pub(crate) fn par(&self, start: usize, rules: Vec<Rule>, end: usize) -> RuleKind {
        self.count_rules("par", &rules, self.span(start, end));
        RuleKind::Par(rules)
    }

    /// Builds `seq … endseq`.
    pub(crate) fn seq(&self, start: usize, rules: Vec<Rule>, end: usize) -> RuleKind {
        self.count_rules("seq", &rules, self.span(start, end));
        RuleKind::Seq(rules)
    }

    fn count_rules(&self, block: &'static str, rules: &[Rule], all: Span) {
        let (count, without) = match rules {
            [] => ("no rule", self.skipped(all)),
            [only] if !matches!(*only.kind, RuleKind::Invalid) => {
                ("one rule", self.unwrapped(block, only, all))
            }
            _ => return,
        };
        let start = all.start as usize;
        let at = self.span(start, start + block.len());
        self.findings.report(FewRules {
            block,
            count,
            at,
            without,
        });
    }

    /// Returns the edit that replaces an empty block by `skip`, unless it contains a comment.
    fn skipped(&self, all: Span) -> Vec<Edit> {
        let text = self.text.get(all.range()).unwrap_or("");
        if text.split_whitespace().count() != 2 {
            return Vec::new();
        }
        let text = "skip".to_owned();
        vec![Edit { span: all, text }]
    }

    /// Returns the edits that remove the keywords of a block with a single rule. Comments are kept.
    /// No edits are returned if the block separates a `choose` from the `ifnone` of another one.
    fn unwrapped(&self, block: &str, only: &Rule, all: Span) -> Vec<Edit> {
        if takes_ifnone(only) {
            return Vec::new();
        }
        let (start, end) = (all.start as usize, all.end as usize);
        let (inner_start, inner_end) = (only.span.start as usize, only.span.end as usize);
        let blank = |from: usize, to: usize| {
            let between = self.text.get(from..to);
            between.is_some_and(|between| between.trim().is_empty())
        };
        let (opened, closed) = (start + block.len(), end - "end".len() - block.len());
        let head = if blank(opened, inner_start) {
            inner_start
        } else {
            opened
        };
        let tail = if blank(inner_end, closed) {
            inner_end
        } else {
            closed
        };
        let drop = |from, to| Edit {
            span: self.span(from, to),
            text: String::new(),
        };
        vec![drop(start, head), drop(tail, end)]
    }

    /// Reports bindings without brackets, of which there is at least one. Returns `None` if a name lacks its `$`.
    pub(crate) fn bare_bindings(
        &self,
        start: usize,
        bindings: Vec<(NameText, bool, Term)>,
    ) -> Option<Vec<(NameText, Term)>> {
        let (first, is_marked, _) = bindings.first()?;
        let mut respelt = self.respelt.borrow_mut();
        if !respelt.contains(&first.span) {
            let finding = self.explainer.borrow().bare_let(first, start, !is_marked);
            respelt.extend(&finding.names);
            self.findings.report(finding);
        }
        let marked = bindings.into_iter();
        let marked = marked.map(|(name, is_marked, term)| is_marked.then_some((name, term)));
        marked.collect()
    }

    /// Builds a single rule. Several are an error, and are combined by `par`.
    pub(crate) fn block(&self, start: usize, mut rules: Vec<Rule>, end: usize) -> Rule {
        match rules.pop() {
            Some(only) if rules.is_empty() => only,
            last => {
                rules.extend(last);
                self.several_rules(&rules, self.span(start, end));
                self.rule(start, RuleKind::Par(rules), end)
            }
        }
    }

    fn several_rules(&self, rules: &[Rule], all: Span) {
        let [first, second, ..] = rules else { return };
        if rules
            .iter()
            .any(|rule| matches!(*rule.kind, RuleKind::Invalid))
        {
            return; // an apparent rule may be part of a construct that failed to parse
        }
        match rules.iter().find_map(misspelled_word) {
            Some((found, meant)) => self.findings.report(UnknownWord { found, meant }),
            None => self.findings.report(SeveralRules {
                first: first.span,
                second: second.span,
                all: Some((all, self.text.get(all.range()).unwrap_or("").to_owned())),
            }),
        }
    }
}

/// Returns a term standing as a rule if it is probably a misspelt keyword of the enclosing rule,
/// with that keyword.
fn misspelled_word(rule: &Rule) -> Option<(SpannedText, String)> {
    let RuleKind::Term { term, .. } = &*rule.kind else {
        return None;
    };
    let TermKind::Apply { name, .. } = &*term.kind else {
        return None;
    };
    let suggestion = nearest(
        &name.text,
        ["else", "endif", "otherwise", "endswitch", "endlet"],
    )?;
    Some(((name.text.to_string(), name.span), suggestion.to_owned()))
}

/// Returns the depth of the deepest part of a rule.
fn rule_depth(kind: &RuleKind) -> u32 {
    match kind {
        RuleKind::Skip | RuleKind::Invalid => 0,
        RuleKind::Update { target, value } => target_depth(target).max(value.depth),
        RuleKind::Assign {
            target, arguments, ..
        } => target_depth(target).max(deepest(arguments)),
        RuleKind::Macro { arguments, .. } | RuleKind::Turbo { arguments, .. } => deepest(arguments),
        RuleKind::Term { term, arguments } => term.depth.max(deepest(arguments)),
        RuleKind::Par(rules) | RuleKind::Seq(rules) => {
            rules.iter().map(|rule| rule.depth).max().unwrap_or(0)
        }
        RuleKind::If {
            guard,
            then,
            otherwise,
        } => guard.depth.max(then.depth).max(optional_rule(otherwise)),
        RuleKind::Switch(SwitchRule {
            subject,
            cases,
            otherwise,
        }) => cases
            .iter()
            .map(|(case, body)| case.depth.max(body.depth))
            .fold(subject.depth.max(optional_rule(otherwise)), u32::max),
        RuleKind::Choose {
            binders,
            guard,
            body,
            ifnone,
        } => ranges(binders)
            .max(optional(guard))
            .max(body.depth)
            .max(optional_rule(ifnone)),
        RuleKind::Forall {
            binders,
            guard,
            body,
        } => ranges(binders).max(optional(guard)).max(body.depth),
        RuleKind::Let { bindings, body } => bound(bindings).max(body.depth),
        RuleKind::Extend { body, .. } | RuleKind::Iterate(body) => body.depth,
        RuleKind::While { guard, body } | RuleKind::WhileRec { guard, body } => {
            guard.depth.max(body.depth)
        }
        RuleKind::Local { functions, body } => functions
            .iter()
            .map(|(_, init)| init.depth)
            .fold(body.depth, u32::max),
    }
}

fn target_depth(target: &Assignee) -> u32 {
    match target {
        Assignee::Location { arguments, .. } => deepest(arguments),
        Assignee::Variable(_) => 0,
    }
}

fn optional_rule(rule: &Option<Rule>) -> u32 {
    rule.as_ref().map_or(0, |rule| rule.depth)
}

/// Returns `true` if an `ifnone` after the rule would belong to it.
fn takes_ifnone(rule: &Rule) -> bool {
    match &*rule.kind {
        RuleKind::Choose { ifnone: None, .. } => true,
        RuleKind::Choose {
            ifnone: Some(last), ..
        } => takes_ifnone(last),
        RuleKind::Forall { body, .. }
        | RuleKind::Extend { body, .. }
        | RuleKind::While { body, .. }
        | RuleKind::WhileRec { body, .. }
        | RuleKind::Local { body, .. } => takes_ifnone(body),
        RuleKind::Skip
        | RuleKind::Update { .. }
        | RuleKind::Assign { .. }
        | RuleKind::Macro { .. }
        | RuleKind::Turbo { .. }
        | RuleKind::Term { .. }
        | RuleKind::Par(_)
        | RuleKind::Seq(_)
        | RuleKind::If { .. }
        | RuleKind::Switch(_)
        | RuleKind::Let { .. }
        | RuleKind::Iterate(_)
        | RuleKind::Invalid => false,
    }
}
