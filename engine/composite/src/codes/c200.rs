use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Invalid safe rule or property under `watch`
///
/// The safe rule is a rule, and a property is a Boolean term, in the scope of the specification. With `temporal = false`, no property is
/// watched.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   monitored estop: Boolean
///   controlled moving: Boolean
/// definitions:
///   CTLSPEC ag(estop implies ax(not moving))
///   rule r_stop = moving := false
///   main rule r_Main = moving := not estop
/// default init s0:
///   function moving = false
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Guard]
/// implementation = { asm = "example.asm" }
/// activity = { period_ms = 100 }
/// bind.monitored = { estop = { value = false } }
/// watch = { safe_rule = "r_halt[]" }
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
/// [components.Guard]
/// implementation = { asm = "example.asm" }
/// activity = { period_ms = 100 }
/// bind.monitored = { estop = { value = false } }
/// watch = { safe_rule = "r_stop[]" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C200, error)]
#[error("invalid {} `{text}`: {reason}", part.name())]
pub(crate) struct InvalidWatch {
    pub part: WatchedPart,
    pub text: String,
    pub reason: String,
    pub at: Span,
}

/// A part of `watch` that is written in the language of the specification.
#[derive(Clone, Copy, Debug)]
pub(crate) enum WatchedPart {
    SafeRule,
    Property,
    /// A property beside `temporal = false`.
    Unwatched,
}

impl WatchedPart {
    fn name(self) -> &'static str {
        match self {
            Self::SafeRule => "safe rule",
            Self::Property | Self::Unwatched => "property",
        }
    }
}

impl Finding for InvalidWatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        match self.part {
            WatchedPart::SafeRule => diagnostic
                .label(self.at, "not a rule of the specification")
                .help("write a rule as in a rule of the specification, such as `r_stop[]`"),
            WatchedPart::Unwatched => diagnostic
                .label(self.at, "has no effect")
                .help("remove the property, or `temporal = false`"),
            WatchedPart::Property => diagnostic
                .label(self.at, "not a property of the specification")
                .help("write a condition, or a formula of CTL or LTL"),
        }
    }
}
