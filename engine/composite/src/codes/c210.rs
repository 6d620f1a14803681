use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Instances that cannot be determined
///
/// An element with the key `for` stands for several: one for each value of a variable, which is substituted in its names and
/// strings. The values are a range, a list of words, or a list of tables with the values of several variables. Properties in it, as in
/// `"$r in 1..${properties.robots}"`, need values when the file is read: a default that does not depend on the environment, or for
/// the outermost composite a value on the command line.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// for = "1..3"
/// implementation = { rust = "nav::MapServer" }
/// ```
///
/// Corrected, for the components `Map1`, `Map2` and `Map3`:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// for = "$r in 1..3"
/// implementation = { rust = "nav::MapServer" }
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C210, error)]
#[error("no instances: {reason}")]
pub(crate) struct InvalidInstances {
    /// Reason that there are none.
    pub reason: String,
    /// Location of the value of `for`, or of the element.
    pub at: Span,
    /// The value of `for` is the reason.
    pub is_malformed: bool,
    /// Location of another element with the same name.
    pub earlier: Option<Span>,
}

impl Finding for InvalidInstances {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let mut diagnostic = diagnostic.label(self.at, "here");
        if let Some(earlier) = self.earlier {
            diagnostic = diagnostic.label(earlier, "the other one");
        }
        if self.is_malformed {
            diagnostic = diagnostic.help(
                "`for` is a range, as in `\"$r in 1..20\"`, words, as in `\"$r in north, south\"`, or a list of tables, as in \
                 `[{ r = \"north\", x = 1.5 }]`",
            );
        }
        diagnostic
    }
}
