use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A message queue whose messages have no size
///
/// All messages of a queue have at most the size with which it was made. Where a type has lists, the composite says how many
/// bytes the largest message has, and the other side says the same.
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
/// Mended:
///
/// ```toml mended
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
#[error("how large are the messages of `mqueue:{queue}`?")]
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
                format!("`{kind}` has lists, which may be of any length"),
            )
            .help(format!(
                "say how many bytes the largest has, the same as on the other side: \
                     `policy = {{ data_size = {EXAMPLE} }}`"
            ))
    }
}

/// Bytes of a message, in the example.
const EXAMPLE: usize = 256;
