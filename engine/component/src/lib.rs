//! The interface between components and their runtime. A cycle is: freeze inputs → compute → commit all outputs or none
//! → flush.
//!
//! TCA's `run()`, Orocos' `updateHook()` and a step of an Abstract State Machine all have this shape, and everything in
//! a running system is a [`Component`] with such a cycle. A constructor declares ports, services, references and
//! properties on an [`Interface`], and keeps typed handles; a [`Cycle`] gives access through them. A separate crate,
//! `asmotion-runtime`, connects and drives components; it implements [`CycleHost`].

mod action;
mod activity;
mod background;
mod bus_health;
mod component;
mod conversion;
mod cycle;
pub mod declaration;
mod derived;
mod fault;
pub mod frozen;
mod guard;
mod handle;
mod host;
mod interface;
mod life_cycle;
mod losses;
mod operation;
mod peer;
mod property;
mod reference;
mod setting;
mod setup;
mod suggestion;
mod wire;

pub use action::CycleAction;
pub use activity::{
    Activity, Deadline, Denied, Drive, OnDeadline, OnException, Overrun, Scheduler, ThreadUse,
};
pub use asmotion_datum::Word;
pub use asmotion_derive::{Freeze, Ports, Properties, Word};
pub use asmotion_port::{BufferKind, Flow, Lock, OnStale, Policy, Sharing, Span, Time, prefetch};
pub use background::{BackgroundWork, CycleRequests, WorkPlace};
pub use bus_health::{BusHealth, HEALTH_TOPIC};
pub use component::{AwaitedWriters, Component};
pub use conversion::PropertyConversion;
pub use cycle::{Cycle, LOG_REPORT, NOTICE_REPORT};
pub use declaration::Declaration;
pub use derived::{Ports, Properties, PropertySet, PropertySource};
pub use fault::Fault;
pub use frozen::{
    CannotFreeze, Freeze, FreezeProblem, FrozenState, ThawError, ThawProblem, freeze_fields,
    thaw_fields,
};
pub use guard::guarded;
pub use handle::{In, Out, Property, Provided, Required};
pub use host::{CycleHost, PropertyHost, WaitingRequest};
pub use interface::{Interface, InterfaceParts};
pub use life_cycle::{LifeCycleError, State, Transition};
pub use losses::Losses;
pub use operation::{
    CallError, CallId, Dynamic, Handler, NO_SERVER, Operation, OperationSlot, Reply, Request,
    RequestId, SendStatus, ServiceFault, unreadable,
};
pub use peer::PeerStatus;
pub use property::{AnyProperty, PropertyError, PropertyProblem, PropertyValue};
pub use setting::Setting;
pub use setup::Setup;
pub use suggestion::{suggestion, suggestion_among};
pub use wire::Wire;
