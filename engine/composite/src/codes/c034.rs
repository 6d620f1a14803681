use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Reply expected from several services
///
/// A reference that is wired to several services notifies all of them and receives no reply. A caller
/// that needs a reply must be wired to a single service.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.Spare]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = ["Map.maps", "Spare.maps"]
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
/// [components.Map]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.Spare]
/// implementation = { rust = "nav::MapServer" }
/// services = { maps = "nav/MapService" }
///
/// [components.User]
/// implementation = { process = "user" }
/// references = { maps = "nav/MapService" }
///
/// [[wires]]
/// reference = "User.maps"
/// service = "Map.maps"
/// timeout_ms = 1000
/// ```
///
/// An operation has no reply if the wire has `oneway = true`, if its reply message is empty, or if the
/// out function that declares it has the codomain `Rule`.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C034, error)]
#[error("`{reference}` has several services, but {who}")]
pub(crate) struct AwaitsSeveral {
    pub reference: String,
    /// Description of the caller and the reply it awaits.
    pub who: String,
    pub at: Span,
    /// Source location in the specification or binding; `None` if the interface alone implies the reply.
    pub place: Option<Span>,
}

impl Finding for AwaitsSeveral {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let diagnostic = diagnostic.label(self.at, "only one service can reply");
        let diagnostic = match self.place {
            Some(place) => diagnostic.label(place, "expects a reply"),
            None => diagnostic,
        };
        diagnostic.help(
            "connect it to one service, or add `oneway = true` to notify all services without a reply",
        )
    }
}
