//! Everything that is tested through the front door: programs of the language, missions of the
//! robot, the command line, and the plan of the house itself. One module a subject.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "a test fails by panicking, and says why it is skipped"
)]

mod access;
mod assembly;
mod ball_tracker;
mod cli;
mod composites;
mod describe;
mod faults;
mod gateway;
mod health;
mod house;
mod inspection;
mod language;
mod missions;
mod person;
mod pictures;
mod processes;
mod reconfigure;
mod repl;
mod routes;
mod scenario;
mod shell;
mod stranger;
mod supply;
mod up;
mod ways;
mod youbot;
