//! The one cycle: freeze inputs → compute → commit all outputs or none → flush.
//!
//! TCA's `run()`, Orocos' `updateHook()` and a step of an Abstract State Machine have this one shape, and everything
//! that lives in a running system is a [`Component`] with it. A [`System`] joins components; an executor runs it, in
//! simulated time ([`Simulation`]) or [`Live`].

mod activity;
mod background;
mod body;
mod cause;
mod component;
mod cycle;
pub mod declaration;
mod derived;
mod door;
mod event;
mod exchange;
mod face;
mod fault;
mod handle;
mod health;
mod interface;
mod life_cycle;
mod live;
mod log;
mod outside;
mod policy;
mod port;
mod property;
mod reference;
mod run;
mod service;
mod setup;
mod simulated;
mod stream;
mod system;
mod time;
mod unit;

pub use ::asmotion_connection::{Delivery, Kind};
pub use activity::{
    Activity, Deadline, Denied, Drive, OnDeadline, OnException, Overrun, Scheduler,
};
pub use asmotion_datum::Word;
pub use asmotion_derive::{Ports, Properties, Word};
pub use background::BackgroundWork;
pub use component::Component;
pub use cycle::Cycle;
pub use declaration::Declaration;
pub use derived::{Ports, Properties, PropertySet, PropertySource};
pub use event::{Event, Observer};
pub use fault::Fault;
pub use handle::{In, Out, Property, Provided, Required};
pub use health::{BusHealth, HEALTH_TOPIC};
pub use interface::Interface;
pub use life_cycle::{LifeCycleError, State, Transition};
pub use live::Live;
pub use log::Log;
pub use policy::{Lock, OnStale, Policy, Sharing};
pub use port::Flow;
pub use property::{PropertyError, PropertyProblem, PropertyValue, Setting};
pub use run::{
    Asked, Change, ChangeError, CycleTime, Losses, Reader, Run, RunError, Sent, Subscription,
    WriteError, Writer,
};
pub use service::{
    CallError, CallId, Dynamic, Operation, Reply, Request, RequestId, SendStatus, ServiceFault,
    Wire,
};
pub use setup::Setup;
pub use simulated::{Pace, Simulation};
pub use stream::{Sink, Source};
pub use system::{BuildError, ComponentId, System, port_topic};
pub use time::{Span, Time};
