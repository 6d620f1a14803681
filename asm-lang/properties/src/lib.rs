//! Properties that hold for every input text. Each function takes bytes and panics if its property
//! is violated; the fuzzers (`fuzz/`) and the tests of this crate call them.

mod back_ends;
#[path = "../../syntax/tests/shared/faithful.rs"]
mod faithful;
mod generated;

pub use back_ends::back_ends;

use asmotion_lang::diagnostics::FileId;
use asmotion_lang::simulate::{Causes, Random, Simulation, SimulationError};
use asmotion_lang::{MemoryFiles, Report, Specification, Style, render_all, syntax};

/// Number of steps executed with a specification that opens.
const STEPS: u64 = 3;

/// Parsing a text yields a tree and a report whose spans lie in the text.
pub fn parse(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    lies_within(&text, &syntax::parse(FileId(0), &text).report);
    lies_within(&text, &syntax::parse_scenario(FileId(0), &text).1);
    let fragments = [
        syntax::parse_term(FileId(0), &text).err(),
        syntax::parse_rule(FileId(0), &text).err(),
    ];
    for report in fragments.iter().flatten() {
        lies_within(&text, report);
    }
}

fn lies_within(text: &str, report: &Report) {
    for finding in &report.diagnostics {
        for label in finding.primary.iter().chain(&finding.secondary) {
            assert!(
                text.get(label.span.range()).is_some(),
                "{finding:?} points outside the text"
            );
        }
    }
}

/// A specification either opens or is rejected with a report that can be rendered. An opened one
/// runs deterministically, possibly ending with a fault that can be rendered.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let mut files = MemoryFiles::new();
    files.add("fuzz.asm", &*text);
    match asmotion_lang::open("fuzz.asm", &files) {
        Ok(specification) => {
            render_all(&specification.report, &specification.sources, Style::Plain);
            assert_eq!(run(&specification), run(&specification), "two runs differ");
        }
        Err(failure) => {
            assert!(failure.report.has_errors());
            render_all(&failure.report, &failure.sources, Style::Plain);
        }
    }
}

/// Returns the trace of a few steps.
fn run(specification: &Specification) -> String {
    let machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => return specification.explain(&fault).message,
    };
    let inputs = Random::new(specification.program.clone(), &machine, 0);
    let mut run = Simulation::new(machine, Causes::Random(Box::new(inputs)), 0).traced("");
    for _ in 0..STEPS {
        if let Err(SimulationError::Fault(fault)) = run.step() {
            let message = specification.explain_in(&fault, run.machine()).message;
            return message + &run.into_trace(Some(&fault)).unwrap_or_default();
        }
    }
    run.into_trace(None).unwrap_or_default()
}

/// Formatting preserves the meaning of a text, and formatting the result changes nothing.
pub fn fmt(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let formatted = faithful::formatted(&text);
    assert!(formatted.is_ok(), "{formatted:?}");
}
