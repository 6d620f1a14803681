//! Rendering of diagnostics.

use asmotion_diagnostics::{Report, Sources};
use asmotion_lang::Style;

/// Renders all diagnostics of a report.
pub fn report(sources: &Sources, report: &Report) -> String {
    let findings = report.diagnostics.iter();
    let rendered = findings.map(|finding| asmotion_lang::render(finding, sources, Style::Plain));
    rendered.collect::<Vec<_>>().join("\n\n")
}
