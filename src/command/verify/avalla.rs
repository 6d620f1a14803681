//! A run as a scenario in Avalla.

use super::words::heading;
use asmotion_lang::Specification;
use asmotion_verify::{CheckedProperty, PropertyKind, Run, RunStep};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Returns a scenario that repeats a run of a specification, and fails where the run violates the property, if a finite run can
/// do so.
pub fn scenario(
    property: &CheckedProperty,
    run: &Run,
    specification: &Specification,
    (path, spec): (&Path, &Path),
) -> String {
    let mut scenario = ScenarioLines::default();
    let verdict = if property.verdict.is_violated() {
        "violates"
    } else {
        "shows"
    };
    scenario.line(&format!("// a run that {verdict} {}", heading(property)));
    if let Some(cycle) = run.cycle {
        let word = if cycle >= run.steps.len() {
            "the last state remains for ever".to_owned()
        } else {
            format!("from step {} on, the run repeats for ever", cycle + 1)
        };
        scenario.line(&format!("// {word}"));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let name: String = name
        .chars()
        .map(|letter| if is_letter(letter) { letter } else { '_' })
        .collect();
    scenario.line(&format!("scenario {name}"));
    scenario.line(&format!(
        "load {}",
        crate::paths::relative_specification(path, spec)
    ));
    for step in &run.steps {
        scenario.step(step, specification);
    }
    scenario.set(&run.inputs);
    // the specification checks its own invariants after each step
    let is_declared = property.kind == PropertyKind::Invariant && property.place.is_some();
    if let Some(violated) = run.violated.as_ref().filter(|_| !is_declared) {
        scenario.line(&format!("check {violated};"));
    }
    scenario.text
}

#[derive(Default)]
struct ScenarioLines {
    text: String,
    /// Inputs as set by the scenario so far.
    inputs: BTreeMap<String, String>,
}

impl ScenarioLines {
    fn step(&mut self, step: &RunStep, specification: &Specification) {
        self.set(&step.inputs);
        for choice in &step.choices {
            let rule = specification.rule_at(choice.place);
            for (variable, value) in &choice.values {
                match rule {
                    Some(rule) => {
                        self.line(&format!("pick {variable} in {} := {value};", rule.name))
                    }
                    None => self.line(&format!("pick {variable} := {value};")),
                }
            }
            if choice.values.is_empty() {
                self.line(&format!(
                    "// choice {} of {} of a term, which a scenario cannot pick",
                    choice.index + 1,
                    choice.count
                ));
            }
        }
        self.line("step");
        if step.fault.is_some() {
            return;
        }
        for update in &step.updates {
            if update.after == "undef" {
                self.line(&format!("check isUndef({});", update.location));
            } else {
                self.line(&format!("check {} = {};", update.location, update.after));
            }
        }
    }

    fn set(&mut self, inputs: &[(String, String)]) {
        for (location, value) in inputs {
            let known = self.inputs.insert(location.clone(), value.clone());
            if known.as_ref() != Some(value) {
                self.line(&format!("set {location} := {value};"));
            }
        }
    }

    fn line(&mut self, line: &str) {
        // writing to a string cannot fail
        let _ = writeln!(self.text, "{line}");
    }
}
