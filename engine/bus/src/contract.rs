//! The contract of a bus, as a test suite that every back end passes.
//!
//! A case is a function that takes a bus and returns a description of the failure, if any. Cases wait for messages,
//! because a back end may need a network, and use their own topics, because it may be shared.

mod cases;

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::bus::Bus;

use cases::CASES;

/// Number of cases that run at once.
const THREADS: usize = 4;

/// A case that a bus did not pass.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The case: the behaviour required.
    pub case: &'static str,
    /// Behaviour observed instead.
    pub observed: String,
}

/// Runs the suite; a bus keeps the contract if this is empty. `prefix` keeps runs on a shared broker apart. Several cases run
/// at once, because most of their time is waiting.
pub fn violations(bus: &dyn Bus, prefix: &str) -> Vec<Violation> {
    let next = AtomicUsize::new(0);
    let run_cases = || {
        let mut violations = Vec::new();
        while let Some((case, check)) = CASES.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = format!("{prefix}.{}", case.replace(' ', "-"));
            if let Err(observed) = check(bus, &name) {
                violations.push(Violation { case, observed });
            }
        }
        violations
    };
    let mut all: Vec<Violation> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS).map(|_| scope.spawn(run_cases)).collect();
        let joined = threads.into_iter().map(|thread| thread.join());
        // a case that panicked fails the caller's test
        let joined = joined.map(|it| it.unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        joined.flatten().collect()
    });
    let position =
        |violation: &Violation| CASES.iter().position(|(case, _)| *case == violation.case);
    all.sort_by_key(position);
    all
}
