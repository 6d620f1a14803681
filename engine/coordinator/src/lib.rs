//! An ASM machine as a component: bindings, event frames, faults.
//!
//! One cycle of the [`Coordinator`] is one step of the machine. The frozen inputs of the cycle become
//! the monitored functions, as the [`Binding`] says; the updates of out functions become messages and
//! service calls. The specification itself knows of none of this: the same file is simulated, tested
//! and verified.

mod binding;
mod convert;
mod coordinator;
mod effects;
mod frame;
mod freeze;
mod inputs;
mod partners;
mod requests;
mod step;

pub use binding::{
    Action, Argument, Binding, Call, Case, Constant, Effect, Interfaces, Monitored, Out,
    PublishWhen, Receive, Source,
};
pub use coordinator::{BindError, Coordinator, LOSSES_REPORT};
pub use effects::UNSENT_REPORT;
pub use step::{STEP_REPORT, StepRecord, UpdateRecord};
