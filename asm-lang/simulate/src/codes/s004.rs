use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span, did_you_mean};
use std::sync::Arc;

/// Value of another domain
///
/// Booleans and numbers are written as they are, literals and strings in quotes, and sequences, sets
/// and tuples as arrays.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// signature:
///   enum domain Mode = {IDLE | BUSY}
///   monitored mode: Mode
///   monitored speed: Integer
///   controlled n: Integer
/// definitions:
///   main rule r_Main = if mode = BUSY then n := speed endif
/// ```
///
/// ```toml wrong
/// [default]
/// mode = "IDEL"
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// [default]
/// mode = "IDLE"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(S004, error)]
#[error("{what} is not {expected}")]
pub(crate) struct WrongInputValue {
    pub what: String,
    pub expected: String,
    pub at: Span,
    pub similar: Option<Arc<str>>,
    /// The elements of the domain, if they have names.
    pub elements: Vec<Arc<str>>,
}

/// Notation of values in a script.
const FORMS: &str = "write Booleans and numbers as they are, literals and strings in quotes, and sequences, sets and tuples as arrays";

impl Finding for WrongInputValue {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let help = match (&self.similar, self.elements.as_slice()) {
            (Some(name), _) => did_you_mean(name),
            (None, []) => FORMS.to_owned(),
            (None, names) => {
                let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
                format!("the elements are {}", names.join(", "))
            }
        };
        diagnostic
            .label(self.at, format!("expected {}", self.expected))
            .help(help)
    }
}
