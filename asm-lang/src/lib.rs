//! The language on one page: from a path to a machine that can step.
//!
//! ```
//! let mut files = asmotion_lang::Files::new();
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
//! machine.step(&mut asmotion_lang::NoInputs, &mut asmotion_lang::First, 0).map_err(|fault| specification.explain(&fault).message)?;
//! # Ok::<(), String>(())
//! ```

pub mod codes;
pub mod coverage;
mod explain;
mod files;
mod foreign;
mod history;
pub mod scenario;
mod session;

pub use asmotion_diagnostics::{
    Diagnostic, Loader, Report, Severity, Sources, Span, Style, concise, render, render_all,
};
pub use asmotion_hir::{FunctionKind, Model, ReadOptions};
pub use asmotion_machine::{
    BackEnd, Chooser, Environment, FaultKind, FirstChoice, Machine, NoInputs, Step, StepFault,
    Update,
};
pub use asmotion_value::Value;
pub use files::MemoryFiles;
pub use history::{History, HistoryEvent, LastWrite};
pub use session::Session;
pub use {
    asmotion_diagnostics as diagnostics, asmotion_hir as hir, asmotion_ir as ir,
    asmotion_machine as machine, asmotion_simulate as simulate, asmotion_stdlib as stdlib,
    asmotion_syntax as syntax, asmotion_value as value,
};

use std::fmt;
use std::sync::Arc;

/// A specification that can run: what it says, and what a machine executes.
#[derive(Debug)]
pub struct Specification {
    /// The resolved model.
    pub model: Model,
    /// The program a machine executes.
    pub program: Arc<ir::Program>,
    /// The place of each of the program's origins.
    pub origins: Vec<Span>,
    /// The texts.
    pub sources: Sources,
    /// Warnings.
    pub report: Report,
}

/// Why a specification cannot run.
#[derive(Debug)]
pub struct OpenFailure {
    /// The texts.
    pub sources: Sources,
    /// Errors and warnings.
    pub report: Report,
}

impl fmt::Display for OpenFailure {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&render_all(&self.report, &self.sources, Style::Plain))
    }
}

impl std::error::Error for OpenFailure {}

/// Opens a specification: a path in, a program out.
///
/// # Errors
/// A text cannot be read, or has errors: all of them are in the failure.
pub fn open(path: &str, loader: &dyn Loader) -> Result<Specification, OpenFailure> {
    open_with(path, loader, &ReadOptions::default())
}

/// Opens a specification as somebody asks for.
///
/// # Errors
/// As [`open`], or there is no such initial state.
pub fn open_with(
    path: &str,
    loader: &dyn Loader,
    options: &ReadOptions,
) -> Result<Specification, OpenFailure> {
    open_in(path, loader, Sources::new(), options)
}

/// Opens a specification beside texts that were read already.
fn open_in(
    path: &str,
    loader: &dyn Loader,
    mut sources: Sources,
    options: &ReadOptions,
) -> Result<Specification, OpenFailure> {
    let loaded = hir::load(path, loader, &mut sources);
    let (model, found) = hir::analyse_with(&loaded, &sources, options);
    let mut report = loaded.report;
    report.extend(found);
    let Some(model) = model else {
        return Err(OpenFailure {
            sources,
            report: report.finish(),
        });
    };
    match ir::lower(&model) {
        Ok(lowered) => {
            report.extend(lowered.warnings);
            let (program, origins) = (Arc::new(lowered.program), lowered.origins);
            Ok(Specification {
                model,
                program,
                origins,
                sources,
                report: report.finish(),
            })
        }
        Err(found) => {
            report.extend(found);
            Err(OpenFailure {
                sources,
                report: report.finish(),
            })
        }
    }
}

impl Specification {
    /// A machine in the initial state.
    ///
    /// # Errors
    /// An initial value cannot be computed, or an invariant does not hold initially.
    pub fn machine(&self) -> Result<Machine, Box<StepFault>> {
        #[cfg_attr(not(feature = "native"), expect(unused_mut, reason = "only closures"))]
        let mut machine = Machine::new(self.program.clone())?;
        #[cfg(feature = "native")]
        machine.set_native_compiler(&asmotion_native::Cranelift);
        Ok(machine)
    }

    /// Lowers the model anew, with what was added to it; what is counted goes on being counted. A
    /// machine goes on with [`Machine::adopt`].
    ///
    /// # Errors
    /// What was added cannot be lowered; the program is as before.
    pub fn lower(&mut self) -> Result<(), Report> {
        if !self.program.counted.is_empty() {
            return self.lower_covered();
        }
        let lowered = ir::lower(&self.model)?;
        (self.program, self.origins) = (Arc::new(lowered.program), lowered.origins);
        Ok(())
    }

    /// Lowers the model anew, to a program that counts what of it runs: see [`coverage::Coverage`].
    ///
    /// # Errors
    /// As [`Specification::lower`].
    pub fn lower_covered(&mut self) -> Result<(), Report> {
        let lowered = ir::lower(&self.model)?;
        (self.program, self.origins) = (Arc::new(lowered.program.covered()), lowered.origins);
        Ok(())
    }

    /// The function of this name that takes so many arguments, declared by the specification itself.
    pub fn function(&self, name: &str, arity: usize) -> Option<ir::FunctionId> {
        let mut own = self.model.own_functions();
        own.find(|(_, function)| &*function.name == name && function.parameters.len() == arity)
            .map(|(id, _)| ir::FunctionId(id.0))
    }

    /// The rule whose body a place is in.
    pub fn rule_at(&self, place: Span) -> Option<&hir::Rule> {
        self.model.rules.iter().find(|rule| {
            let body = rule.body.as_ref().map(|body| body.root.span);
            body.is_some_and(|body| {
                body.file == place.file && body.start <= place.start && place.end <= body.end
            })
        })
    }

    /// The place of an origin.
    pub fn span(&self, origin: ir::Origin) -> Span {
        self.origins
            .get(origin.0 as usize)
            .copied()
            .unwrap_or_default()
    }
}
