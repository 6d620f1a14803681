//! Source texts, spans and diagnostics, shared by the language and the composites.
//!
//! [`Sources`] holds the texts, and a [`Span`] is a range in one of them. A stage describes a
//! problem as a [`Finding`], a struct of facts whose [`Code`] carries the documentation page;
//! [`Finding::diagnostic`] puts it into words. A [`Diagnostic`] may offer a [`Fix`] that a tool can
//! [`apply()`], [`similar()`] finds the name that was probably meant, and [`render()`] formats a
//! diagnostic as text. Nothing here prints or reads a file: texts come from a [`Loader`].

mod apply;
mod code;
mod diagnostic;
mod finding;
mod fix;
mod loader;
mod render;
mod severity;
mod similar;
mod sources;
mod span;

pub use apply::{Fixed, apply};
pub use asmotion_diagnostics_derive::Coded;
pub use code::{Code, Coded};
pub use diagnostic::{Diagnostic, Label, Report};
pub use finding::Finding;
pub use fix::{Applicability, Edit, Fix};
pub use loader::{LoadError, Loader};
pub use render::{Style, concise, render, render_all};
pub use severity::Severity;
pub use similar::{did_you_mean, or_did_you_mean, similar};
pub use sources::Sources;
pub use span::{FileId, Span};
