use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unknown block
///
/// `execblock` runs a block that `begin … end` declares in this scenario, or in another one: `execblock
/// other:block`.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   monitored wish: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = choose $x in {1 : 3} with $x != wish do n := $x
/// ```
///
/// ```avalla wrong
/// scenario example
/// load example.asm
///
/// execblock first;
/// ```
///
/// Corrected:
///
/// ```avalla corrected
/// scenario example
/// load example.asm
///
/// begin first
///   step
/// end
/// execblock first;
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(V011, error)]
#[error("unknown block `{name}`")]
pub(crate) struct UnknownBlock {
    pub name: String,
    pub at: Span,
    pub scenario: Option<String>,
    pub similar: Option<Arc<str>>,
}

impl Finding for UnknownBlock {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { scenario, .. } = self;
        let place = match scenario {
            Some(scenario) => format!("not declared in scenario `{scenario}`"),
            None => "not declared in this scenario".to_owned(),
        };
        diagnostic.label(self.at, place).did_you_mean(self.at, self.similar.as_deref())
                    .help("declare it with `begin name … end`, or write `execblock scenario:block` for a block of another file")
    }
}
