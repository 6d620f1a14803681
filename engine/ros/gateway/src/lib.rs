//! The built-in component `ros-bridge`: joins topics of a composite and topics of ROS, without code.
//!
//! [`RosBridge`] is an ordinary component with a period, a life cycle and losses. It translates messages and passes them on; a
//! [`RosTransport`] takes them to the nodes of ROS.

mod bridge;
mod echo;
mod mapped;
mod ros1;
mod transport;

pub use bridge::RosBridge;
pub use mapped::{MappedTopic, RosDirection};
pub use ros1::{Ros1Settings, Ros1Transport};
pub use transport::{MessageReceiver, MessageSender, RosConnection, RosTransport, Wake};
