//! What holds for every text, whatever is in it. Each function takes bytes and panics where something
//! does not hold; the fuzzers (`fuzz/`) and the tests of this crate feed them.

#[path = "../../syntax/tests/shared/faithful.rs"]
mod faithful;

use asmotion_lang::diagnostics::FileId;
use asmotion_lang::simulate::{Causes, Random, Simulation, SimulationError};
use asmotion_lang::{MemoryFiles, Report, Specification, Style, render_all, syntax};

/// So many steps are done with what opens.
const STEPS: u64 = 3;

/// Reading a text ends with a tree and a report whose places lie in the text.
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

/// A specification opens or is refused with a report that can be shown; what opens runs or stops with
/// a fault that can be shown, the same way every time.
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

/// The trace of a few steps.
fn run(specification: &Specification) -> String {
    let machine = match specification.machine() {
        Ok(machine) => machine,
        Err(fault) => return specification.explain(&fault).message,
    };
    let inputs = Random::new(specification.program.clone(), &machine, 0);
    let mut run = Simulation::new(machine, Causes::Random(Box::new(inputs)), 0).traced("");
    for _ in 0..STEPS {
        if let Err(SimulationError::Fault(fault)) = run.step() {
            let told = specification.explain_in(&fault, run.machine()).message;
            return told + &run.into_trace(Some(&fault)).unwrap_or_default();
        }
    }
    run.into_trace(None).unwrap_or_default()
}

/// A formatted text says what the text says, and is formatted.
pub fn fmt(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let formatted = faithful::formatted(&text);
    assert!(formatted.is_ok(), "{formatted:?}");
}
