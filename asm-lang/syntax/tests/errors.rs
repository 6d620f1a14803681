//! Every message, with a minimal text that triggers it.
//!
//! A file in `tests/errors` marks each line with a finding by `//~ CODE`. The messages are
//! snapshots; read them before you accept them.

#![allow(clippy::disallowed_methods, reason = "the texts are on the disk")]

use asmotion_diagnostics::{Applicability, Diagnostic, Edit, FileId, Severity, Sources};
use asmotion_syntax::parse;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

#[test]
fn says_what_is_wrong() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/errors");
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    for file in files {
        let name = file.file_stem().unwrap().to_str().unwrap().to_owned();
        let text = fs::read_to_string(&file).unwrap();
        let mut sources = Sources::new();
        let id = sources.add(&name, text.as_str());
        let report = parse(id, &text).report;

        let said: Vec<String> = report
            .diagnostics
            .iter()
            .map(|it| render(&sources, id, it))
            .collect();
        insta::assert_snapshot!(name.clone(), said.join("\n"));

        let line = |it: &Diagnostic| {
            sources
                .position(id, it.primary.as_ref().unwrap().span.start)
                .0
        };
        let found: Vec<(usize, &str)> = report
            .diagnostics
            .iter()
            .map(|it| (line(it), it.code.name))
            .collect();
        assert_eq!(found, expected(&text), "in {name}.asm");
    }
}

/// A code that is reported only by `parse_assignment`, which parses no file (see
/// `constructs/single_rules.rs`).
const OF_AN_ASSIGNMENT: &str = "L063";

#[test]
fn has_an_example_of_every_code() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files: Vec<String> = fs::read_dir(folder.join("src/codes"))
        .unwrap()
        .map(|file| file.unwrap().path())
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_uppercase())
        .collect();
    let codes: BTreeSet<&str> = files
        .iter()
        .map(String::as_str)
        .filter(|name| name.starts_with('L') && *name != OF_AN_ASSIGNMENT)
        .collect();
    let texts: Vec<String> = fs::read_dir(folder.join("tests/errors"))
        .unwrap()
        .map(|file| fs::read_to_string(file.unwrap().path()).unwrap())
        .collect();
    let examples: BTreeSet<&str> = texts
        .iter()
        .flat_map(|text| expected(text))
        .map(|(_, code)| code)
        .collect();
    assert_eq!(examples, codes);
}

/// Returns the expected codes of a text, with their lines.
fn expected(text: &str) -> Vec<(usize, &str)> {
    let marked = text.lines().enumerate().filter_map(|(line, text)| {
        let (_, codes) = text.split_once("//~")?;
        Some(codes.split_whitespace().map(move |code| (line + 1, code)))
    });
    marked.flatten().collect()
}

/// Renders `error L050 at 5:9 message`, followed by a line for each label, note, help and fix.
fn render(sources: &Sources, file: FileId, finding: &Diagnostic) -> String {
    let severity = match finding.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let mut lines = vec![format!("{severity} {}: {}", finding.code, finding.message)];
    for label in finding.primary.iter().chain(&finding.secondary) {
        let (line, column) = sources.position(file, label.span.start);
        lines.push(format!(
            "  {line}:{column} `{}` {}",
            sources.snippet(label.span),
            label.text
        ));
    }
    lines.extend(finding.notes.iter().map(|note| format!("  note: {note}")));
    lines.extend(finding.helps.iter().map(|help| format!("  help: {help}")));
    if let Some(fix) = &finding.fix {
        let edit = |edit: &Edit| format!("`{}` → `{}`", sources.snippet(edit.span), edit.text);
        let edits: Vec<String> = fix.edits.iter().map(edit).collect();
        let word = match fix.applicability {
            Applicability::Sure => "fix",
            Applicability::Maybe => "perhaps",
        };
        lines.push(format!("  {word}: {}: {}", fix.title, edits.join(", ")));
    }
    lines.join("\n")
}
