//! Findings as JSON.

use asmotion_diagnostics::{Applicability, Fix, Label, Span};
use asmotion_lang::{Diagnostic, Severity, Sources};
use serde_json::{Value, json};

/// One finding, with lines, columns and bytes of every place.
pub fn finding(finding: &Diagnostic, sources: &Sources) -> Value {
    let labels = finding.primary.iter().chain(&finding.secondary);
    let places: Vec<Value> = labels.map(|label| labelled(label, sources)).collect();
    json!({
        "severity": match finding.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
        },
        "code": finding.code.name, "message": finding.message, "places": places,
        "notes": finding.notes, "helps": finding.helps,
        "fix": finding.fix.as_ref().map(|it| fix(it, sources)),
    })
}

fn labelled(label: &Label, sources: &Sources) -> Value {
    let mut place = place(label.span, sources);
    place["text"] = label.text.as_str().into();
    place
}

fn fix(fix: &Fix, sources: &Sources) -> Value {
    let edit = |edit: &asmotion_diagnostics::Edit| {
        let mut place = place(edit.span, sources);
        place["text"] = edit.text.as_str().into();
        place
    };
    let edits: Vec<Value> = fix.edits.iter().map(edit).collect();
    let sure = fix.applicability == Applicability::Sure;
    json!({ "title": fix.title, "sure": sure, "edits": edits })
}

/// Lines and columns count from 1, bytes from 0; ends are exclusive.
fn place(span: Span, sources: &Sources) -> Value {
    let (line, column) = sources.position(span.file, span.start);
    let (end_line, end_column) = sources.position(span.file, span.end);
    json!({
        "path": sources.path(span.file),
        "line": line, "column": column, "end_line": end_line, "end_column": end_column,
        "start": span.start, "end": span.end,
    })
}
