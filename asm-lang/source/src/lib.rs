//! Source texts, spans and diagnostics: what every stage points at.
//!
//! A [`Sources`] holds the texts; a [`Span`] is a place in one of them; a [`Diagnostic`] is what a
//! stage has to say about such places. Nothing here prints: `asm_lang::render` turns a diagnostic
//! into text for people, and `serde` turns it into JSON for tools.

mod diagnostic;
mod span;

pub use diagnostic::{Diagnostic, Fix, Label, Report, Severity};
pub use span::{FileId, LoadError, Loader, Sources, Span};
