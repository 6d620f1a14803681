//! The pipeline of the language: from a path to a machine that can step.
//!
//! ```
//! let mut files = asmotion_lang::MemoryFiles::new();
//! files.add("counter.asm", "asm counter
//! import StandardLibrary
//! signature:
//!   controlled n: Integer
//! definitions:
//!   main rule r_Main = n := n + 1
//! default init s0:
//!   function n = 0
//! ");
//! let specification = asmotion_lang::open("counter.asm", &files).map_err(|failure| failure.to_string())?;
//! let mut machine = specification.machine().map_err(|fault| specification.explain(&fault).message)?;
//! machine.step(&mut asmotion_lang::NoInputs, &mut asmotion_lang::FirstChoice, 0).map_err(|fault| specification.explain(&fault).message)?;
//! # Ok::<(), String>(())
//! ```

pub mod codes;
mod control_states;
pub mod coverage;
mod explain;
mod files;
mod foreign;
pub mod guards;
mod history;
pub mod scenario;
mod session;
mod specification;

pub use asmotion_diagnostics::{
    Diagnostic, Loader, Report, Severity, Sources, Span, Style, concise, render, render_all,
};
pub use asmotion_hir::{FunctionKind, Model, ReadOptions};
pub use asmotion_machine::{
    BackEnd, Chooser, Environment, FaultKind, FirstChoice, Machine, NoInputs, Step, StepFault,
    Update,
};
pub use asmotion_value::Value;
pub use control_states::{ControlDiagram, ControlTransition};
pub use files::MemoryFiles;
pub use history::{History, HistoryEvent, LastWrite};
pub use session::Session;
pub use specification::{OpenFailure, Specification, open, open_with, unverified_properties};
pub use {
    asmotion_diagnostics as diagnostics, asmotion_hir as hir, asmotion_ir as ir,
    asmotion_machine as machine, asmotion_simulate as simulate, asmotion_stdlib as stdlib,
    asmotion_syntax as syntax, asmotion_value as value,
};
