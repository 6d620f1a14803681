//! The guarantees of Orocos RTT for ports, connections, components and activities, and of JOrocos for outside programs.
//! Tests are named after the rows of the inventory.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests"
)]

#[path = "../common/mod.rs"]
mod common;

mod activity;
mod deadline;
mod hello;
mod life_cycle;
mod operation;
mod outside;
mod policy;
mod port;
mod running;
mod support;
