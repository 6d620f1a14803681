//! The components of the rover in the simulated world, and what holds for all components.
#![allow(
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "tests"
)]

mod barn;
mod closed_loop;
mod collision_monitor;
mod course;
mod frozen_components;
mod frozen_systems;
mod hostile_inputs;
mod orders;
mod reference;
mod traffic;
