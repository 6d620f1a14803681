//! Topics between processes: publish and subscribe, request and reply, behind one trait.
//!
//! [`Bus`] is the trait; [`LocalBus`] is the bus within one process. Every back end passes the same suite,
//! [`contract::violations`]. Within a process, components are connected directly; the bus carries their topics to tools
//! and other processes.

mod bus;
pub mod contract;
mod deadline;
mod envelope;
mod health;
mod local;
mod pattern;
mod publish_options;
mod queue;
mod request;
mod robot_address;
mod sender_id;
mod service_client;
mod standstill;
mod trace_context;
mod transit;

pub use asmotion_connection::Notifier;
pub use bus::{Bus, BusError, Publisher};
pub use deadline::deadline_after;
pub use envelope::{Envelope, Payload};
pub use health::{Health, LinkState};
pub use local::LocalBus;
pub use pattern::Pattern;
pub use publish_options::{Assurance, Outage, PublishOptions, PublisherCounts};
pub use queue::{Overflow, QueuePolicy, Subscription, SubscriptionCounts, SubscriptionSender};
pub use request::{
    AddressQueue, CallFailure, DeliveryReceipt, IncomingCall, PendingCall, Refusal, Request,
    ServedAddress,
};
pub use robot_address::RobotAddress;
pub use sender_id::SenderId;
pub use service_client::ServiceClient;
pub use standstill::Standstills;
pub use trace_context::{InvalidTraceparent, SpanGenerator, TraceContext};
pub use transit::TransitTimes;
