//! Runs systems of components: in simulated time ([`Simulation`]) or [`Live`].
//!
//! A [`System`] joins components by name; an executor runs it. Both executors drive the same units through the same
//! cycle, and both are a [`Run`]: it lets time pass, injects samples, inspects components, and starts and stops them.
//! Observers receive every [`Event`]. An [`Adapter`], such as the one in `asmotion-network`, connects a system to a
//! bus.

mod adapter;
mod added_ports;
mod build_error;
mod cause;
mod component_body;
mod component_end;
mod component_unit;
mod connections;
mod context;
mod descriptor;
mod effects;
mod event;
mod frozen;
mod growing_table;
mod handle;
mod health;
mod injection;
mod later_cycle;
mod live;
mod log;
mod opened_end;
mod outer_end;
mod peers;
mod run;
mod run_error;
mod service;
mod simulated;
mod stream;
mod system;
mod topic;

pub use adapter::Adapter;
pub use asmotion_port::PushOutcome;
pub use build_error::BuildError;
pub use cause::CycleCause;
pub use component_end::ComponentEnd;
pub use component_unit::{REMOVAL_REPORT, REPLACEMENT_REPORT};
pub use context::LiveContext;
pub use descriptor::CycleTime;
pub use effects::Effects;
pub use event::{Event, InterestedObserver, Observer, ReportInterest};
pub use frozen::{FrozenSystem, SystemFreezeError, SystemThawError};
pub use health::{HealthTopic, publish_without_bus};
pub use injection::{InjectionPort, InjectionPorts, InjectionTarget};
pub use live::Live;
pub use log::Log;
pub use opened_end::OpenedEnd;
pub use outer_end::{OuterEnd, OuterInput, OuterOutput, OuterService};
pub use run::{
    ADDITION_REPORT, Asked, Change, ChangeError, ComponentAddition, PortReader, PortSubscription,
    PortWriter, Replacement, Run, SentCall, WriteError,
};
pub use run_error::RunError;
pub use service::{
    CallKey, ComponentReply, ProviderMessage, RemoteCaller, ReplyTo, RequestQueue, ServiceRequest,
};
pub use simulated::{Pace, Simulation};
pub use stream::{Sink, SinkUpkeep, Source, SourceEvent, WAITING_REPORT};
pub use system::{ComponentId, System};
pub use topic::SystemTopic;
