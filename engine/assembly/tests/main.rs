//! Systems started from composites.
#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod deployment;
mod reconfigure;
#[path = "../../plan/tests/support/render.rs"]
mod render;
mod replacement;
mod start;
mod tca;
#[path = "../../plan/tests/support/variables.rs"]
mod variables;
mod waiting;
mod watching;
