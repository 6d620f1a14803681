use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Ambiguous autowire
///
/// With `autowire`, a reference is wired to the service with its interface. There must be exactly one.
///
/// ```xml wrong
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner" autowire="true">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps">
///       <interface.java interface="nav.MapService"/>
///     </reference>
///   </component>
/// </composite>
/// ```
///
/// Corrected:
///
/// ```xml corrected
/// <composite xmlns="http://docs.oasis-open.org/ns/opencsa/sca/200912" name="example">
///   <component name="Planner" autowire="true">
///     <implementation.java class="nav.Planner"/>
///     <reference name="maps">
///       <interface.java interface="nav.MapService"/>
///     </reference>
///   </component>
///   <component name="MapServer">
///     <implementation.java class="nav.Server"/>
///     <service name="maps">
///       <interface.java interface="nav.MapService"/>
///     </service>
///   </component>
/// </composite>
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(X009, error)]
#[error("automatic wiring of `{reference}` finds {}", found(.services))]
pub(crate) struct AmbiguousAutowire {
    pub reference: String,
    pub services: Vec<String>,
    pub at: Span,
}

impl Finding for AmbiguousAutowire {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let error = diagnostic.label(self.at, "wired automatically");
        if self.services.is_empty() {
            error.help("no service has this interface; name one with `target`")
        } else {
            error.help(format!(
                "name one with `target`: {}",
                self.services.join(" or ")
            ))
        }
    }
}

/// The number of services, in words.
fn found(services: &[String]) -> String {
    match services {
        [] => "no service".to_owned(),
        several => format!("{} services", several.len()),
    }
}
