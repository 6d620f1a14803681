//! Both ends of the contact: orders to a system by hand, and a system seen from outside over a bus.
#![allow(missing_docs, clippy::expect_used, clippy::panic, reason = "tests")]

mod driver;
mod handle;
mod orders;
mod robot;
