//! The values involved in a fault.

use crate::specification::Specification;
use asmotion_diagnostics::{Diagnostic, Label, Span};
use asmotion_machine::{FaultKind, Machine, PathEntry, StepFault, Witness};
use asmotion_value::Value;

/// Limit for the values shown for each position; the closest ones are shown.
const SHOWN: usize = 8;

/// Limit for the calls shown on the way to a position; the last ones are shown.
const CALLS: usize = 3;

/// Limit for the characters of a value; longer ones are cut.
const LENGTH: usize = 60;

/// Adds the values read by rules and terms around the fault, and the calls that led to them.
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
            _ => "at this point".to_owned(),
        };
        finding = finding.note(format!("{there}, {}", facts.join(", ")));
    }
    finding
}

/// Adds the inputs of the failed step.
pub(super) fn add_inputs(finding: Diagnostic, machine: &Machine) -> Diagnostic {
    let naming = machine.naming();
    let inputs = machine.last_step().inputs().iter().map(|input| {
        let value = cut(input.value.show(&naming).to_string());
        format!(
            "`{}` = {value}",
            asmotion_simulate::location(machine, input.slot)
        )
    });
    listed(finding, "inputs of the step", inputs.collect())
}

/// Adds the inputs for which a random simulation found no values.
pub(super) fn add_drawn_inputs(
    finding: Diagnostic,
    machine: &Machine,
    is_exhaustive: bool,
) -> Diagnostic {
    let inputs = machine.last_step().inputs().iter();
    let names = inputs.map(|it| format!("`{}`", asmotion_simulate::location(machine, it.slot)));
    let names: Vec<String> = names.collect();
    if names.is_empty() {
        return finding.note("it does not hold in this state, whatever the inputs are");
    }
    let what = if is_exhaustive {
        "inputs tried with all values that a random simulation draws"
    } else {
        "inputs tried with many of their values, not all"
    };
    listed(finding, what, names)
}

/// Adds the updates of the step that led to the faulty state.
pub(super) fn add_updates(finding: Diagnostic, machine: &Machine) -> Diagnostic {
    let updates = asmotion_simulate::updates(machine, &machine.last_step());
    let updates = updates.into_iter().map(|(location, before, after)| {
        format!("`{location}` := {} (was {})", cut(after), cut(before))
    });
    listed(finding, "updates of the step", updates.collect())
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

/// Context for formatting places and values.
struct ValueDisplay<'a> {
    specification: &'a Specification,
    show: &'a dyn Fn(&Value) -> String,
}

impl ValueDisplay<'_> {
    /// Returns facts such as "`$r` = R1": first variables, then the closest values. Each text is
    /// listed once.
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

    /// Returns the calls on the way, innermost last; a recursive call is listed once.
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

/// Replaces each run of white space by a single blank.
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
