use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Message that does not fit into a mailbox
///
/// The messages that wait for a machine are part of the state, and therefore bounded. A run in which more messages wait is reported
/// as a step that fails, because messages beyond the bound would be lost without notice: the receiver is slower than its senders,
/// or never receives messages of this operation.
///
/// ```text wrong
/// asmotion verify sensor.asm logger.asm --mailbox 1
/// ```
///
/// Receive every operation, wait for a reply before the next request, or set a larger bound if the number of waiting messages is
/// bounded:
///
/// ```text corrected
/// asmotion verify sensor.asm logger.asm --mailbox 4
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M011, error)]
#[error("the mailbox of `{receiver}` is full: `{operation}` of `{sender}` does not fit")]
pub(crate) struct MailboxOverflow {
    pub receiver: String,
    pub sender: String,
    pub operation: String,
    /// Number of messages that fit.
    pub bound: usize,
    /// Place of the main rule of the sender.
    pub at: Span,
}

impl Finding for MailboxOverflow {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let (receiver, bound) = (&self.receiver, self.bound);
        let waiting = if bound == 1 {
            "1 message waits".to_owned()
        } else {
            format!("{bound} messages wait")
        };
        diagnostic
            .label(
                self.at,
                format!("a step of this rule sends while {waiting} for `{receiver}`"),
            )
            .help("receive every message, wait for replies, or set a larger bound with `--mailbox`")
    }
}
