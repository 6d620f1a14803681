//! The environment of a system: where its inputs come from.

use asmotion_lang::Specification;
use asmotion_lang::simulate::Script;

/// The source of the inputs that no machine of a system provides.
#[derive(Debug, Default)]
pub enum EnvironmentModel {
    /// Any value in each step, independent of earlier ones.
    #[default]
    Free,
    /// An input keeps its value or changes: of the inputs that the last step read, at most so many change in a step.
    Hold {
        /// Greatest number of inputs that change in a step.
        changes: u32,
    },
    /// The inputs of each step; runs end with the script.
    Script(Script),
    /// Another specification makes a step before each step of the system, and provides the inputs with the names of its out and
    /// controlled functions.
    Specification(Box<Specification>),
}
