//! What Orocos RTT promises of ports, connections, components and activities, and JOrocos of those outside: each row of
//! the inventory by its id.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

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
