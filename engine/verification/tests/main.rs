//! Specifications of composites with their environments.
#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "tests read files"
)]

mod bus;
mod composites;
mod conformance;
mod disorder;
mod mutants;
mod outcomes;
mod queues;
mod scenarios;
mod support;
