//! Verification of specifications.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "tests read files"
)]

mod bad_input;
mod counts;
mod models;
mod naive;
mod runs;

use asmotion_lang::{MemoryFiles, Specification};
use asmotion_verify::{Options, Verification, verify};

/// Opens a specification from its text.
fn open(text: &str) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("model.asm", text);
    asmotion_lang::open("model.asm", &files).unwrap_or_else(|failure| panic!("{failure}"))
}

fn verified(text: &str, options: &Options) -> Verification {
    match verify(open(text), options, &mut |_| true) {
        Ok(verification) => verification,
        Err(refusal) => {
            let messages = refusal
                .report
                .diagnostics
                .iter()
                .map(|it| it.message.clone());
            panic!("{:?}", messages.collect::<Vec<String>>())
        }
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
