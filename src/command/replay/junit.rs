//! Writes a JUnit report: one case for each coordinator of each recording.

use std::fmt::{self, Display};
use std::path::Path;

use super::outcome::{RecordingOutcome, ReplayVerdict};
use super::words::{self, step};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use crate::xml::Escaped;

/// Writes the report.
pub fn write(file: &Path, outcomes: &[RecordingOutcome], terminal: &mut TerminalOutput) -> Exit {
    match std::fs::write(file, JunitReport(cases(outcomes)).to_string()) {
        Ok(()) => Exit::Ok,
        Err(error) => {
            terminal.error(format_args!("cannot write `{}`: {error}", file.display()));
            Exit::Usage
        }
    }
}

struct JunitReport(Vec<ReplayCase>);

/// A coordinator, or a recording that cannot be replayed.
struct ReplayCase {
    path: String,
    name: String,
    verdict: ReplayVerdict,
    message: String,
    text: String,
}

fn cases(outcomes: &[RecordingOutcome]) -> Vec<ReplayCase> {
    let mut cases = Vec::new();
    for outcome in outcomes {
        let path = outcome.path.display().to_string();
        if let Some(failure) = &outcome.failure {
            cases.push(ReplayCase {
                path: path.clone(),
                name: path.clone(),
                verdict: outcome.verdict(),
                message: failure.clone(),
                text: String::new(),
            });
        }
        for (name, one) in &outcome.coordinators {
            let difference = one.difference.as_ref();
            let message =
                difference.map(|it| format!("different in {}", step(it.number, it.time_ns)));
            let lines = difference.map(words::difference);
            let lines = lines.into_iter().flatten();
            let notes = one.notes.iter();
            let notes = notes.map(|(text, number)| format!("note: {text} (from step {number} on)"));
            let lines = lines
                .map(|(label, text)| format!("{label}: {text}"))
                .chain(notes);
            cases.push(ReplayCase {
                path: path.clone(),
                name: name.clone(),
                verdict: one.verdict(),
                message: one.reason().or(message).unwrap_or_default(),
                text: lines.collect::<Vec<_>>().join("\n"),
            });
        }
    }
    cases
}

impl Display for JunitReport {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |verdict| self.0.iter().filter(|it| it.verdict == verdict).count();
        let tests = self.0.len();
        let counts = format!(
            r#"tests="{tests}" skipped="{}" errors="{}" failures="{}""#,
            count(ReplayVerdict::Skipped),
            count(ReplayVerdict::Unusable),
            count(ReplayVerdict::Different),
        );
        writeln!(to, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(to, r#"<testsuites name="asmotion replay" {counts}>"#)?;
        writeln!(to, r#"    <testsuite name="recordings" {counts}>"#)?;
        self.0.iter().try_for_each(|case| case.fmt(to))?;
        writeln!(to, "    </testsuite>\n</testsuites>")
    }
}

impl Display for ReplayCase {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, path) = (Escaped(&self.name), Escaped(&self.path));
        write!(to, r#"        <testcase name="{name}" classname="{path}""#)?;
        let element = match self.verdict {
            ReplayVerdict::Equal => return writeln!(to, "/>"),
            ReplayVerdict::Skipped => "skipped",
            ReplayVerdict::Different => "failure",
            ReplayVerdict::Unusable => "error",
        };
        let message = Escaped(&self.message);
        let text = Escaped(&self.text);
        writeln!(
            to,
            ">\n            <{element} message=\"{message}\">{text}</{element}>\n        </testcase>"
        )
    }
}
