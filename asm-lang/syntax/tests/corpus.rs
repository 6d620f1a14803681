//! Files accepted by the reference parser are parsed without errors, and its syntax errors are
//! errors here, too. For development only: the corpus is not part of the project. `ASMETA_CORPUS`
//! names its folder; without it, the test prints a notice and passes.

#![allow(clippy::disallowed_methods, reason = "the corpus is on the disk")]

use asmotion_diagnostics::{FileId, Report, Severity, Sources};
use asmotion_syntax::parse;
use std::fs;

#[test]
fn reads_what_the_reference_reads() {
    let table = asmotion_skip::shared("conformance/corpus.tsv");
    let (Some(corpus), Some(table)) = (asmotion_skip::corpus(), table) else {
        return;
    };
    let table = fs::read_to_string(table).unwrap();
    let mut rows = table.lines().map(|row| row.split('\t').collect::<Vec<_>>());
    let columns = rows.next().unwrap();
    let column = |name| columns.iter().position(|&column| column == name).unwrap();
    let (path, verdict, reason) = (
        column("path"),
        column("parse_head"),
        column("reject_reason"),
    );

    let (mut accepted, mut refused) = (0, 0);
    for row in rows {
        let Ok(bytes) = fs::read(corpus.join(row[path])) else {
            continue;
        };
        let text = String::from_utf8_lossy(&bytes);
        let report = parse(FileId(0), &text).report;
        if row[verdict] == "OK" {
            accepted += 1;
            assert!(
                !report.has_errors(),
                "{}\n{}",
                row[path],
                brief(&text, &report)
            );
        }
        if row[reason] == "syntax" {
            refused += 1;
            assert!(report.has_errors(), "{} is accepted", row[path]);
            println!("{}\n{}", row[path], brief(&text, &report));
        }
    }
    println!("{accepted} files accepted and {refused} refused, as the reference does");
}

/// Renders findings, one a line.
fn brief(text: &str, report: &Report) -> String {
    let mut sources = Sources::new();
    let file = sources.add("", text);
    let lines = report.diagnostics.iter().map(|finding| {
        let start = finding.primary.as_ref().map_or(0, |label| label.span.start);
        let (line, column) = sources.position(file, start);
        let kind = if finding.severity == Severity::Error {
            "error"
        } else {
            "warning"
        };
        format!(
            "  {line}:{column} {kind} {} {}\n",
            finding.code, finding.message
        )
    });
    lines.collect()
}
