//! Prints results of scenarios, as text or JSON.

use super::result::{TestEnd, TestResult};
use crate::exit::Exit;
use crate::numbers::counted;
use crate::terminal::{BAD, FAINT, GOOD, NOTE, TerminalOutput};
use asmotion_lang::Severity;
use asmotion_lang::simulate::scenario::Verdict;
use serde_json::json;
use std::time::Duration;

/// Prints the result of one scenario with its findings.
pub fn print_result(result: &TestResult, as_json: bool, terminal: &mut TerminalOutput) {
    if as_json {
        return terminal.result(json(result));
    }
    let colour = match result.end {
        TestEnd::Ran(Verdict::Pass) => GOOD,
        TestEnd::Ran(Verdict::Fail | Verdict::Invariant | Verdict::Fault) => BAD,
        TestEnd::Unusable => NOTE,
    };
    let steps = counted(result.steps, "step");
    let checks = counted(result.checks, "check");
    terminal.result(format_args!(
        "{colour}{:>9}{colour:#} {} {FAINT}({steps}, {checks}){FAINT:#}",
        result.end.word(),
        result.path.display()
    ));
    terminal.report(&result.report, &result.sources);
    if let Some(difference) = &result.difference {
        terminal.progress(difference.diff());
    }
}

fn json(result: &TestResult) -> serde_json::Value {
    let findings: Vec<serde_json::Value> = result
        .report
        .diagnostics
        .iter()
        .map(|finding| {
            let at = finding.primary.as_ref().map(|label| {
                let (line, column) = result.sources.position(label.span.file, label.span.start);
                json!({ "path": result.sources.path(label.span.file), "line": line, "column": column })
            });
            let severity = match finding.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            };
            json!({
                "severity": severity, "code": finding.code.name, "message": finding.message, "at": at,
            })
        })
        .collect();
    json!({
        "type": "test", "v": 1, "path": result.path.display().to_string(), "name": result.name,
        "verdict": result.end.word(), "steps": result.steps, "checks": result.checks, "findings": findings,
    })
}

/// Prints the numbers of results.
pub fn print_summary(results: &[TestResult], duration: Duration, terminal: &mut TerminalOutput) {
    let count = |exit| results.iter().filter(|one| one.end.exit() == exit).count() as u64;
    let mut parts = vec![format!("{} passed", count(Exit::Ok))];
    for (exit, word) in [(Exit::Findings, "failed"), (Exit::Usage, "cannot be run")] {
        if count(exit) > 0 {
            parts.push(format!("{} {word}", count(exit)));
        }
    }
    let what = counted(results.len() as u64, "scenario");
    terminal.status(
        "Tested",
        format_args!(
            "{what} in {:.2} s: {}",
            duration.as_secs_f64(),
            parts.join(", ")
        ),
    );
}
