//! The status and content of an input port, as a cycle reads it.

/// The result of reading an input port (RTT `FlowStatus`; TCA `receiveLast`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow<T> {
    /// No sample has arrived yet.
    NoData,
    /// The newest sample, which an earlier cycle has seen already.
    OldData(T),
    /// The newest sample, which has arrived since the last cycle.
    NewData(T),
}

impl<T> Flow<T> {
    /// The sample, if it is new.
    #[expect(clippy::new_ret_no_self, reason = "RTT's term: NewData")]
    pub fn new(self) -> Option<T> {
        match self {
            Self::NewData(sample) => Some(sample),
            Self::NoData | Self::OldData(_) => None,
        }
    }

    /// The sample, new or old.
    pub fn any(self) -> Option<T> {
        match self {
            Self::NewData(sample) | Self::OldData(sample) => Some(sample),
            Self::NoData => None,
        }
    }

    /// Returns whether the sample is new.
    pub fn is_new(&self) -> bool {
        matches!(self, Self::NewData(_))
    }
}
