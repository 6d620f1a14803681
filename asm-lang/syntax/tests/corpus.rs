//! Every file the reference parser accepts is read without an error. Development only: the corpus
//! is not part of the project, and where it is absent the tests say so and pass.

use source::{FileId, Report, Severity, Sources};
use std::fs;
use std::path::{Path, PathBuf};

#[test]
fn reads_what_the_reference_reads() {
    let (Some(corpus), Some(table)) = (corpus(), shared("conformance/corpus.tsv")) else {
        println!("skipped: no corpus (set ASMETA_CORPUS)");
        return;
    };
    let table = fs::read_to_string(table).unwrap();
    let mut rows = table.lines();
    let columns: Vec<&str> = rows.next().unwrap().split('\t').collect();
    let column = |name| columns.iter().position(|&column| column == name).unwrap();
    let (path, verdict, reason) = (column("path"), column("parse_head"), column("reject_reason"));

    let mut read = 0;
    let mut refused = Vec::new();
    let mut missed = Vec::new();
    for row in rows.map(|row| row.split('\t').collect::<Vec<_>>()) {
        let Ok(bytes) = fs::read(corpus.join(row[path])) else { continue };
        let text = String::from_utf8_lossy(&bytes);
        let report = asm_syntax::parse(FileId(0), &text).report;
        read += 1;
        if row[verdict] == "OK" && report.has_errors() {
            refused.push(format!("{}\n{}", row[path], brief(&text, &report)));
        }
        if row[reason] == "syntax" {
            missed.push(format!("{}\n{}", row[path], brief(&text, &report)));
        }
    }
    println!("{read} files read; {} accepted by the reference and refused here", refused.len());
    println!("syntax errors of the reference, and what is said here:\n{}", missed.join("\n"));
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

fn corpus() -> Option<PathBuf> {
    std::env::var_os("ASMETA_CORPUS").map(PathBuf::from)
}

fn shared(path: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared").join(path);
    path.exists().then_some(path)
}

/// One line a finding.
fn brief(text: &str, report: &Report) -> String {
    let mut sources = Sources::new();
    let file = sources.add("", text);
    let lines = report.diagnostics.iter().map(|finding| {
        let (line, column) = finding
            .primary
            .as_ref()
            .map_or((0, 0), |label| sources.position(file, label.span.start));
        let kind = if finding.severity == Severity::Error { "error" } else { "warning" };
        format!("  {line}:{column} {kind} {} {}\n", finding.code, finding.message)
    });
    lines.collect()
}
