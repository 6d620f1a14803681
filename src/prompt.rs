//! Reads lines from the user, with completion and history if the build has the feature `tui`, or from a pipe.

#[cfg(feature = "tui")]
mod editor;
#[cfg(not(feature = "tui"))]
mod plain;
mod verb;

#[cfg(feature = "tui")]
pub use editor::Prompt;
#[cfg(not(feature = "tui"))]
pub use plain::Prompt;
pub use verb::{Verb, help, split, verb};

/// Result of reading a line.
pub enum PromptLine {
    /// A line.
    Text(String),
    /// The line was abandoned with Ctrl-C.
    #[cfg_attr(
        not(feature = "tui"),
        allow(dead_code, reason = "only the editor handles Ctrl-C")
    )]
    Nothing,
    /// End of input.
    End,
}
