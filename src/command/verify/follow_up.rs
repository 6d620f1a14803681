//! Commands that continue after a violation.

use super::Verify;
use crate::terminal::{FAINT, TerminalOutput};
use asmotion_verify::{CheckedProperty, PropertyKind};
use std::path::Path;

impl Verify {
    /// Prints the commands that continue after a violation that a run shows.
    pub(super) fn follow_up(
        &self,
        path: &str,
        property: &CheckedProperty,
        terminal: &mut TerminalOutput,
    ) {
        let mut lines = Vec::new();
        let trace = self
            .trace
            .as_deref()
            .unwrap_or(Path::new("run.trace"))
            .display()
            .to_string();
        let scenario = self
            .avalla
            .as_deref()
            .unwrap_or(Path::new("run.avalla"))
            .display()
            .to_string();
        if self.trace.is_none() || self.avalla.is_none() {
            let repeated = self.repeated(path, property);
            lines.push((
                format!("asmotion verify {repeated} --trace {trace} --avalla {scenario}"),
                "writes the run and a scenario",
            ));
        }
        let quoted = quoted(path);
        lines.push((
            format!("asmotion sim {quoted} --replay-inputs {trace}"),
            "repeats the run",
        ));
        lines.push((
            format!("asmotion repl {quoted} --from {trace}"),
            "steps through it, back and forth",
        ));
        lines.push((
            format!("asmotion test {scenario}"),
            "repeats it after each change",
        ));
        terminal.result("  next");
        for (command, purpose) in lines {
            terminal.result(format_args!("    {command}  {FAINT}# {purpose}{FAINT:#}"));
        }
    }

    /// Returns the arguments that repeat the verification of a property.
    fn repeated(&self, path: &str, property: &CheckedProperty) -> String {
        let mut words = vec![quoted(path)];
        let named = property.name.as_ref().unwrap_or(&property.text);
        let option = match property.kind {
            PropertyKind::Invariant | PropertyKind::Ctl | PropertyKind::Ltl => Some("--property"),
            PropertyKind::Possible => Some("--possible"),
            PropertyKind::Constraint
            | PropertyKind::NoFault
            | PropertyKind::NotStuck
            | PropertyKind::RulesRun => None,
        };
        let mut add = |option: &str, value: &str| words.push(format!("{option} {}", quoted(value)));
        if let Some(option) = option {
            add(option, named);
        }
        let several = [
            ("--assume", &self.assume),
            ("--values", &self.values),
            ("--fair", &self.fair),
            ("--strongly-fair", &self.strongly_fair),
        ];
        for (option, values) in several {
            values.iter().for_each(|value| add(option, value));
        }
        if let Some(end) = &self.end {
            add("--end", end);
        }
        if let Some(initial) = &self.init {
            add("--init", initial);
        }
        words.join(" ")
    }
}

/// Quotes a word for a shell if necessary.
fn quoted(word: &str) -> String {
    let is_plain = |sign: char| sign.is_ascii_alphanumeric() || "_-./=,:".contains(sign);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}
