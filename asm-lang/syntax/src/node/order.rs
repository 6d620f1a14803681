//! The order of items required by AsmetaS, and edits that establish it.

use crate::ast::{NameText, Rule, RuleDeclaration, RuleKind};
use crate::codes::l076::CalledEarly;
use crate::findings::SyntaxFindings;
use asmotion_diagnostics::{Edit, Span};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Returns the edits that move an item before another one; comments above the items move with them.
pub(super) fn moved(text: &str, item: Span, before: Span) -> Vec<Edit> {
    let from = with_comments(text, item);
    let to = with_comments(text, before).start;
    let moved = text.get(from.clone()).unwrap_or("");
    let separated = if moved.ends_with('\n') { "" } else { " " };
    vec![
        Edit {
            span: Span::new(item.file, from.start, from.end),
            text: String::new(),
        },
        Edit {
            span: Span::new(item.file, to, to),
            text: format!("{moved}{separated}"),
        },
    ]
}

/// Returns the edit that writes the heading of a section before an item, on a line of its own.
pub(super) fn heading(text: &str, section: &str, item: Span) -> Edit {
    let start = item.start as usize;
    let before = text.get(..start).unwrap_or("");
    let line = before.rfind('\n').map_or(0, |newline| newline + 1);
    let is_first = before
        .get(line..)
        .is_some_and(|left| left.trim().is_empty());
    let (at, text) = if is_first {
        (line, format!("{section}:\n"))
    } else {
        (start, format!("\n{section}:\n"))
    };
    Edit {
        span: Span::new(item.file, at, at),
        text,
    }
}

/// Returns the range of an item's lines and the comments directly above them, or of the item alone
/// if it shares a line with others.
fn with_comments(text: &str, item: Span) -> Range<usize> {
    let Range { start, end } = item.range();
    let before = text.get(..start).unwrap_or("");
    let behind = text.get(end..).unwrap_or("");
    let line = before.rfind('\n').map_or(0, |newline| newline + 1);
    let Some(newline) = behind.find('\n') else {
        return start..end;
    };
    let (left, right) = (before.get(line..), behind.get(..newline));
    let is_blank = |text: &str| text.trim().is_empty();
    let is_comment = |text: &str| text.trim_start().starts_with("//");
    if !left.is_some_and(is_blank) || !right.is_some_and(|it| is_blank(it) || is_comment(it)) {
        return start..end;
    }
    let mut first = line;
    while let Some(above) = before
        .get(..first)
        .and_then(|above| above.strip_suffix('\n'))
    {
        let begin = above.rfind('\n').map_or(0, |newline| newline + 1);
        if !above.get(begin..).is_some_and(is_comment) {
            break;
        }
        first = begin;
    }
    first..end + newline + 1
}

/// Reports the first rule that is called before its declaration. Rules that call each other
/// mutually have no valid order and are not reported.
pub(super) fn rules(text: &str, rules: &[RuleDeclaration], findings: &SyntaxFindings) {
    let mut declared: BTreeMap<&str, usize> = BTreeMap::new();
    for (index, rule) in rules.iter().enumerate() {
        declared.entry(&rule.name.text).or_insert(index);
    }
    let calls: Vec<Vec<(usize, &NameText)>> = rules
        .iter()
        .map(|rule| {
            let mut names = Vec::new();
            called(&rule.body, &mut names);
            let known = |name: &'_ NameText| declared.get(&*name.text).copied();
            let calls = names
                .into_iter()
                .filter_map(|name| Some((known(name)?, name)));
            calls.collect()
        })
        .collect();
    for (caller, callees) in calls.iter().enumerate() {
        let early = callees
            .iter()
            .find(|(callee, _)| *callee > caller && !reaches(*callee, caller, &calls));
        if let (Some((callee, name)), Some(rule)) = (early, rules.get(caller))
            && let Some(other) = rules.get(*callee)
        {
            return findings.report(CalledEarly {
                rule: name.text.to_string(),
                at: name.span,
                declared: other.name.span,
                moved: moved(text, other.span, rule.span),
            });
        }
    }
}

/// Returns `true` if one rule calls the other, directly or indirectly.
fn reaches(from: usize, to: usize, calls: &[Vec<(usize, &NameText)>]) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![from];
    while let Some(rule) = open.pop() {
        if rule == to {
            return true;
        }
        if seen.insert(rule) {
            open.extend(
                calls
                    .get(rule)
                    .into_iter()
                    .flatten()
                    .map(|(callee, _)| *callee),
            );
        }
    }
    false
}

/// Collects the names of the rules that a rule calls.
fn called<'a>(rule: &'a Rule, names: &mut Vec<&'a NameText>) {
    match &*rule.kind {
        RuleKind::Macro { name, .. } | RuleKind::Turbo { name, .. } => names.push(name),
        RuleKind::Assign { rule, .. } => names.push(rule),
        RuleKind::Skip | RuleKind::Update { .. } | RuleKind::Term { .. } | RuleKind::Invalid => {}
        RuleKind::Par(rules) | RuleKind::Seq(rules) => {
            rules.iter().for_each(|rule| called(rule, names));
        }
        RuleKind::If {
            then: body,
            otherwise: other,
            ..
        }
        | RuleKind::Choose {
            body,
            ifnone: other,
            ..
        } => {
            called(body, names);
            other.iter().for_each(|rule| called(rule, names));
        }
        RuleKind::Switch(switch) => {
            let cases = switch.cases.iter().map(|(_, rule)| rule);
            cases
                .chain(&switch.otherwise)
                .for_each(|rule| called(rule, names));
        }
        RuleKind::Forall { body, .. }
        | RuleKind::Let { body, .. }
        | RuleKind::Extend { body, .. }
        | RuleKind::While { body, .. }
        | RuleKind::WhileRec { body, .. }
        | RuleKind::Iterate(body) => called(body, names),
        RuleKind::Local { functions, body } => {
            functions.iter().for_each(|(_, init)| called(init, names));
            called(body, names);
        }
    }
}
