use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// No value before the first message
///
/// The first step reads this function and cannot decide a guard, because the function is undef until a message has arrived: the
/// coordinator fails, unless the message is there first. `none` is its value until then, and in a specification `isDef` tests
/// for one.
///
/// ```asm
/// asm example
/// signature:
///   monitored near: Boolean
///   controlled stopped: Boolean
/// definitions:
///   main rule r_Main = if near then stopped := true endif
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { near = "std_msgs/Bool" }
/// bind = { monitored = { near = { topic = "near" } } }
///
/// [[promote]]
/// topic = "near"
/// as = "near"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "example.asm" }
/// subscribe = { near = "std_msgs/Bool" }
/// bind = { monitored = { near = { topic = "near", none = false } } }
///
/// [[promote]]
/// topic = "near"
/// as = "near"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C146, warning)]
#[error("`{function}` has no value before its first message, and the first step needs one")]
pub(crate) struct UndefinedAtStart {
    pub function: String,
    /// Place of the first binding.
    pub at: Span,
    /// Place of the guard or invariant that is undef.
    pub needed: Span,
    /// The key that gives it one, and an example.
    pub key: &'static str,
    pub example: &'static str,
}

impl Finding for UndefinedAtStart {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "undef until a message arrives")
            .label(self.needed, "undef in the first step, which fails")
            .help(format!(
                "give it a value until then, as in `{} = {}`, or test it with `isDef(…)`",
                self.key, self.example
            ))
    }
}
