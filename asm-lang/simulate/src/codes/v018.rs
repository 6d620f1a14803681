use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Specification without a main rule
///
/// A scenario runs steps, but a module has none. Load a specification that imports the module.
///
/// ```asm
/// module example
/// export *
/// signature:
/// definitions:
/// ```
///
/// ```avalla wrong
/// scenario example
/// load example.asm
///
/// step
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V018, error)]
#[error("specification `{name}` has no main rule")]
pub(crate) struct ScenarioWithoutMain {
    pub name: String,
    pub at: Span,
}

impl Finding for ScenarioWithoutMain {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
            .label(self.at, "a module cannot run")
            .help("load a specification that has a main rule and imports it")
    }
}
