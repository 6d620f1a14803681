//! The bus over a real RabbitMQ.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "tests"
)]

mod common;
mod contract;
mod deleted_exchange;
mod faults;
mod life;
mod line;
mod many;
mod raw;
mod returning;
mod services;
mod soak;
mod stranger;
mod systems;
