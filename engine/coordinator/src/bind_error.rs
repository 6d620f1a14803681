//! Errors of a binding.

use crate::binding::BoundOperation;

/// A binding that does not fit its specification or component.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BindError {
    /// The specification has no function with this name and number of arguments.
    #[error("the specification has no function `{function}` with {arity} arguments")]
    UnknownFunction {
        /// Name of the function in the binding.
        function: String,
        /// Number of arguments in the binding.
        arity: usize,
    },
    /// An argument of a location is not an element of its domain.
    #[error("the domain of `{location}` has no element `{element}`")]
    UnknownElement {
        /// The location as bound.
        location: String,
        /// The argument as written, which names no element.
        element: String,
    },
    /// A variable has no field of the message as its key, or ranges over a domain whose elements are not known.
    #[error(
        "no key selects the elements of `${variable}` in `{location}`, or its domain is not finite"
    )]
    FreeVariable {
        /// The location as bound.
        location: String,
        /// Name of the variable.
        variable: String,
    },
    /// Two bindings supply the value of one location.
    #[error("two bindings supply the value of `{location}`")]
    BoundTwice {
        /// The location as bound.
        location: String,
    },
    /// A term does not fit the specification.
    #[error("invalid term `{term}`: {reason}")]
    InvalidTerm {
        /// The term as bound.
        term: String,
        /// The first error in it.
        reason: String,
    },
    /// A property that the composite states does not fit the specification.
    #[error("invalid property under `watch`: {reason}")]
    InvalidProperty {
        /// The first error in it.
        reason: String,
    },
    /// The safe rule does not fit the specification.
    #[error("invalid safe rule `{rule}`: {reason}")]
    InvalidRule {
        /// The rule as given.
        rule: String,
        /// The first error in it.
        reason: String,
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
    /// The function takes a number or a truth value that it cannot have.
    #[error("the codomain of `{function}` is neither Integer nor Natural nor Boolean")]
    NoCount {
        /// Name of the function.
        function: String,
    },
    /// The initial state cannot be built; the machine's error as text.
    #[error("{0}")]
    Initial(String),
}
