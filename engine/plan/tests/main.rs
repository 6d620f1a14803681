//! Composites: findings, plans and what `expand` writes.
#![allow(clippy::expect_used, clippy::panic, reason = "tests")]

mod expand;
mod hostile;
mod mistakes;
mod shared;
mod support;
