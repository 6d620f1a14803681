//! The machine: executes the steps of a program.
//!
//! A [`Machine`] compiles a program once, to closures, and then steps: the rules are evaluated in
//! the current state, their updates are collected, and if the update set is consistent, it is
//! applied at once (Börger & Stärk, *Abstract State Machines*, 2003, §2.4). Inputs come from an
//! [`Environment`], choices from a [`Chooser`], and the time from the caller; nothing else
//! influences a step.

mod agent_messages;
pub mod back_end;
mod background;
mod bounds;
mod choose;
mod compile;
mod direct;
mod direct_evaluation;
mod environment;
mod extent;
mod fault;
mod initial;
mod inspection;
mod invariant;
mod limits;
mod machine;
mod membership;
mod messages;
mod misfit;
mod naming;
mod out_of_domain;
mod packed;
mod record;
mod run;
mod scalar_updates;
mod scratch;
mod snapshot;
mod state;
mod tiering;
mod transfer;
mod updates;
mod watch;
mod windows;
mod witness;
mod witness_notes;

pub use back_end::BackEnd;
pub use choose::{Chooser, FirstChoice};
pub use environment::{Environment, NoInputs};
pub use fault::{FaultKind, StepFault};
pub use initial::InitialMisfit;
pub use machine::{Machine, Step};
pub use messages::{CallFault, MessageId, PendingCall, SentKind, SentMessage};
pub use misfit::DomainMisfit;
pub use naming::Naming;
pub use out_of_domain::ForeignProgram;
pub use packed::PackedState;
pub use record::{StepChoice, StepInput, TakenCandidate};
pub use run::code::{NativeCompiler, NoNativeCode};
pub use snapshot::{ForeignSnapshot, Snapshot, pack_value};
pub use state::MachineState;
pub use transfer::{Correspondence, TransferError};
pub use updates::Update;
pub use witness_notes::{PathEntry, StepAccount, Witness};
