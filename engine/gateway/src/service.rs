//! Descriptions of services, as plain data.

use std::time::Duration;

use asmotion_datum::Schema;

/// A service that can be called through a gateway.
#[derive(Debug, Clone, PartialEq)]
pub struct GatewayService {
    /// Name in URIs and on the bus: operation `getMap` of service `maps` has the address `maps.getMap`.
    pub name: String,
    /// Name of the interface, for example `nav/MapService`.
    pub interface: String,
    /// Timeout of calls without the parameter `timeout_ms`.
    pub timeout: Duration,
    /// The operations that can be called.
    pub operations: Vec<GatewayOperation>,
}

/// An operation of a service.
#[derive(Debug, Clone, PartialEq)]
pub struct GatewayOperation {
    /// Name within the interface.
    pub name: String,
    /// Type of the request.
    pub request: Schema,
    /// Type of the response.
    pub response: Schema,
    /// `true` if calls have no response.
    pub one_way: bool,
}
