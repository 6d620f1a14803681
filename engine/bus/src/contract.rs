//! The contract of a bus, as a test suite that every back end passes.
//!
//! A case is a function that takes a bus and returns a description of the failure, if any. Cases wait for messages,
//! because a back end may need a network, and use their own topics, because it may be shared.

mod cases;

use crate::bus::Bus;

/// A case that a bus did not pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The case: the behaviour required.
    pub case: &'static str,
    /// Behaviour observed instead.
    pub observed: String,
}

/// Runs the suite; a bus keeps the contract if this is empty. `prefix` keeps runs on a shared broker apart.
pub fn violations(bus: &dyn Bus, prefix: &str) -> Vec<Violation> {
    let run = |(case, check): &(&'static str, cases::ContractCase)| {
        let observed = check(bus, &format!("{prefix}.{}", case.replace(' ', "-"))).err()?;
        Some(Violation { case, observed })
    };
    cases::CASES.iter().filter_map(run).collect()
}
