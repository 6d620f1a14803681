//! `asmotion check`: what is wrong, before anything runs.

use crate::build;
use crate::exit::Exit;
use crate::files::Disk;
use crate::terminal::{Terminal, count};
use asm_lang::{Report, Severity, Sources};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

/// Says what is wrong with specifications and composites, before anything runs.
#[derive(Args)]
pub struct Check {
    /// Specifications (`.asm`) and composites (`.toml`).
    #[arg(required = true)]
    files: Vec<String>,

    /// How findings are written.
    #[arg(long, value_enum, default_value_t = Format::Full)]
    format: Format,

    /// The same as `--format json`.
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// How findings are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// With the lines they speak of, on standard error.
    Full,
    /// One line each, on standard output.
    Concise,
    /// One JSON document, on standard output.
    Json,
}

impl Check {
    /// Checks all files.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
        let format = if self.json { Format::Json } else { self.format };
        let mut total = Report::new();
        let mut documents = Vec::new();
        for path in &self.files {
            if format == Format::Full {
                terminal.status("Checking", path);
            }
            let (report, sources) = check(path);
            match format {
                Format::Full => terminal.report(&report, &sources),
                Format::Concise => {
                    for finding in &report.diagnostics {
                        terminal.result(asm_lang::concise(finding, &sources));
                    }
                }
                Format::Json => documents.extend(findings_json(&report, &sources)),
            }
            total.extend(report);
        }
        if format == Format::Json {
            terminal.result(
                json!({ "type": "check", "v": 1, "files": self.files, "findings": documents }),
            );
        }
        let files = match self.files.len() {
            1 => "1 file".to_owned(),
            several => format!("{several} files"),
        };
        match (count(&total), total.has_errors()) {
            (Some(found), true) => terminal.error(format_args!("{found} in {files}")),
            (Some(found), false) => terminal.status("Checked", format_args!("{files}: {found}")),
            (None, _) => terminal.status("Checked", format_args!("{files}: no findings")),
        }
        if total.has_errors() {
            Exit::Findings
        } else {
            Exit::Ok
        }
    }
}

/// The findings in one file and what it names.
fn check(path: &str) -> (Report, Sources) {
    if path.ends_with(".toml") {
        let opened = build::open(path, &[]);
        return (opened.report, opened.sources);
    }
    match asm_lang::open(path, &Disk) {
        Ok(specification) => (specification.report, specification.sources),
        Err(failure) => (failure.report, failure.sources),
    }
}

fn findings_json(report: &Report, sources: &Sources) -> Vec<Value> {
    let place = |label: &asm_lang::source::Label| {
        let (line, column) = sources.position(label.span.file, label.span.start);
        let (end_line, end_column) = sources.position(label.span.file, label.span.end);
        json!({
            "path": sources.path(label.span.file),
            "line": line, "column": column, "end_line": end_line, "end_column": end_column,
            "text": label.text,
        })
    };
    let each = report.diagnostics.iter().map(|finding| {
        let places: Vec<Value> = finding
            .primary
            .iter()
            .chain(&finding.secondary)
            .map(place)
            .collect();
        json!({
            "severity": match finding.severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
            },
            "code": finding.code, "message": finding.message, "places": places,
            "notes": finding.notes, "helps": finding.helps,
            "fix": finding.fix.as_ref().map(|fix| json!({
                "title": fix.title, "text": fix.text, "start": fix.span.start, "end": fix.span.end,
                "path": sources.path(fix.span.file),
            })),
        })
    });
    each.collect()
}
