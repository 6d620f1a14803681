//! Diagnostics as text, in a long form with snippets and a concise one.

use crate::diagnostic::{Diagnostic, Label, Report};
use crate::fix::{Edit, Fix};
use crate::severity::Severity;
use crate::sources::Sources;
use crate::span::FileId;
use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Patch, Renderer, Snippet};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Output format of [`render`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Text without escape sequences.
    Plain,
    /// Text with ANSI colours, for a terminal.
    Coloured,
}

/// Lines of the sources longer than this number of characters are cut around the label.
const WIDTH: usize = 120;

/// Renders all findings, followed by a line that counts them.
pub fn render_all(report: &Report, sources: &Sources, style: Style) -> String {
    let mut text = String::new();
    for diagnostic in &report.diagnostics {
        text.push_str(&render(diagnostic, sources, style));
        text.push_str("\n\n");
    }
    text
}

/// Renders one finding with the source lines that its labels refer to.
pub fn render(diagnostic: &Diagnostic, sources: &Sources, style: Style) -> String {
    let renderer = match style {
        Style::Plain => Renderer::plain(),
        Style::Coloured => Renderer::styled(),
    };
    let renderer = renderer.decor_style(DecorStyle::Ascii).term_width(WIDTH);
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let title = level
        .primary_title(diagnostic.message.as_str())
        .id(diagnostic.code.name);
    let mut group = Group::with_title(title).elements(snippets(diagnostic, sources));
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(note.as_str()));
    }
    let mut groups = vec![group];
    if let Some(fix) = &diagnostic.fix {
        let patches = patches(fix, sources);
        groups.push(
            Level::HELP
                .secondary_title(fix.title.as_str())
                .elements(patches),
        );
    }
    for help in &diagnostic.helps {
        groups.push(Group::with_title(
            Level::HELP.secondary_title(help.as_str()),
        ));
    }
    renderer.render(&groups)
}

/// Renders one finding on one line: `path:line:column: severity[code]: message`.
pub fn concise(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let mut text = String::new();
    if let Some(label) = &diagnostic.primary {
        let (line, column) = sources.position(label.span.file, label.span.start);
        // writing to a string cannot fail
        let _ = write!(text, "{}:{line}:{column}: ", sources.path(label.span.file));
    }
    let severity = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let _ = write!(
        text,
        "{severity}[{}]: {}",
        diagnostic.code, diagnostic.message
    );
    text
}

/// Returns one snippet for each file, that of the primary label first.
fn snippets<'a>(
    diagnostic: &'a Diagnostic,
    sources: &'a Sources,
) -> impl Iterator<Item = Snippet<'a, Annotation<'a>>> {
    let primary = diagnostic
        .primary
        .iter()
        .map(|label| (AnnotationKind::Primary, label));
    let secondary = diagnostic
        .secondary
        .iter()
        .map(|label| (AnnotationKind::Context, label));
    let mut order: Vec<FileId> = Vec::new();
    let mut files: BTreeMap<FileId, Vec<(AnnotationKind, &Label)>> = BTreeMap::new();
    for (kind, label) in primary.chain(secondary) {
        if !order.contains(&label.span.file) {
            order.push(label.span.file);
        }
        files
            .entry(label.span.file)
            .or_default()
            .push((kind, label));
    }
    order.into_iter().filter_map(move |file| {
        let text = sources.text(file);
        let mut snippet = Snippet::source(text).path(sources.path(file));
        for (kind, label) in files.remove(&file)? {
            let annotation = kind
                .span(within(label.span.range(), text))
                .label(label.text.as_str());
            snippet = snippet.annotation(annotation);
        }
        Some(snippet)
    })
}

/// Returns the lines of a fix as they read after it is applied.
fn patches<'a>(fix: &'a Fix, sources: &'a Sources) -> Option<Snippet<'a, Patch<'a>>> {
    let file = fix.edits.first()?.span.file;
    let text = sources.text(file);
    let patch = |edit: &'a Edit| Patch::new(within(edit.span.range(), text), edit.text.as_str());
    let edits = fix.edits.iter().filter(|edit| edit.span.file == file);
    let snippet = Snippet::source(text).path(sources.path(file));
    Some(snippet.patches(edits.map(patch)))
}

/// Clamps a range to the text and to character boundaries.
fn within(range: std::ops::Range<usize>, text: &str) -> std::ops::Range<usize> {
    let mut start = range.start.min(text.len());
    while !text.is_char_boundary(start) {
        start -= 1;
    }
    let mut end = range.end.clamp(start, text.len());
    while !text.is_char_boundary(end) {
        end += 1;
    }
    start..end
}
