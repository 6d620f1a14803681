use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// A property whose name has the wrong beginning
///
/// AsmetaS wants the names of invariants to begin with `inv_`, those of temporal properties with
/// `ctlSpec_` and `ltlSpec_`.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   invariant positive over n: n > 0
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 1
/// ```
///
/// Mended:
///
/// ```asm mended
/// asm example
/// import StandardLibrary
/// signature:
///   controlled n: Integer
/// definitions:
///   invariant inv_positive over n: n > 0
///   main rule r_Main = n := n + 1
/// default init s0:
///   function n = 1
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(L075, warning)]
#[error("`{name}` does not begin with `{prefix}`")]
pub(crate) struct PropertyPrefix {
    pub prefix: &'static str,
    pub name: String,
    pub at: Span,
}

impl Finding for PropertyPrefix {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { prefix, name, .. } = self;
        diagnostic.label(self.at, "AsmetaS refuses this name").fix(
            "rename it",
            self.at,
            format!("{prefix}{name}"),
        )
    }
}
