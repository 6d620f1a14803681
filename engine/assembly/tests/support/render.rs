//! Findings as people see them.

use asm_lang::Style;
use source::{Report, Sources};

/// All findings of a report.
pub fn report(sources: &Sources, report: &Report) -> String {
    let findings = report.diagnostics.iter();
    let rendered = findings.map(|finding| asm_lang::render(finding, sources, Style::Plain));
    rendered.collect::<Vec<_>>().join("\n\n")
}
