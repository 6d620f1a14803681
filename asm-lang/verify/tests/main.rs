//! Verification of specifications.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "tests read files"
)]

mod advice;
mod bad_input;
mod bad_systems;
mod compared_inputs;
mod cone;
mod corpus;
mod counts;
mod crossings;
mod environments;
mod extended;
mod fairness;
mod grounded;
mod guard_rails;
mod independent;
mod models;
mod monitors;
mod naive;
mod naive_fairness;
mod naive_inputs;
mod naive_linear;
mod naive_logic;
mod naive_systems;
mod nusmv;
mod observer;
mod own_inputs;
mod random_inputs;
mod reuse;
mod runs;
mod scripted_partners;
mod simplest;
mod specs;
mod storage;
mod symbolic;
mod symbolic_limits;
mod symmetry;
mod systems;
mod threads;
mod truncated;
mod unbounded;

use asmotion_lang::{MemoryFiles, Specification};
use asmotion_verify::{Options, SystemSpecification, Verification, verify, verify_system};

/// Opens a specification from its text.
fn open(text: &str) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("model.asm", text);
    asmotion_lang::open("model.asm", &files).unwrap_or_else(|failure| panic!("{failure}"))
}

fn verified(text: &str, options: &Options) -> Verification {
    match verify(open(text), options, &mut |_| true) {
        Ok(verification) => verification,
        Err(refusal) => panic!("{}", refused(&refusal)),
    }
}

/// Kind or name, and verdict, of each property.
fn verdicts(verification: &Verification) -> Vec<(String, &'static str)> {
    let properties = verification.properties.iter();
    let verdict = |property: &asmotion_verify::CheckedProperty| match property.verdict {
        asmotion_verify::Verdict::Holds(_) => "holds",
        asmotion_verify::Verdict::Violated(_) => "violated",
        asmotion_verify::Verdict::Unknown => "unknown",
    };
    let named = properties.map(|it| {
        (
            it.name.clone().unwrap_or_else(|| it.text.clone()),
            verdict(it),
        )
    });
    named.collect()
}

/// Opens a specification with a name.
fn machine(name: &str, text: &str) -> asmotion_verify::VerifiedMachine {
    asmotion_verify::VerifiedMachine {
        name: name.to_owned(),
        specification: open(text),
    }
}

fn verified_system(system: SystemSpecification, options: &Options) -> Verification {
    match verify_system(system, options, &mut |_| true) {
        Ok(verification) => verification,
        Err(refusal) => panic!("{}", refused(&refusal)),
    }
}

/// The diagnostics of a refusal, rendered.
fn refused(refusal: &asmotion_verify::Refusal) -> String {
    let (report, sources) = (&refusal.report, &refusal.specification.sources);
    asmotion_lang::render_all(report, sources, asmotion_lang::Style::Plain)
}

/// The verdict on a property, given by its name or text.
fn verdict_of(verification: &Verification, property: &str) -> &'static str {
    let verdicts = verdicts(verification);
    let found = verdicts.iter().find(|(name, _)| name == property);
    found
        .unwrap_or_else(|| panic!("{property}: {verdicts:?}"))
        .1
}
