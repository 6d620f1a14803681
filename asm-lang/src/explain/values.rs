//! The values at hand where a step failed.

use crate::specification::Specification;
use asmotion_diagnostics::{Diagnostic, Label, Span};
use asmotion_machine::{FaultKind, Machine, PathEntry, StepFault, Witness};
use asmotion_value::Value;

/// So many values are shown of each place, the nearest ones.
const SHOWN: usize = 8;

/// So many calls are shown on the way to a place, the last ones.
const CALLS: usize = 3;

/// Longer values are cut.
const LENGTH: usize = 60;

/// Adds what the rules and terms around the fault read, and who called them.
pub(super) fn add(
    mut finding: Diagnostic,
    fault: &StepFault,
    witness: &Witness,
    specification: &Specification,
    show: &dyn Fn(&Value) -> String,
) -> Diagnostic {
    let shown = ValueDisplay {
        specification,
        show,
    };
    for (path, other) in [(&witness.path, false), (&witness.first, true)] {
        for span in shown.calls(path) {
            let known = finding.primary.iter().chain(&finding.secondary);
            if !known.map(|label| label.span).any(|label| label == span) {
                let text = "called here".to_owned();
                finding.secondary.push(Label { span, text });
            }
        }
        let facts = shown.facts(path);
        if facts.is_empty() {
            continue;
        }
        let there = match (&fault.kind, other) {
            (FaultKind::Clash { second, .. }, false) => {
                format!("when {} was written", show(second))
            }
            (FaultKind::Clash { first, .. }, true) => format!("when {} was written", show(first)),
            (FaultKind::Endless(_), _) => format!("after {} rounds", Witness::ROUNDS),
            _ => "at that moment".to_owned(),
        };
        finding = finding.note(format!("{there}, {}", facts.join(", ")));
    }
    finding
}

/// Adds what the environment said in the failed step.
pub(super) fn add_inputs(finding: Diagnostic, machine: &Machine) -> Diagnostic {
    let naming = machine.naming();
    let inputs = machine.last_step().inputs().iter().map(|input| {
        let value = cut(input.value.show(&naming).to_string());
        format!(
            "`{}` = {value}",
            asmotion_simulate::location(machine, input.slot)
        )
    });
    listed(finding, "the inputs of the step", inputs.collect())
}

/// Adds what the step wrote that led to the state at fault.
pub(super) fn add_updates(finding: Diagnostic, machine: &Machine) -> Diagnostic {
    let updates = asmotion_simulate::updates(machine, &machine.last_step());
    let updates = updates.into_iter().map(|(location, before, after)| {
        format!("`{location}` := {} (was {})", cut(after), cut(before))
    });
    listed(finding, "the updates of the step", updates.collect())
}

fn listed(finding: Diagnostic, what: &str, items: Vec<String>) -> Diagnostic {
    if items.is_empty() {
        return finding;
    }
    let shown = items.get(..SHOWN).unwrap_or(&items).join(", ");
    let more = match items.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(", and {more} more"),
    };
    finding.note(format!("{what}: {shown}{more}"))
}

/// How places and values are shown.
struct ValueDisplay<'a> {
    specification: &'a Specification,
    show: &'a dyn Fn(&Value) -> String,
}

impl ValueDisplay<'_> {
    /// "`$r` = R1": variables first, then what is nearest. A name of a term stands for one value.
    fn facts(&self, path: &[PathEntry]) -> Vec<String> {
        let mut known: Vec<(&str, &Value)> = Vec::new();
        for (origin, value) in path.iter().rev().flat_map(|passed| &passed.reads) {
            let text = self
                .specification
                .sources
                .snippet(self.specification.span(*origin));
            if !text.is_empty() && !known.iter().any(|(other, _)| *other == text) {
                known.push((text, value));
            }
        }
        known.truncate(SHOWN);
        known.sort_by_key(|(text, _)| !text.starts_with('$'));
        let fact = |(text, value): (&str, &Value)| {
            format!("`{}` = {}", joined(text), cut((self.show)(value)))
        };
        known.into_iter().map(fact).collect()
    }

    /// The calls on the way, the innermost last; a recursive one counts once.
    fn calls(&self, path: &[PathEntry]) -> Vec<Span> {
        let mut calls: Vec<Span> = Vec::new();
        for passed in path.iter().rev().filter(|passed| passed.calls) {
            let span = self.specification.span(passed.origin);
            if calls.len() < CALLS && span != Span::default() && !calls.contains(&span) {
                calls.push(span);
            }
        }
        calls.reverse();
        calls
    }
}

/// On one line, with single blanks.
fn joined(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ")
}

fn cut(text: String) -> String {
    match text.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}…", text.get(..end).unwrap_or("")),
        None => text,
    }
}
