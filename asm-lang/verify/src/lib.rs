//! Verification: explores all states that a specification can reach, for all inputs and choices, and checks its properties in
//! them.
//!
//! A state contains the locations that rules update. Inputs (monitored functions) and choices are not part of it: a step is
//! executed once for each combination of values that it reads and candidates that it chooses. If properties mention inputs,
//! each state is considered with each combination of those inputs; the next step then reads the same values.
//!
//! ```
//! let mut files = asmotion_lang::MemoryFiles::new();
//! files.add("lamp.asm", "asm lamp
//! import StandardLibrary
//! import CTLLibrary
//! signature:
//!   monitored button: Boolean
//!   controlled isOn: Boolean
//! definitions:
//!   CTLSPEC ag(ef(isOn))
//!   main rule r_Main = if button then isOn := not isOn endif
//! default init s0:
//!   function isOn = false
//! ");
//! let lamp = asmotion_lang::open("lamp.asm", &files).map_err(|failure| failure.to_string())?;
//! let verified = asmotion_verify::verify(lamp, &Default::default(), &mut |_| true).map_err(|_| "refused")?;
//! assert_eq!(verified.states, 2);
//! assert!(verified.properties.iter().all(|property| property.verdict.holds()));
//! # Ok::<(), String>(())
//! ```

mod advice;
mod codes;
mod concrete;
mod counterexample;
mod deciding;
mod decisions;
mod delivery;
mod due_fairness;
mod environment;
mod expansion;
mod explore;
mod explorer;
mod exported_value;
mod fair_moves;
mod final_states;
mod formula;
mod grounded;
mod growth;
mod hints;
mod input_flow;
mod inputs;
mod layers;
mod logic;
mod machines;
mod mail;
mod monitor;
mod mutation;
mod observer;
mod operator;
mod options;
mod own_inputs;
mod parents;
mod post;
mod preparation;
mod property;
mod qualifier;
mod reads;
mod regions;
mod reuse;
mod round_limits;
mod simplest;
mod spill;
mod steady_growth;
mod store;
#[cfg(feature = "symbolic")]
mod symbolic;
mod system;
mod system_inputs;
mod system_plan;
mod transition;
mod translation;
mod verdicts;
mod verify;
mod without_inputs;

pub use advice::{AdviceKind, SpecificationAdvice};
pub use codes::CODES;
pub use counterexample::{LocationValue, Run, RunChoice, RunStep, RunUpdate};
pub use environment::EnvironmentModel;
pub use explore::{Incomplete, Limits, Progress};
pub use exported_value::ExportedValue;
pub use growth::GrowingLocation;
pub use mail::{ContentValues, MessageModel};
pub use monitor::{
    ConditionValue, GivenProperty, Monitors, MonitorsState, PropertyViolation, UnwatchedProperty,
    WatchedProperty,
};
pub use mutation::{Mutant, mutants};
pub use options::{Engine, FairName, InputValues, Options, Storage};
pub use preparation::state_constraints;
pub use property::{CheckedProperty, Note, PropertyKind, Verdict};
pub use regions::{Representative, RepresentedInput};
pub use reuse::KeptExploration;
pub use spill::{SpillFile, SpillSpace};
pub use system::{
    ConnectedLocation, InputConnection, MachineSchedule, MessageLink, SystemSpecification,
    VerifiedMachine,
};
pub use verify::{Refusal, Verification, verify, verify_again, verify_system};
