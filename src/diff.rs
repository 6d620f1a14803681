//! Unified diffs.

use crate::terminal::NAME;
use anstyle::{AnsiColor, Style};
use similar::TextDiff;

const ADDED: Style = AnsiColor::Green.on_default();
const REMOVED: Style = AnsiColor::Red.on_default();

/// Number of unchanged lines around a change.
const CONTEXT: usize = 3;

/// Returns the changes from `before` to `after` in the format of `patch`, coloured if colour is enabled.
pub fn unified(path: &str, before: &str, after: &str) -> String {
    let diff = TextDiff::from_lines(before, after)
        .unified_diff()
        .context_radius(CONTEXT)
        .header(path, path)
        .to_string();
    let lines = diff.split('\n').map(|line| {
        let style = style(line);
        format!("{style}{line}{style:#}")
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn style(line: &str) -> Style {
    match line.as_bytes().first() {
        Some(b'+') => ADDED,
        Some(b'-') => REMOVED,
        Some(b'@') => NAME,
        _ => Style::new(),
    }
}
