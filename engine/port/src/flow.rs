//! What an input port shows to a cycle.

/// What an input port shows (RTT `FlowStatus`; TCA `receiveLast`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow<T> {
    /// Nothing has ever come.
    NoData,
    /// The newest sample, seen by an earlier cycle too.
    OldData(T),
    /// The newest sample, come since the last cycle.
    NewData(T),
}

impl<T> Flow<T> {
    /// The sample, if it is new.
    #[allow(
        clippy::new_ret_no_self,
        clippy::wrong_self_convention,
        reason = "RTT's word: NewData"
    )]
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

    /// Whether the sample is new.
    pub fn is_new(&self) -> bool {
        matches!(self, Self::NewData(_))
    }
}
