//! Severity of a finding.

/// Severity of a finding, fixed by its code; errors order before warnings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The specification or composite cannot be used.
    Error,
    /// Usable, but probably not as intended.
    Warning,
}
