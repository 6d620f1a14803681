//! Opens specifications: from a path to a program for a machine.

use asmotion_diagnostics::{Diagnostic, Loader, Report, Sources, Span, Style, render_all};
use asmotion_hir::{self as hir, Model, ReadOptions};
use asmotion_ir as ir;
use asmotion_machine::{Machine, StepFault};
use std::fmt;
use std::sync::Arc;

/// A specification without errors: its model, and the program for a machine.
#[derive(Debug)]
pub struct Specification {
    /// The resolved and typed specification.
    pub model: Model,
    /// The program, shared with the machines that execute it.
    pub program: Arc<ir::Program>,
    /// The span of each [`ir::Origin`] of the program, indexed by its number.
    pub origins: Vec<Span>,
    /// The source texts, for rendering diagnostics.
    pub sources: Sources,
    /// Warnings found while opening it.
    pub report: Report,
}

/// The errors of a specification that cannot be opened.
#[derive(Debug)]
pub struct OpenFailure {
    /// The source texts, for rendering the report.
    pub sources: Sources,
    /// Errors, at least one, and warnings.
    pub report: Report,
}

impl fmt::Display for OpenFailure {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&render_all(&self.report, &self.sources, Style::Plain))
    }
}

impl std::error::Error for OpenFailure {}

/// Opens the specification at a path, with default options.
///
/// # Errors
/// A text cannot be read or contains errors; the failure lists all of them.
pub fn open(path: &str, loader: &dyn Loader) -> Result<Specification, OpenFailure> {
    open_with(path, loader, &ReadOptions::default())
}

/// Opens the specification at a path.
///
/// # Errors
/// As [`open`], or the requested initial state does not exist.
pub fn open_with(
    path: &str,
    loader: &dyn Loader,
    options: &ReadOptions,
) -> Result<Specification, OpenFailure> {
    open_in(path, loader, Sources::new(), options)
}

/// Opens a specification in a collection that already contains texts.
pub(crate) fn open_in(
    path: &str,
    loader: &dyn Loader,
    mut sources: Sources,
    options: &ReadOptions,
) -> Result<Specification, OpenFailure> {
    let mut loaded = hir::load(path, loader, &mut sources);
    let (model, found) = hir::analyse_with(&mut loaded, &sources, options);
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
            report.extend(unverified_properties(&model).into_iter().collect());
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

/// Returns a warning if the specification has properties that runs do not check.
pub fn unverified_properties(model: &Model) -> Option<Diagnostic> {
    hir::unverified_properties(model, |property| ir::is_watched(model, property))
}

impl Specification {
    /// Creates a machine in the initial state.
    ///
    /// # Errors
    /// An initial value cannot be computed, or the initial state violates an invariant.
    pub fn machine(&self) -> Result<Machine, Box<StepFault>> {
        #[cfg_attr(not(feature = "native"), expect(unused_mut, reason = "only closures"))]
        let mut machine = Machine::new(self.program.clone())?;
        #[cfg(feature = "native")]
        machine.set_native_compiler(&asmotion_native::Cranelift);
        Ok(machine)
    }

    /// Adds a term for evaluation by machines that are created afterwards; `name` names its text in diagnostics.
    ///
    /// # Errors
    /// The text is not a term, or it does not fit the specification.
    pub fn add_term(&mut self, name: &str, text: &str) -> Result<hir::AddedTerm, Report> {
        let file = self.sources.add(name, text);
        let term = asmotion_syntax::parse_term(file, text)?;
        let added = self.model.add_term(&term)?;
        self.lower()?;
        Ok(added)
    }

    /// Makes the functions of a standard library without definitions, such as the operators of `CTLLibrary`, visible to terms that are
    /// added, as if the specification imported it. Returns `false` if the specification has others of the same names.
    pub fn offer_library(&mut self, name: &str) -> bool {
        let Some(library) = asmotion_stdlib::library(name) else {
            return false;
        };
        let file = self.sources.add(&format!("<{name}>"), library.text);
        let read = asmotion_syntax::parse_library(file, library.text);
        let parsed = read.unwrap_or_else(|| asmotion_syntax::parse(file, library.text));
        self.model.offer_library(&parsed.file)
    }

    /// Lowers the model again, after additions to it. Coverage counters stay enabled. A machine
    /// continues with the new program by [`Machine::replace_program`].
    ///
    /// # Errors
    /// An addition cannot be lowered; the program is unchanged.
    pub fn lower(&mut self) -> Result<(), Report> {
        if !self.program.counted.is_empty() {
            return self.lower_covered();
        }
        let lowered = ir::lower(&self.model)?;
        (self.program, self.origins) = (Arc::new(lowered.program), lowered.origins);
        Ok(())
    }

    /// Lowers the model again, with coverage counters: see
    /// [`Coverage`](crate::coverage::Coverage).
    ///
    /// # Errors
    /// As [`Specification::lower`].
    pub fn lower_covered(&mut self) -> Result<(), Report> {
        let lowered = ir::lower(&self.model)?;
        (self.program, self.origins) = (Arc::new(lowered.program.covered()), lowered.origins);
        Ok(())
    }

    /// Returns the function with this name and number of parameters that the specification itself
    /// declares.
    pub fn function(&self, name: &str, arity: usize) -> Option<ir::FunctionId> {
        let mut own = self.model.own_functions();
        own.find(|(_, function)| &*function.name == name && function.parameters.len() == arity)
            .map(|(id, _)| ir::FunctionId(id.0))
    }

    /// Returns the rule whose body contains a span.
    pub fn rule_at(&self, place: Span) -> Option<&hir::Rule> {
        self.model.rules.iter().find(|rule| {
            let body = rule.body.as_ref().map(|body| body.root.span);
            body.is_some_and(|body| {
                body.file == place.file && body.start <= place.start && place.end <= body.end
            })
        })
    }

    /// Returns the span of an origin.
    pub fn span(&self, origin: ir::Origin) -> Span {
        self.origins
            .get(origin.0 as usize)
            .copied()
            .unwrap_or_default()
    }

    /// Returns the file name and the line of an origin, as in `navigate.asm:42`.
    pub fn place(&self, origin: ir::Origin) -> String {
        let span = self.span(origin);
        let path = self.sources.path(span.file);
        let name = path.rsplit('/').next().unwrap_or(path);
        let (line, _) = self.sources.position(span.file, span.start);
        format!("{name}:{line}")
    }
}
