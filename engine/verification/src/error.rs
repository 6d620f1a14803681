//! Reasons for which a composite cannot be verified.

use asmotion_diagnostics::{Report, Sources};

/// The reason for which there is no specification of a component with its environment.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// A specification or protocol has errors, or does not fit its environment.
    #[error("a specification has errors")]
    Specification {
        /// Texts that the report refers to.
        sources: Box<Sources>,
        /// Errors, at least one.
        report: Report,
    },
    /// A file is a module.
    #[error("`{0}` has no main rule")]
    NoMainRule(String),
    /// No component of the plan has this name.
    #[error("the composite has no component `{0}` with a specification")]
    NoComponent(String),
    /// A binding or an annotation names a function that the specification does not declare.
    #[error(
        "`{component}` binds `{location}`, which its specification does not declare, or not with listed elements"
    )]
    NoFunction {
        /// Name of the component.
        component: String,
        /// Location as written.
        location: String,
    },
    /// An input takes outcomes of calls and the newest message or a timer.
    #[error(
        "`{location}` of `{component}` takes outcomes of calls beside the newest message or a timer, which is not modelled: \
         bind a function of its own to the outcomes"
    )]
    OutcomesBesideValues {
        /// Name of the component.
        component: String,
        /// Location in the specification of the whole.
        location: String,
    },
    /// An annotation of a protocol is not understood, or names something that the component does not have.
    #[error("protocol of `{component}`: {problem}")]
    Annotation {
        /// Name of the component.
        component: String,
        /// The fault.
        problem: String,
    },
    /// The messages of a component without a protocol have infinitely many values.
    #[error(
        "`{input}` of `{component}` has no finite list of values: give the component that sends it, or `{component}`, a protocol \
         (`protocol = \"FILE.asm\"`)"
    )]
    Unbounded {
        /// Name of the receiving component.
        component: String,
        /// Location of the monitored function.
        input: String,
    },
    /// A macro updates a location that is given as its argument.
    #[error(
        "`{function}` is an argument of the rule `{rule}`, which updates its parameter: the messages of such updates are not known; \
         update `{function}` directly"
    )]
    UpdatedParameter {
        /// Name of the out function.
        function: String,
        /// Name of the rule.
        rule: String,
    },
    /// A specification exchanges messages of `CommonBehavior`.
    #[error("`{0}` exchanges messages with partners (CommonBehavior)")]
    Messages(String),
}

/// The error of a specification with these findings.
pub(crate) fn failed(sources: &mut Sources, report: Report) -> ModelError {
    ModelError::Specification {
        sources: Box::new(std::mem::take(sources)),
        report: report.finish(),
    }
}
