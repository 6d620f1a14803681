//! Services: clients and servers, for both mappings.

mod client;
mod server;

pub use client::{Call, Client, ClientCounts};
pub use server::{ReplyTo, Request, Server, ServerCounts};

use asmotion_datum::Schema;
use asmotion_ros_interface::{InterfaceKind, InterfaceName};

use crate::error::EndpointError;
use crate::names;
use crate::participant::Inner;
use crate::qos::Qos;

/// A service as DDS sees it.
pub(crate) struct ServiceType {
    pub request: Part,
    pub response: Part,
    pub hash: Option<String>,
}

/// A request or response.
pub(crate) struct Part {
    pub schema: Schema,
    /// The name of the type in DDS.
    pub type_name: String,
}

impl ServiceType {
    /// A service that is defined.
    pub(crate) fn of(inner: &Inner, of: &InterfaceName) -> Result<Self, EndpointError> {
        inner.check_kind(of, InterfaceKind::Service, "service")?;
        let schemas = inner.catalogue().schemas(of)?;
        for schema in &schemas {
            inner.carried(of, schema)?;
        }
        let Ok([request, response]) = <[Schema; 2]>::try_from(schemas) else {
            let (of, needed) = (of.clone(), "service");
            return Err(EndpointError::Kind { of, needed });
        };
        Ok(Self {
            request: Part {
                schema: request,
                type_name: names::part_type(of, "Request"),
            },
            response: Part {
                schema: response,
                type_name: names::part_type(of, "Response"),
            },
            hash: inner.hash(of),
        })
    }
}

/// The quality of service of requests and replies, as rmw has it; the depth bounds what waits.
fn qos() -> Qos {
    Qos::default().depth(64)
}
