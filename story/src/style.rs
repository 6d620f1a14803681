//! Colours by meaning. Colour is never the only carrier of information.

use anstyle::{AnsiColor, Style};

/// Success.
pub const GOOD: Style = AnsiColor::Green.on_default().bold();
/// Failure.
pub const BAD: Style = AnsiColor::Red.on_default().bold();
/// A warning.
pub const NOTE: Style = AnsiColor::Yellow.on_default();
/// A name.
pub const NAME: Style = AnsiColor::Cyan.on_default();
/// Details.
pub const FAINT: Style = Style::new().dimmed();
