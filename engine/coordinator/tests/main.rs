//! Specifications as components.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

mod conversion;
mod events;
mod life;
mod watching;
