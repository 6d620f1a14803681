//! Systems started from composites.
#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod abroad;
mod additions;
mod calls;
mod deployment;
mod reconfigure;
#[path = "../../plan/tests/support/render.rs"]
mod render;
mod replacement;
mod replies;
mod start;
mod tca;
mod topics;
#[path = "../../plan/tests/support/variables.rs"]
mod variables;
mod waiting;
mod watching;
