//! One step: state and environment in, update set and trace out.
//!
//! A [`Machine`] compiles a program once, to closures, and then steps: the rules are evaluated in the
//! current state, their updates are collected, and if no location is given two values they are
//! applied at once (Börger & Stärk, *Abstract State Machines*, 2003, §2.4). Inputs come from an
//! [`Environment`], choices from a [`Chooser`], time from the caller: a machine has no other door.

pub mod back_end;
mod bounds;
mod choose;
mod code;
mod compile;
mod environment;
mod extent;
mod fault;
mod hearing;
mod initial;
mod invariant;
mod limits;
mod machine;
mod membership;
mod misfit;
mod naming;
mod near;
mod notes;
mod outside;
mod packed;
mod plain;
mod post;
mod record;
mod run;
mod snapshot;
mod state;
mod updates;
mod watch;
mod witness;

pub use back_end::BackEnd;
pub use choose::{Chooser, First};
pub use code::{NativeCompiler, NoNativeCode};
pub use environment::{Environment, NoInputs};
pub use fault::{Fault, FaultKind};
pub use initial::InitialMisfit;
pub use machine::{Machine, Step};
pub use misfit::Misfit;
pub use naming::Naming;
pub use notes::{Passed, Witness};
pub use outside::ForeignProgram;
pub use packed::PackedState;
pub use post::{CallFault, MessageId, Sent, SentKind};
pub use record::{Choice, Input};
pub use snapshot::{ForeignSnapshot, Snapshot};
pub use state::State;
pub use updates::Update;
