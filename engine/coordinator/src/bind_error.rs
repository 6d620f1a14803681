//! Errors of a binding.

use crate::binding::BoundOperation;

/// A binding that does not fit its specification or component.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindError {
    /// The specification has no function with this name and without arguments.
    #[error("the specification has no function `{function}` without arguments")]
    UnknownFunction {
        /// Name of the function in the binding.
        function: String,
    },
    /// The component has no such port.
    #[error("the component has no port `{port}`")]
    UnknownPort {
        /// Name of the port in the binding.
        port: String,
    },
    /// The component has no such service or reference.
    #[error("the component has no reference `{}` with an operation `{}`", .0.service, .0.operation)]
    UnknownOperation(BoundOperation),
    /// The function's codomain does not contain the value.
    #[error("invalid value `{value}` for `{function}`")]
    NotAValue {
        /// Name of the function.
        function: String,
        /// The value as text.
        value: String,
    },
    /// The initial state cannot be built; the machine's error as text.
    #[error("{0}")]
    Initial(String),
}
