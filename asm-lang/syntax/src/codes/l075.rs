use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Prefix of a property name
///
/// AsmetaS requires names of invariants to start with `inv_`, and names of temporal properties with
/// `ctlSpec_` or `ltlSpec_`.
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
/// Corrected:
///
/// ```asm corrected
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
#[error("`{name}` does not start with `{prefix}`")]
pub(crate) struct PropertyPrefix {
    pub prefix: &'static str,
    pub name: String,
    pub at: Span,
}

impl Finding for PropertyPrefix {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { prefix, name, .. } = self;
        diagnostic.label(self.at, "AsmetaS rejects this name").fix(
            "rename it",
            self.at,
            format!("{prefix}{name}"),
        )
    }
}
