use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};
use std::sync::Arc;

/// Unreached literal
///
/// No function can take this literal of an enumeration: no rule assigns it, and no initial value, definition, monitored
/// function or range yields it. A condition that compares with it always has the same value.
///
/// ```asm wrong
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | RUNNING | FAILED}
///   controlled mode: Mode
///   controlled faults: Integer
/// definitions:
///   main rule r_Main =
///     switch mode
///       case IDLE: mode := RUNNING
///       case RUNNING: if faults > 3 then mode := IDLE else faults := faults + 1 endif
///       case FAILED: faults := 0
///     endswitch
/// default init s0:
///   function mode = IDLE
///   function faults = 0
/// ```
///
/// Corrected:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | RUNNING | FAILED}
///   controlled mode: Mode
///   controlled faults: Integer
/// definitions:
///   main rule r_Main =
///     switch mode
///       case IDLE: mode := RUNNING
///       case RUNNING: if faults > 3 then mode := FAILED else faults := faults + 1 endif
///       case FAILED: faults := 0
///     endswitch
/// default init s0:
///   function mode = IDLE
///   function faults = 0
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(W033, warning)]
#[error("no function takes the value {}", listed(literals))]
pub(crate) struct UnreachedElement {
    /// At least one literal; several if nothing mentions them.
    pub literals: Vec<Arc<str>>,
    pub domain: Arc<str>,
    /// Span of the first literal in the declaration.
    pub declared: Span,
    /// The first comparison with the literal; `None` if nothing mentions it.
    pub compared: Option<Span>,
}

impl Finding for UnreachedElement {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let literals = listed(&self.literals);
        let domain = &self.domain;
        match self.compared {
            Some(compared) => diagnostic
                .label(compared, "compared with it here")
                .label(self.declared, format!("literal of `{domain}`"))
                .help(format!(
                    "add the rule that assigns {literals}, or remove what depends on it"
                )),
            None => diagnostic
                .label(self.declared, format!("nothing uses it in `{domain}`"))
                .help(format!(
                    "remove {literals}, or add the rule that assigns it"
                )),
        }
    }
}

/// The names in backquotes, joined with commas and "or".
fn listed(names: &[Arc<str>]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, first)) if !first.is_empty() => format!("{} or {last}", first.join(", ")),
        Some((last, _)) => last.clone(),
        None => String::new(),
    }
}
