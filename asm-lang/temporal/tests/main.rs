//! Verdicts, counterexamples and witnesses, against definitions that are evaluated directly.

#![allow(
    clippy::expect_used,
    reason = "helpers of tests fail by panicking, too"
)]

mod bits;
mod ctl;
mod graph;
mod ltl;
mod monitor;
mod naive;
mod nusmv;
mod random;
mod vacuity;
mod words;
