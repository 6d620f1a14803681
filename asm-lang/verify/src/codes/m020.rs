use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Fairness of an unknown rule or domain
///
/// Fairness (`//@Fair`, `//@StronglyFair`, `--fair`, `--strongly-fair`) is due to rules, given by their names, or to the elements of
/// a domain, given by its name. The domain must be finite, and a `choose` rule must have a variable that ranges over it.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// //@Fair r_Mvoe
/// signature:
///   controlled isOn: Boolean
///   monitored isPressed: Boolean
/// definitions:
///   rule r_Move = isOn := true
///   CTLSPEC af(isOn)
///   main rule r_Main = if isPressed then r_Move[] endif
/// default init s0:
///   function isOn = false
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// //@Fair r_Move
/// signature:
///   controlled isOn: Boolean
///   monitored isPressed: Boolean
/// definitions:
///   rule r_Move = isOn := true
///   CTLSPEC af(isOn)
///   main rule r_Main = if isPressed then r_Move[] endif
/// default init s0:
///   function isOn = false
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M020, error)]
#[error("fairness cannot be due to `{name}`: {reason}")]
pub(crate) struct UnknownFairName {
    pub name: String,
    pub reason: &'static str,
    /// The most similar rule or domain.
    pub similar: Option<String>,
    pub at: Span,
}

impl Finding for UnknownFairName {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = match &self.similar {
            Some(similar) => asmotion_diagnostics::did_you_mean(similar),
            None => "name a rule, or a finite domain over which a variable of `choose` ranges"
                .to_owned(),
        };
        diagnostic
            .label(self.at, "the steps of this rule are considered")
            .help(help)
    }
}
