//! The built-in component `ros-bridge`: joins topics and operations of a composite with topics, services and actions of ROS,
//! without code.
//!
//! [`RosBridge`] is an ordinary component with a period, a life cycle and losses. It translates messages and passes them on; a
//! [`RosTransport`] takes them to the nodes of ROS.

mod bridge;
mod bus_topic;
mod calls;
mod desk;
mod echo;
mod frames;
mod inbound;
mod mapped;
mod misfits;
mod notices;
mod offers;
mod open_connection;
pub mod operation;
mod operation_type;
mod outbound;
mod ros1;
mod ros1_operations;
mod ros1_parameters;
#[cfg(feature = "ros2")]
mod ros2;
#[cfg(feature = "ros2")]
mod ros2_components;
#[cfg(feature = "ros2")]
mod ros2_endpoint;
#[cfg(feature = "ros2")]
mod ros2_life_cycle;
#[cfg(feature = "ros2")]
mod ros2_managed;
#[cfg(feature = "ros2")]
mod ros2_memory;
#[cfg(feature = "ros2")]
mod ros2_operations;
#[cfg(feature = "ros2")]
mod ros2_parameter;
#[cfg(feature = "ros2")]
mod ros2_relays;
mod shown;
mod traffic;
mod transport;
mod wake;

pub use asmotion_bridge::FieldConverter;
pub use bridge::RosBridge;
pub use bus_topic::bus_topic;
pub use desk::{
    ComponentDesk, ComponentWatch, DeskChange, DeskComponent, DeskOrder, PendingOrder, StateChange,
};
pub use mapped::{MappedFrame, MappedTopic, RosDirection};
pub use operation::{MappedFeedback, MappedOperation, OperationSchemas};
pub use operation_type::{CALL, CANCEL, OperationKind, OperationType};
pub use ros1::{Ros1Settings, Ros1Transport};
#[cfg(feature = "ros2")]
pub use ros2::{Ros2Settings, Ros2Transport};
pub use shown::{ComponentDisplay, ShownComponent};
pub use transport::{
    ConnectionState, MessageReceiver, MessageSender, RosConnection, RosMessage, RosTransport,
};
pub use wake::{CycleWakes, Wake};
