use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Property about the locations of several machines
///
/// In a system, a property from the command line is resolved in one specification: that of the machine that it names, as in
/// `courier.mode = ASKING`. A term that compares locations of several machines has no place in any of them.
///
/// ```text wrong
/// asmotion verify courier.asm dispatcher.asm --property "courier.jobs <= dispatcher.finished"
/// ```
///
/// A further specification observes the machines: its inputs read the functions of the others, by name.
///
/// ```text corrected
/// asmotion verify courier.asm dispatcher.asm watch.asm
///
/// // watch.asm
/// signature:
///   monitored jobs: Integer
///   monitored finished: Integer
/// definitions:
///   invariant over jobs, finished: jobs <= finished
///   main rule r_Main = skip
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(M012, error)]
#[error("`{text}` is about several machines")]
pub(crate) struct SeveralMachines {
    pub text: String,
    /// Names of the machines, each with a place in the text where a location of it is meant.
    pub machines: Vec<(String, Span)>,
}

impl Finding for SeveralMachines {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let labels = self.machines.iter();
        let diagnostic = labels.fold(diagnostic, |diagnostic, (name, at)| {
            diagnostic.label(*at, format!("a location of `{name}`"))
        });
        diagnostic.help("verify a further specification that observes them: its monitored functions read those of the same names")
    }
}
