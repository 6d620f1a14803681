//! The guarantees of Orocos RTT for ports, connections, components and activities, and of JOrocos for outside programs.
//! Tests are named after the rows of the inventory.
#![allow(clippy::print_stdout, reason = "tests")]

mod activity;
mod deadline;
mod hello;
mod life_cycle;
mod listing;
mod operation;
mod outside;
mod policy;
mod port;
mod running;
mod support;
