//! Plans: checked composites flattened for one profile, with nested composites expanded, substitutions applied and
//! defaults filled in. A plan can be started, drawn, described and serialised as a composite.

mod codes;
mod component;
mod component_thread;
mod connection_list;
mod connection_route;
mod expand;
mod flatten;
mod graph;
mod input_queue;
mod joint;
mod numbered_name;
mod opened;
mod part;
mod plan;
mod route;
mod wire_list;

pub use codes::CODES;
pub use component::{Component, Port, Service};
pub use component_thread::{ComponentThread, ThreadReason};
pub use connection_list::ConnectionList;
pub use connection_route::{ConnectionRoute, RouteEnd, RouteTransport};
pub use expand::{beside, expand};
pub use graph::Dependency;
pub use input_queue::InputQueue;
pub use joint::{Connection, Promoted, Topic};
pub use numbered_name::{MANY_NUMBERED, NumberedName};
pub use opened::{Opened, open, summary};
pub use part::Part;
pub use plan::{
    Bridge, Broker, End, Endpoint, Gateway, Implementation, Lifecycle, Pace, Plan, Policy, Process,
    PropertyValues, Record, RecordReaders, Restart, Terminal, Wire,
};
pub use route::robot_address;
pub use wire_list::WireList;
