//! Writes a JUnit report for Jenkins and GitLab.

use std::fmt::{self, Display};
use std::path::Path;

use asmotion_lang::simulate::scenario::Verdict;
use asmotion_lang::{Style, render_all};

use super::result::{TestEnd, TestResult};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use crate::xml::Escaped;

/// Writes the report: one suite with a case for each scenario.
pub fn write(file: &Path, results: &[TestResult], terminal: &mut TerminalOutput) -> Exit {
    match std::fs::write(file, JunitReport(results).to_string()) {
        Ok(()) => Exit::Ok,
        Err(error) => {
            terminal.error(format_args!("cannot write `{}`: {error}", file.display()));
            Exit::Usage
        }
    }
}

struct JunitReport<'a>(&'a [TestResult]);

/// The element for a case that did not pass; `None` for one that passed.
fn failure_element(end: &TestEnd) -> Option<&'static str> {
    match end {
        TestEnd::Ran(Verdict::Pass) => None,
        TestEnd::Ran(Verdict::Fail | Verdict::Invariant) => Some("failure"),
        TestEnd::Ran(Verdict::Fault) | TestEnd::Unusable => Some("error"),
    }
}

impl Display for JunitReport<'_> {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tests = self.0.len();
        let count = |kind| {
            let troubles = self.0.iter().map(|it| failure_element(&it.end));
            troubles.filter(|it| *it == Some(kind)).count()
        };
        let (failures, errors) = (count("failure"), count("error"));
        let counts =
            format!(r#"tests="{tests}" skipped="0" errors="{errors}" failures="{failures}""#);
        writeln!(to, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
        writeln!(to, r#"<testsuites name="asmotion test" {counts}>"#)?;
        writeln!(to, r#"    <testsuite name="scenarios" {counts}>"#)?;
        self.0.iter().try_for_each(|one| case(one, to))?;
        writeln!(to, "    </testsuite>\n</testsuites>")
    }
}

fn case(result: &TestResult, to: &mut fmt::Formatter<'_>) -> fmt::Result {
    let path = result.path.display().to_string();
    let name = match &*result.name {
        "" => &path,
        name => name,
    };
    let seconds = result.duration.as_secs_f64();
    write!(
        to,
        r#"        <testcase name="{}" classname="{}" time="{seconds:.3}""#,
        Escaped(name),
        Escaped(&path)
    )?;
    let Some(element) = failure_element(&result.end) else {
        return writeln!(to, "/>");
    };
    let first = result.report.diagnostics.first();
    let message = first.map_or("", |finding| &finding.message);
    let findings = render_all(&result.report, &result.sources, Style::Plain);
    writeln!(
        to,
        ">\n            <{element} message=\"{}\" type=\"{}\">{}</{element}>\n        </testcase>",
        Escaped(message),
        Escaped(result.end.word()),
        Escaped(&findings)
    )
}
