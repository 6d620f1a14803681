//! `asmotion verify`: proves properties of specifications for all inputs and choices.

mod show;

use crate::exit::Exit;
use crate::files::DiskLoader;
use crate::paths::{FileKind, named_files, other_than_specification};
use crate::terminal::{TerminalOutput, count};
use asmotion_lang::{Machine, NoInputs, Report, Specification, Value};
use asmotion_verify::{
    CheckedProperty, InputValues, Limits, Options, Progress, Verdict, Verification, verify,
};
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Verifies properties of specifications for all inputs and choices.
#[derive(Args)]
pub struct Verify {
    /// Specifications, and folders to verify all their specifications
    #[arg(value_name = "PATH", required = true)]
    paths: Vec<PathBuf>,

    /// Checks only this property: a declared name, or a term (an invariant, or a formula of CTL or LTL)
    #[arg(long, value_name = "NAME|TERM")]
    property: Vec<String>,

    /// Looks for a run to a state in which this term is true
    #[arg(long, value_name = "TERM")]
    possible: Vec<String>,

    /// Considers only states and inputs in which this term is true
    #[arg(long, value_name = "TERM")]
    assume: Vec<String>,

    /// A state in which nothing can change any more is not stuck if this term is true in it
    #[arg(long, value_name = "TERM")]
    end: Option<String>,

    /// Values of an input, instead of all those of its domain, as in `distance=0,9,10`
    #[arg(long, value_name = "FUNCTION=VALUE,…")]
    values: Vec<String>,

    /// Initial state to start from [default: the default one]
    #[arg(long, value_name = "NAME")]
    init: Option<String>,

    /// Explores only states within this number of steps
    #[arg(long, value_name = "STEPS")]
    bound: Option<u32>,

    /// Ends the exploration after this number of states
    #[arg(long, value_name = "N")]
    states: Option<u64>,

    /// Ends the exploration when states and transitions occupy this memory
    #[arg(long, value_name = "MIB", default_value_t = 4096)]
    memory: u64,

    /// Ends the exploration after this time
    #[arg(long, value_name = "SECONDS")]
    time: Option<f64>,

    /// Writes the run that shows the first violation to a file, which `asmotion sim --replay-inputs` repeats
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,

    /// Prints a JSON object for each specification
    #[arg(long)]
    json: bool,
}

/// Time between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(2);

impl Verify {
    pub fn run(self, terminal: &mut TerminalOutput) -> Exit {
        let files = match named_files(&self.paths, &[FileKind::Specification]) {
            Ok(files) => files,
            Err(error) => {
                terminal.error(error);
                return Exit::Usage;
            }
        };
        if let Some(error) = other_than_specification(&files) {
            terminal.error(error);
            return Exit::Usage;
        }
        if self.trace.is_some() && files.len() > 1 {
            terminal.error("`--trace` is for one specification");
            return Exit::Usage;
        }
        let exits = files.iter().map(|file| self.file(&file.text(), terminal));
        exits.fold(Exit::Ok, Exit::max)
    }

    /// Verifies the specification at a path.
    fn file(&self, path: &str, terminal: &mut TerminalOutput) -> Exit {
        let options = asmotion_lang::ReadOptions {
            initial: self.init.clone(),
            ..asmotion_lang::ReadOptions::default()
        };
        let mut specification = match asmotion_lang::open_with(path, &DiskLoader, &options) {
            Ok(specification) => specification,
            Err(failure) => {
                terminal.report(&failure.report, &failure.sources);
                terminal.error(count(&failure.report).unwrap_or_default());
                return Exit::refused(path);
            }
        };
        if specification.model.main.is_none() {
            terminal.status(
                "Skipping",
                format_args!("{path}, a module without a main rule"),
            );
            return Exit::Ok;
        }
        let options = match self.options(&mut specification, terminal) {
            Ok(options) => options,
            Err(exit) => return exit,
        };
        let begun = Instant::now();
        let mut shown = begun;
        let mut proceed = |progress: Progress| {
            let now = Instant::now();
            if now - shown > PROGRESS {
                shown = now;
                terminal.progress(show::progress(&progress, now - begun));
            }
            let limit = self.time;
            limit.is_none_or(|limit| (now - begun).as_secs_f64() < limit)
        };
        match verify(specification, &options, &mut proceed) {
            Ok(verification) => {
                if self.json {
                    terminal.result(show::json(path, &verification, begun.elapsed()));
                } else {
                    show::text(path, &verification, begun.elapsed(), terminal);
                }
                exit(&verification).max(self.write(&verification, terminal))
            }
            Err(refusal) => {
                terminal.report(&refusal.report, &refusal.specification.sources);
                terminal.error(count(&refusal.report).unwrap_or_default());
                Exit::Findings
            }
        }
    }

    fn options(
        &self,
        specification: &mut Specification,
        terminal: &mut TerminalOutput,
    ) -> Result<Options, Exit> {
        let is_declared = |text: &str| {
            let model = &specification.model;
            let mut invariants = model.invariants.iter().map(|it| &*it.name);
            let mut properties = model.properties.iter().filter_map(|it| it.name.as_deref());
            invariants.any(|name| name == text) || properties.any(|name| name == text)
        };
        let terms = self.property.iter().filter(|text| !is_declared(text));
        let mut options = Options {
            limits: Limits {
                states: self.states,
                depth: self.bound,
                memory: Some(self.memory << 20),
            },
            properties: terms.cloned().collect(),
            possible: self.possible.clone(),
            only: self
                .property
                .iter()
                .chain(&self.possible)
                .cloned()
                .collect(),
            assumptions: self.assume.clone(),
            ends: self.end.clone(),
            inputs: Vec::new(),
        };
        for values in &self.values {
            match input_values(specification, values) {
                Ok(values) => options.inputs.push(values),
                Err(ValuesError::Text(text)) => {
                    terminal.error(format_args!("`--values {values}`: {text}"));
                    return Err(Exit::Usage);
                }
                Err(ValuesError::Term(report)) => {
                    terminal.report(&report, &specification.sources);
                    return Err(Exit::Usage);
                }
            }
        }
        Ok(options)
    }

    /// Writes the trace of the first violation, if there is one and it was requested.
    fn write(&self, verification: &Verification, terminal: &mut TerminalOutput) -> Exit {
        let Some(path) = &self.trace else {
            return Exit::Ok;
        };
        let violated = |property: &&CheckedProperty| property.verdict.is_violated();
        let mut properties = verification.properties.iter();
        let shown = properties
            .clone()
            .find(|it| violated(it) && it.verdict.run().is_some());
        let run = shown.or_else(|| properties.find(|it| it.verdict.run().is_some()));
        let Some(run) = run.and_then(|property| property.verdict.run()) else {
            terminal.warn(format_args!(
                "there is no run to write to `{}`",
                path.display()
            ));
            return Exit::Ok;
        };
        match std::fs::write(path, &run.trace) {
            Ok(()) => Exit::Ok,
            Err(error) => {
                let path = path.display();
                terminal.error(format_args!("cannot write the trace `{path}`: {error}"));
                Exit::Usage
            }
        }
    }
}

/// The exit code of a verification: a violation counts more than a property that is not known.
fn exit(verification: &Verification) -> Exit {
    let properties = &verification.properties;
    if properties.iter().any(|it| it.verdict.is_violated()) {
        Exit::Findings
    } else if properties
        .iter()
        .any(|it| matches!(it.verdict, Verdict::Unknown))
    {
        Exit::Undecided
    } else {
        Exit::Ok
    }
}

/// The reason for which the values of an input cannot be used.
enum ValuesError {
    Text(String),
    Term(Report),
}

/// Reads `function=value,…`.
fn input_values(specification: &mut Specification, text: &str) -> Result<InputValues, ValuesError> {
    let refused = |text: &str| ValuesError::Text(text.to_owned());
    let (name, values) = text
        .split_once('=')
        .ok_or_else(|| refused("write FUNCTION=VALUE,VALUE"))?;
    let name = name.trim();
    let mut named = specification
        .model
        .own_functions()
        .filter(|(_, it)| &*it.name == name);
    let (id, function) = named
        .next()
        .ok_or_else(|| refused("the specification declares no such function"))?;
    let (function_id, codomain) = (asmotion_lang::ir::FunctionId(id.0), function.codomain);
    if !matches!(
        function.kind,
        asmotion_lang::FunctionKind::Monitored | asmotion_lang::FunctionKind::Shared
    ) {
        return Err(refused(
            "the function is no input: only monitored and shared functions are",
        ));
    }
    drop(named);
    let mut terms = Vec::new();
    for value in split(values) {
        terms.push(typed(specification, codomain, value.trim()).map_err(ValuesError::Term)?);
    }
    specification.lower().map_err(ValuesError::Term)?;
    let fault = |specification: &Specification, fault: &asmotion_lang::StepFault| {
        let mut report = Report::new();
        report.push(specification.explain(fault));
        ValuesError::Term(report)
    };
    let machine = specification.machine();
    let mut machine: Machine = machine.map_err(|it| fault(specification, &it))?;
    let mut values: Vec<Value> = Vec::new();
    for term in terms {
        let value = machine.evaluate(term, &mut NoInputs, 0);
        values.push(value.map_err(|it| fault(specification, &it))?);
    }
    Ok(InputValues {
        function: function_id,
        values,
    })
}

/// Adds a term for a value of an input.
fn typed(
    specification: &mut Specification,
    codomain: asmotion_lang::hir::TypeId,
    text: &str,
) -> Result<asmotion_lang::hir::AddedTerm, Report> {
    let file = specification.sources.add("--values", text);
    let term = asmotion_lang::syntax::parse_term(file, text)?;
    specification.model.add_typed(&term, codomain, "the value")
}

/// Splits at commas outside of brackets.
fn split(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0u32, 0);
    for (at, character) in text.char_indices() {
        match character {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' | '>' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.extend(text.get(start..at));
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.extend(text.get(start..));
    parts
}
