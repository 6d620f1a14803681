use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Unreadable file
///
/// A composite refers to specifications, nested composites and type files by paths relative to its own
/// folder. The file must exist and be smaller than a few megabytes.
///
/// ```asm
/// asm example
/// signature:
/// definitions:
///   main rule r_Main = skip
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Coordinator]
/// implementation = { asm = "exmaple.asm" }
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
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C002, error)]
#[error("cannot read `{path}`: {reason}")]
pub(crate) struct UnreadableComposite {
    pub path: String,
    pub reason: String,
    pub at: Option<Span>,
}

impl Finding for UnreadableComposite {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { at, .. } = self;
        match at {
            Some(at) => diagnostic
                .label(*at, "named here")
                .help("write the path relative to the folder of this file"),
            None => diagnostic.help("check the path"),
        }
    }
}
