//! Simulation: runs without a robot, with scripted, recorded or random inputs, seeded choices,
//! traces and scenarios.

mod awaited_update;
mod clock;
mod codes;
mod constrained_inputs;
mod environment;
mod failed_condition;
mod literal;
mod partner;
mod random;
mod recorded_message;
mod recording;
pub mod scenario;
mod show;
mod simulation;
mod trace;

pub use awaited_update::{AwaitError, AwaitedUpdate};
pub use clock::SimulationClock;
pub use codes::CODES;
pub use constrained_inputs::{ConstrainedInputs, InputValues};
pub use environment::Script;
pub use partner::ScriptedAnswer;
pub use random::{Random, Seeded};
pub use recorded_message::{RecordedMessage, UnfitMessage, agent, fault_name};
pub use recording::{InputTexts, RecordedChoices, RecordedInputs, RecordedStep, Recording, Ticks};
pub use show::{applied, location, sent, state, updates};
pub use simulation::{Causes, Simulation, SimulationError};
pub use trace::Trace;
