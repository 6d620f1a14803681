//! Grounding: a program over finite ranges as plain data without calls, variables and domains.
//!
//! [`ground`] expands the main rule of a program in its initial state: calls, derived functions and macros are inlined, `choose`,
//! `forall`, quantifiers and agents over finite ranges become lists, locations become variables with a range of numbers, and
//! conditions that follow from the initial state are decided. What cannot be expanded remains as [`GroundRule::Machine`] or as a
//! term with the value [`FAULT`]: where an evaluation meets it, a machine has to execute the step.
//!
//! A grounded rule makes the same choices, reads the same inputs and yields the same updates as the machine's step, or ends with
//! [`FAULT`]. [`GroundProgram::alternatives`] lists the choices of a step, and [`Shapes`] compares rules up to the names of variables.

mod alternatives;
mod binder;
mod cone;
mod evaluate;
mod fold;
mod grounding;
mod known;
mod library;
mod program;
mod ranges;
mod rule;
mod shape;
mod substitute;
mod term;
mod visit;

pub use alternatives::{GroundAlternative, GroundChoice};
pub use cone::cone;
pub use evaluate::{GroundUpdates, Valuation, evaluate, execute};
pub use grounding::{GroundingContext, TooLarge, ground};
pub use program::*;
pub use shape::{Renaming, Shape, Shapes};
pub use visit::{Accesses, accesses_of_rule, accesses_of_term};
