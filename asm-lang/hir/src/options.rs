//! How a specification is read.

/// What whoever opens a specification may ask for.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Whether it is to be read and run as the reference tools do, where these observably differ from
    /// the textbook (`--compat asmeta`).
    pub compatible: bool,
    /// The name of the initial state to begin in; the default one without.
    pub initial: Option<String>,
}
