use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Service at another address
///
/// A gateway provides the service at `/services/NAME`, whatever address its `uri` specifies.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Map">
///     <implementation.java class="nav.MapServer"/>
///     <service name="maps"><interface.java interface="nav.MapService"/></service>
///   </component>
///   <service name="maps" promote="Map/maps">
///     <binding.ws uri="http://localhost:8085/MapService"/>
///   </service>
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Map">
///     <implementation.java class="nav.MapServer"/>
///     <service name="maps"><interface.java interface="nav.MapService"/></service>
///   </component>
///   <service name="maps" promote="Map/maps">
///     <binding.ws uri="http://localhost:8085/services/maps"/>
///   </service>
/// </composite>
/// ```
///
/// Clients must call an operation at `/services/NAME/OPERATION`, with its argument in JSON.
#[derive(Debug, thiserror::Error, Coded)]
#[code(X014, warning)]
#[error("the address of `{of}` changes")]
pub(crate) struct MovedAddress {
    pub of: String,
    pub here: String,
    pub at: Span,
}

impl Finding for MovedAddress {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let Self { here, .. } = self;
        diagnostic.label(self.at, format!("now `{here}`")).help(
            "change the callers: append the name of the operation, and send the argument as JSON",
        )
    }
}
