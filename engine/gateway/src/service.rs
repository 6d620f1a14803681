//! What can be called, as plain data.

use std::time::Duration;

use asmotion_datum::Schema;

/// A service that can be called through a gateway.
#[derive(Debug, Clone, PartialEq)]
pub struct GatewayService {
    /// Its name, outside and on the bus: operation `getMap` of `maps` is served at the address `maps.getMap`.
    pub name: String,
    /// Its interface: `nav/MapService`.
    pub interface: String,
    /// How long a call may take whose caller does not say.
    pub timeout: Duration,
    /// Its operations.
    pub operations: Vec<GatewayOperation>,
}

/// An operation of a service.
#[derive(Debug, Clone, PartialEq)]
pub struct GatewayOperation {
    /// Its name.
    pub name: String,
    /// What is asked.
    pub request: Schema,
    /// What is answered.
    pub response: Schema,
    /// Whether nobody is answered.
    pub one_way: bool,
}
