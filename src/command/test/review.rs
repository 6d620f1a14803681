//! Accepts differences of snapshots, all at once or one by one.

use super::result::{TestEnd, TestResult};
use crate::exit::Exit;
use crate::terminal::TerminalOutput;
use asmotion_lang::Report;
use asmotion_lang::simulate::scenario::Verdict;
use std::io::BufRead;

/// Returns `true` on a build server, where no snapshot is accepted.
pub fn is_automatic() -> bool {
    std::env::var_os("CI").is_some_and(|value| !value.is_empty())
}

/// Accepts every difference.
pub fn accept(results: &mut [TestResult], terminal: &mut TerminalOutput) -> Exit {
    let mut exit = Exit::Ok;
    for result in results {
        exit = exit.max(accept_difference(result, terminal));
    }
    exit
}

/// Shows every difference and asks whether to accept it.
pub fn review(results: &mut [TestResult], terminal: &mut TerminalOutput) -> Exit {
    let mut exit = Exit::Ok;
    let mut answers = std::io::stdin().lock().lines();
    for result in results {
        let Some(difference) = &result.difference else {
            continue;
        };
        terminal.progress(difference.diff());
        terminal.progress(format_args!(
            "accept `{}`? [y]es, [n]o, [s]kip the rest",
            difference.path.display()
        ));
        // the end of input rejects the rest
        let answer = answers.next().and_then(Result::ok).unwrap_or_default();
        match answer.trim() {
            "y" | "yes" => exit = exit.max(accept_difference(result, terminal)),
            "s" | "skip" => break,
            _ => {}
        }
    }
    exit
}

fn accept_difference(result: &mut TestResult, terminal: &mut TerminalOutput) -> Exit {
    let Some(difference) = result.difference.take() else {
        return Exit::Ok;
    };
    match difference.accept() {
        Ok(()) => {
            terminal.status("Accepted", difference.path.display());
            result.end = TestEnd::Ran(Verdict::Pass);
            result.report = Report::new();
            Exit::Ok
        }
        Err(error) => {
            terminal.error(format_args!(
                "cannot write `{}`: {error}",
                difference.path.display()
            ));
            Exit::Usage
        }
    }
}
