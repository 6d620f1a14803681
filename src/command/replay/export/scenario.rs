//! Steps as a scenario in Avalla, which sets the inputs and checks the updates.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use asmotion_coordinator::RecordedCycle;
use asmotion_lang::guards::chosen_variables;
use asmotion_lang::{Loader, Machine, Specification, Value};

use super::Exported;
use crate::files::DiskLoader;
use crate::paths::relative_specification;

/// The lines of a scenario for the steps so far.
#[derive(Default)]
pub struct ScenarioSteps {
    /// Path and text of the specification in the run.
    source: Option<(String, String)>,
    lines: String,
    /// Inputs as set so far.
    inputs: BTreeMap<String, String>,
    warnings: BTreeSet<String>,
}

impl ScenarioSteps {
    /// Returns whether there is no step yet.
    pub fn is_empty(&self) -> bool {
        self.source.is_none()
    }

    /// Adds a step that the machine has just repeated.
    pub fn add(&mut self, cycle: &RecordedCycle, specification: &Specification, machine: &Machine) {
        self.source.get_or_insert_with(|| {
            let sources = &specification.sources;
            let path = sources.paths().next().unwrap_or_default();
            let text = sources.find(path).map_or("", |file| sources.text(file));
            (path.to_owned(), text.to_owned())
        });
        for read in &cycle.read {
            let known = self
                .inputs
                .insert(read.location.clone(), read.value.clone());
            if known.as_deref().unwrap_or("undef") != read.value {
                self.line(format_args!("set {} := {};", read.location, read.value));
            }
        }
        self.pick(cycle.number, specification, machine);
        let seconds = cycle.time_ns as f64 / 1e9;
        self.line(format_args!("step // {} at {seconds} s", cycle.number));
        for update in &cycle.updates {
            match &*update.after {
                "undef" => self.line(format_args!("check isUndef({});", update.location)),
                after => self.line(format_args!("check {} = {after};", update.location)),
            }
        }
    }

    /// Picks the values that `choose` rules took. A pick holds for all choices at one place in a step.
    fn pick(&mut self, number: u64, specification: &Specification, machine: &Machine) {
        let step = machine.last_step();
        let naming = machine.naming();
        let show = |value: &Value| value.show(&naming).to_string();
        let mut picked: BTreeMap<String, Vec<String>> = BTreeMap::new();
        for (index, choice) in step.choices().iter().enumerate() {
            let place = specification.span(choice.origin);
            let mut candidates = step.candidates().iter();
            let taken = candidates.find(|taken| taken.choice == Some(index));
            let Some(taken) = taken else {
                self.warnings.insert(format!(
                    "step {number} chooses in a term, which a scenario cannot pick"
                ));
                continue;
            };
            let rule = specification.rule_at(place);
            let rule = rule.map(|rule| format!(" in {}", rule.name));
            let rule = rule.unwrap_or_default();
            let variables = chosen_variables(specification, place);
            for (variable, value) in variables.iter().zip(&taken.values) {
                let values = picked.entry(format!("{variable}{rule}")).or_default();
                values.push(show(value));
            }
        }
        for (variable, values) in picked {
            if values.iter().any(|value| Some(value) != values.first()) {
                self.warnings.insert(format!(
                    "step {number} chooses several times for `{variable}`, which a scenario cannot pick apart"
                ));
            }
            if let Some(value) = values.first() {
                self.line(format_args!("pick {variable} := {value};"));
            }
        }
    }

    /// The scenario, to be stored at `path`.
    pub fn text(&self, path: &Path, failed: Option<&(u64, String)>) -> Exported {
        let mut text = String::new();
        let mut warnings: Vec<_> = self.warnings.iter().cloned().collect();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let letters = name.chars();
        let letters = letters.map(|letter| if is_letter(letter) { letter } else { '_' });
        let name: String = letters.collect();
        let (source, recorded) = match &self.source {
            Some((source, text)) => (source.as_str(), text.as_str()),
            None => ("", ""),
        };
        let load = relative_specification(path, Path::new(source));
        // writing to a string cannot fail
        let _ = write!(text, "scenario {name}\nload {load}\n{}", self.lines);
        if let Some((number, reason)) = failed {
            let reason = reason.replace('\n', " ");
            let _ = writeln!(text, "// step {number} failed: {reason}");
        }
        match DiskLoader.read(source) {
            Ok(now) if *now == *recorded => {}
            Ok(_) => warnings.push(format!("`{source}` is not the text that the run had")),
            Err(error) => warnings.push(format!(
                "the scenario loads `{source}`, as the run did: {error}"
            )),
        }
        Exported { text, warnings }
    }

    fn line(&mut self, line: impl std::fmt::Display) {
        // writing to a string cannot fail
        let _ = writeln!(self.lines, "{line}");
    }
}
