//! Source texts, spans and diagnostics: what every stage points at.
//!
//! A [`Sources`] holds the texts; a [`Span`] is a place in one of them; a [`Diagnostic`] is what a
//! stage has to say about such places, with a [`Fix`] where a machine can mend it, and [`similar`] finds
//! what was meant. Nothing here prints: `asmotion_lang::render` turns a diagnostic into text for people.

mod diagnostic;
mod fix;
mod similar;
mod span;

pub use diagnostic::{Diagnostic, Label, Report, Severity};
pub use fix::{Applicability, Edit, Fix, Fixed, apply};
pub use similar::similar;
pub use span::{FileId, LoadError, Loader, Sources, Span};
