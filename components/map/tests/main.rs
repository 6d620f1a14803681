//! Map formats and the map server.
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "tests"
)]

mod contract;
mod extracts;
mod fixture;
mod office;
mod server;
