//! The sources of a component's model.

use asmotion_diagnostics::Loader;
use asmotion_lang::hir::ReadOptions;
use asmotion_plan::Plan;

/// The composite, and where the protocols of its components come from.
pub struct ModelContext<'a> {
    /// The composite.
    pub plan: &'a Plan,
    /// Reads specifications and protocols.
    pub loader: &'a dyn Loader,
    /// Returns the text of the protocol that comes with a component of the catalogue.
    pub protocols: &'a dyn Fn(&str) -> Option<String>,
    /// Initial state of the specification.
    pub options: ReadOptions,
}
