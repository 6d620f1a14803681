//! Systems on a bus.
#![allow(clippy::panic, clippy::unwrap_used, reason = "tests")]

mod abroad;
mod bus;
#[path = "../../runtime/tests/common/mod.rs"]
mod common;
mod health;
