use asmotion_datum::SchemaDifference;
use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Incompatible operation
///
/// A reference and the service at the other end of its wire have the same interface, but the service lacks an operation that the
/// reference calls, or its request or response has another type. A component of the executable and a program declare the
/// operations of an interface separately; a specification uses those of the executable, or else those of a program.
///
/// An interface with other operations is another interface: give it another name, or adapt the calls with a `port-proxy`.
/// In this example the program `surveyor` calls an operation `erase`, which the program `archive` has.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Surveyor]
/// implementation = { process = "surveyor" }
///
/// [components.Maps]
/// implementation = { rust = "nav::MapServer" }
/// properties = { source = "map.yaml" }
///
/// [[wires]]
/// reference = "Surveyor.maps"
/// service = "Maps.maps"
/// timeout_ms = 500
/// ```
///
/// Corrected:
///
/// ```toml corrected
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Surveyor]
/// implementation = { process = "surveyor" }
///
/// [components.Maps]
/// implementation = { process = "archive" }
///
/// [[wires]]
/// reference = "Surveyor.maps"
/// service = "Maps.maps"
/// timeout_ms = 500
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C155, error)]
#[error("incompatible operation: `{reference}` calls `{operation}` of `{interface}`, which `{service}` {}", Problem(difference.as_ref()))]
pub(crate) struct OperationMismatch {
    pub reference: String,
    pub service: String,
    pub interface: String,
    pub operation: String,
    /// The place where the types differ, and the type; `None` if the service does not have the operation.
    pub difference: Option<OperationDifference>,
    pub at: Span,
    pub reference_at: Span,
}

/// A difference between the request or response types of an operation.
#[derive(Debug)]
pub(crate) struct OperationDifference {
    /// `request` or `response`.
    pub part: &'static str,
    /// From the service's type to that of the reference.
    pub types: SchemaDifference,
}

struct Problem<'a>(Option<&'a OperationDifference>);

impl std::fmt::Display for Problem<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            None => f.write_str("does not have"),
            Some(difference) => write!(f, "declares with another {}", difference.part),
        }
    }
}

impl Finding for OperationMismatch {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let service = match &self.difference {
            None => "no such operation".to_owned(),
            Some(difference) => difference.types.to_string(),
        };
        diagnostic
            .label(self.at, service)
            .label(self.reference_at, format!("calls `{}`", self.operation))
            .help("declare the same operation on both sides, or give one of the interfaces another name")
    }
}
