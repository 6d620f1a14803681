//! Scenarios in Avalla, executed directly on a machine.
//!
//! ```text
//! tree ─Plan→ actions, their terms added to the model ─asmotion_ir::lower→ program ─run→ Outcome
//! ```
//!
//! Meaning of the commands:
//!
//! * `set` gives an input a value, which it keeps until it is set again; before the first `set` it
//!   is undef. A location of a controlled function is updated immediately.
//! * `check` is evaluated in the current state, with the current inputs. After a failed check, the
//!   following checks are still evaluated, but no further step is executed.
//! * `step` executes the main rule; `step until` repeats it until its condition holds.
//! * `exec` fires a rule between two steps, without checking invariants.
//! * `pick` determines the value that a `choose` takes in the next step; the value must be a
//!   candidate. All other choices depend on the seed.
//! * `invariant`s are checked in the initial state and after every step, like those of the
//!   specification.

mod choices;
mod inputs;
mod plan;
mod run;
mod verdict;

pub use inputs::HeldInputs;
pub use plan::ScenarioPlan;
pub use run::{ScenarioOptions, run};
pub use verdict::{ScenarioFailure, ScenarioFailureKind, ScenarioOutcome, Verdict};
