//! Options for reading a specification.

/// Options for reading a specification, such as those of the command line.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// `true` to read and run the specification as the reference tools do where these observably
    /// deviate from the textbook (`--compat asmeta`). Default: `false`.
    pub compatible: bool,
    /// Name of the initial state to start from. `None` selects the default one.
    pub initial: Option<String>,
}
