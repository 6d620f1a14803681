//! Both ends: orders to a system in simulated time, and access to a system over a bus.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

mod driver;
mod handle;
mod orders;
mod robot;
mod stand_in;
