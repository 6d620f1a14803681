//! Source texts, spans and diagnostics, shared by the language and the composites.
//!
//! [`Sources`] holds the texts, and a [`Span`] is a range in one of them. A stage describes a
//! problem as a [`Finding`], a struct of facts whose [`Code`] carries the documentation page;
//! [`Finding::diagnostic`] puts it into words. A [`Diagnostic`] may offer a [`Fix`] that a tool can
//! [`apply`], [`similar`] finds the name that was probably meant, and [`render()`] formats a
//! diagnostic as text. Nothing here prints or reads a file: texts come from a [`Loader`].

mod code;
mod diagnostic;
mod fix;
mod loader;
mod render;
mod similar;
mod sources;
mod span;

pub use asmotion_diagnostics_derive::Coded;
pub use code::{Code, Coded, Finding};
pub use diagnostic::{Diagnostic, Label, Report, Severity};
pub use fix::{Applicability, Edit, Fix, Fixed, apply};
pub use loader::{LoadError, Loader};
pub use render::{Style, concise, render, render_all};
pub use similar::{did_you_mean, or_did_you_mean, similar};
pub use sources::Sources;
pub use span::{FileId, Span};
