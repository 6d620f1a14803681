//! Tests of the language from text to steps: the behaviour of programs, the diagnostics of their errors, and limits. The programs
//! are in `tests/language` of the repository, where other tests read them too.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::disallowed_methods,
    reason = "a test fails by panicking, reads files and takes its time"
)]

mod back_end;
mod boundaries;
mod builtins;
mod compatible;
mod differences;
mod domains;
mod exits;
mod fixes;
mod initial_state;
mod limits;
mod messages;
mod picks;
mod ranges;
mod records;
mod recovery;
mod replay;
mod reverted_steps;
mod semantics;
mod session;
mod stored_messages;
mod stored_values;
#[path = "../../../tests/language/support.rs"]
mod support;
mod transfer;
mod witnesses;

use std::path::{Path, PathBuf};
use support::{open, opened, programs, said};

/// The folder of the programs.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/language")
}
