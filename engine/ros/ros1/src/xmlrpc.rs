//! XML-RPC, in which master and nodes of ROS 1 call each other. Source: the specification at xmlrpc.com, and the ROS wiki,
//! "ROS/Master_Slave_APIs".

mod datum;
mod read;
mod value;
mod write;

pub use datum::UnsupportedParameter;
pub use read::{XmlRpcCall, XmlRpcError, XmlRpcFault, read_call, read_response};
pub use value::XmlRpcValue;
pub use write::{write_call, write_response};
