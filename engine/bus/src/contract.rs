//! The contract of a bus, as a suite: every back end passes it.
//!
//! A case is a function from a bus to a word on what went wrong. Cases wait, since a back end may be a broker away,
//! and use topics of their own, since it may be shared.

mod cases;

use crate::bus::Bus;

/// A case that a bus did not pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The case: what a bus does.
    pub case: &'static str,
    /// Behaviour observed instead.
    pub found: String,
}

/// Runs the suite; a bus keeps the contract if this is empty. `prefix` keeps runs on a shared broker apart.
pub fn violations(bus: &dyn Bus, prefix: &str) -> Vec<Violation> {
    let run = |(case, check): &(&'static str, cases::ContractCase)| {
        let found = check(bus, &format!("{prefix}.{}", case.replace(' ', "-"))).err()?;
        Some(Violation { case, found })
    };
    cases::CASES.iter().filter_map(run).collect()
}
