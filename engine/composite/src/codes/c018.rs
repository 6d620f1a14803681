use asmotion_diagnostics::{Coded, Diagnostic, Finding, Span};

/// Duplicate port name
///
/// Inputs share one set of names, whether they are listed under `ports.in` or `subscribe`. Outputs
/// share another: `ports.out` and `publish`.
///
/// ```toml wrong
/// schema = "composite/1"
///
/// [composite]
/// name = "example"
///
/// [components.Follower]
/// implementation = { process = "follower" }
/// subscribe = { path = "nav_msgs/Path" }
/// ports.in = { path = "nav_msgs/Path" }
///
/// [[promote]]
/// topic = "path"
/// as = "path"
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
/// [components.Follower]
/// implementation = { process = "follower" }
/// subscribe = { path = "nav_msgs/Path" }
///
/// [[promote]]
/// topic = "path"
/// as = "path"
/// ```
#[derive(Debug, thiserror::Error, Coded)]
#[code(C018, error)]
#[error("duplicate {way} `{name}` of `{component}`")]
pub(crate) struct DuplicatePort {
    pub way: &'static str,
    pub component: String,
    pub name: String,
    pub at: Span,
    pub first: Span,
}

impl Finding for DuplicatePort {
    fn explain(&self, diagnostic: Diagnostic) -> Diagnostic {
        diagnostic
                .label(self.at, "declared again here")
                .label(self.first, "first declared here")
                .help("rename one of them; `ports.in` and `subscribe` share their names, and so do `ports.out` and `publish`")
    }
}
