use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Storage for states fails
///
/// With `asmotion verify --storage disk`, states and transitions are in files of a temporary folder. If they cannot be written or
/// read, because the disk is full or a network drive has gone away, nothing that was found can be relied on, and no verdict is given.
///
/// ```text wrong
/// asmotion verify large.asm --storage disk
/// ```
///
/// Choose a folder with enough space: about the number of states times the size of a state, and with temporal properties 4 bytes for
/// each transition in addition.
///
/// ```text corrected
/// asmotion verify large.asm --storage disk --storage-folder /mnt/scratch
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M013, error)]
#[error("the states that were found cannot be stored: {reason}")]
pub(crate) struct StorageFailure {
    pub reason: String,
    pub at: Span,
}

impl Finding for StorageFailure {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "while the states of this rule were explored")
            .help("provide more space, select another folder, or explore fewer states")
    }
}
