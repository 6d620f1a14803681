//! Specifications as components.
#![allow(clippy::unwrap_used, reason = "tests")]

mod conversion;
mod events;
mod life;
mod watching;
