//! Source texts, spans and diagnostics: what every stage points at.
//!
//! A [`Sources`] holds the texts; a [`Span`] is a place in one of them; a [`Diagnostic`] is what a
//! stage has to say about such places, with a [`Fix`] where a machine can mend it. Nothing here prints: `asm_lang::render` turns a diagnostic
//! into text for people, and `serde` turns it into JSON for tools.

mod diagnostic;
mod fix;
mod span;

pub use diagnostic::{Diagnostic, Label, Report, Severity};
pub use fix::{Applicability, Edit, Fix, Fixed, apply};
pub use span::{FileId, LoadError, Loader, Sources, Span};
