//! Runs without a robot: environments, seeded choice, traces, scenarios.

mod awaited;
mod clock;
mod codes;
mod environment;
mod literal;
mod partner;
mod random;
mod recording;
pub mod scenario;
mod seen;
mod show;
mod simulation;
mod trace;

pub use awaited::{Awaited, Unawaited};
pub use clock::Clock;
pub use codes::CODES;
pub use environment::Script;
pub use random::{Random, Seeded};
pub use recording::{Choices, Inputs, Recorded, Recording, Ticks};
pub use show::{applied, location, sent, updates};
pub use simulation::{Causes, Simulation, Stopped};
pub use trace::Trace;
