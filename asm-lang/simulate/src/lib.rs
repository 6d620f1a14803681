//! Runs without a robot: environments, seeded choice, traces.

mod environment;
mod random;
mod show;

pub use environment::Script;
pub use random::{Random, Seeded};
pub use show::{applied, location, updates};
