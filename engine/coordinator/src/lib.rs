//! An ASM machine as a component: bindings, event frames, faults.
//!
//! One cycle of the [`Coordinator`] is one step of the machine. The [`Binding`] maps the frozen inputs of the cycle to
//! monitored functions, and updates of out functions to messages and service calls. The specification does not depend
//! on it: the same file is simulated, tested and verified.

mod bind_error;
mod binding;
mod bound_location;
mod content;
mod control_locations;
mod convert;
mod coordinator;
mod cycle_recorder;
mod effects;
mod event_queue;
mod fingerprint;
mod frame;
mod freeze;
mod inputs;
mod last_write;
mod location;
mod misfit;
mod partners;
mod prepared;
mod published_value;
mod recorded;
mod requests;
mod status;
mod step;
mod takeover;
mod terms;
mod typed_input;
mod violation;
mod watch;
mod watched_step;
mod watcher;

pub use bind_error::BindError;
pub use binding::{
    Action, Argument, Binding, BoundOperation, Call, Case, Constant, Effect, Interfaces, Monitored,
    Out, PublishWhen, Published, Receive, Source,
};
pub use control_locations::CONTROL_STATES;
pub use coordinator::{Coordinator, LOSSES_REPORT};
pub use effects::{UNFIT_REPORT, UNSENT_REPORT};
pub use last_write::LastUpdate;
pub use location::{LocationArgument, LocationName};
pub use partners::{BAD_REPLY_REPORT, BadReply};
pub use prepared::PreparedSpecification;
pub use recorded::{
    ChoiceRecord, CycleCauses, MachineBegin, MachineOrigin, RECORDED_CYCLE_REPORT, ReadLocation,
    RecordedCycle, ReplacedStep, SourceRecord,
};
pub use status::{CoordinatorStatus, function_of};
pub use step::{BRIEF_STEP_REPORT, FAILED_STEP_REPORT, STEP_REPORT, StepRecord, UpdateRecord};
pub use violation::{ConditionRecord, VIOLATION_REPORT, ViolationReaction, ViolationRecord};
pub use watch::{GivenProperty, Watch};
pub use watched_step::StepSubject;
pub use watcher::{StepFailure, WatchedStep, Watcher};
