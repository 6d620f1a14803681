use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Message queue without a message size
///
/// A queue is created with a maximum message size. A type with lists has no fixed size, so the
/// composite must give the size of its largest message in bytes, and the other side must use the same
/// value.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Driver]
/// implementation = { process = "driver" }
/// ports.out = { joints = "f64[]" }
///
/// [[connections]]
/// from = "Driver.joints"
/// to = "mqueue:/joints"
/// policy = { type = "buffer", size = 10 }
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
/// [components.Driver]
/// implementation = { process = "driver" }
/// ports.out = { joints = "f64[]" }
///
/// [[connections]]
/// from = "Driver.joints"
/// to = "mqueue:/joints"
/// policy = { type = "buffer", size = 10, data_size = 48 }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C062, error)]
#[error("missing message size of `mqueue:{queue}`")]
pub(crate) struct NoMqueueSize {
    pub kind: String,
    pub queue: String,
    pub at: Span,
}

impl Finding for NoMqueueSize {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { kind, .. } = self;
        diagnostic
            .label(
                self.at,
                format!("`{kind}` contains lists, so its size is not fixed"),
            )
            .help(format!(
                "write the size of the largest message in bytes, as on the other side: `policy = {{ data_size = {EXAMPLE} }}`"
            ))
    }
}

/// Message size in bytes suggested in the help.
const EXAMPLE: usize = 256;
