use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Properties that no run can violate
///
/// A run watches the temporal properties of its specification, but can refute only what a finite run can: that something bad never
/// happens, or that something good happens within a time. That something happens at some time, or is possible, is proved or refuted by
/// `asmotion verify` only.
///
/// ```asm
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   monitored estop: Boolean
///   controlled moving: Boolean
/// definitions:
///   CTLSPEC ag(ef(moving))
///   rule r_stop = moving := false
///   main rule r_Main = moving := not estop
/// default init s0:
///   function moving = false
/// ```
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Guard]
/// implementation = { asm = "example.asm" }
/// activity = { period_ms = 100 }
/// bind.monitored = { estop = { value = false } }
/// ```
///
/// Corrected, something that has to happen within a time:
///
/// ```asm corrected
/// asm example
/// import StandardLibrary
/// import CTLLibrary
/// signature:
///   monitored estop: Boolean
///   controlled moving: Boolean
/// definitions:
///   //@Within 500 ms
///   CTLSPEC ag(estop implies af(not moving))
///   rule r_stop = moving := false
///   main rule r_Main = moving := not estop
/// default init s0:
///   function moving = false
/// ```
///
/// `verify` of the component proves the others before it starts: the warning then disappears.
#[derive(Debug, thiserror::Error, Coded)]
#[code(C201, warning)]
#[error("{}, which a run cannot watch", properties(unwatched.len()))]
pub(crate) struct UnwatchedProperties {
    /// Places of the properties, with the reasons.
    pub unwatched: Vec<(Span, String)>,
}

fn properties(count: usize) -> String {
    match count {
        1 => "1 temporal property".to_owned(),
        _ => format!("{count} temporal properties"),
    }
}

impl Finding for UnwatchedProperties {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        let labels = self.unwatched.iter();
        labels
            .fold(diagnostic, |diagnostic, (at, reason)| {
                diagnostic.label(*at, reason.clone())
            })
            .note("`asmotion verify` proves them, or shows a run that violates them")
            .help("a comment `//@Within 2 s` before a property such as `ag(p implies af(q))` lets a run watch it")
    }
}
