//! Scenarios (Avalla) carried out on a machine, without a detour over another specification.
//!
//! ```text
//! tree ─Plan→ actions, their terms added to the model ─asmotion_ir::lower→ program ─run→ Outcome
//! ```
//!
//! What the commands mean:
//!
//! * `set` gives an input its value: it keeps it until it is set again, and is undef before. A
//!   location that rules write is written at once.
//! * `check` is evaluated where it stands, on the state and the inputs of that moment. Checks that
//!   fail do not stop the checks behind them, but no further step is done.
//! * `step` is a step of the main rule; `step until` repeats it while its condition does not hold.
//! * `exec` fires a rule between two steps; no invariant is checked then.
//! * `pick` says which value a `choose` takes in the next step. It must be a candidate. Whatever is
//!   not picked is chosen by the seed.
//! * `invariant`s are checked in the first state and after every step, as those of the specification.

mod choices;
mod inputs;
mod plan;
mod run;
mod verdict;

pub use inputs::HeldInputs;
pub use plan::ScenarioPlan;
pub use run::{ScenarioOptions, run};
pub use verdict::{ScenarioFailure, ScenarioFailureKind, ScenarioOutcome, Verdict};
