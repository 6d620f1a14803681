//! The remote ends of a system, as they are collected before it is attached to its buses.

use std::collections::BTreeMap;

use asmotion_bus::PublishOptions;
use asmotion_runtime::ComponentEnd;

use crate::remote::RemoteRoute;

/// What of a system is joined over buses, besides its topics.
#[derive(Default)]
pub(crate) struct RemoteEnds {
    /// The buses of the components, where there are several: by position in the system.
    pub homes: BTreeMap<usize, String>,
    /// How topics are sent; the default for those not named.
    pub sending: BTreeMap<String, PublishOptions>,
    /// Outputs that inputs of other processes are connected to.
    pub exposed: Vec<(ComponentEnd, PublishOptions)>,
    /// Services that other processes may call.
    pub offered: Vec<OfferedService>,
    /// Services of other processes.
    pub reached: Vec<RemoteReference>,
}

/// A service that other processes may call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OfferedService {
    pub service: ComponentEnd,
    /// What its addresses begin with.
    pub name: String,
    /// Over which of several buses.
    pub bus: Option<String>,
}

/// A reference to a service of another process.
pub(crate) struct RemoteReference {
    pub route: RemoteRoute,
    /// Over which of several buses.
    pub bus: Option<String>,
}

/// Whether something on one bus is on this one; a system with a single bus has no names for it.
pub(crate) fn is_on(bus: Option<&str>, this: Option<&str>) -> bool {
    this.is_none() || bus == this
}

/// The topic of an output that inputs of other processes are connected to: `port.RoverDriver.odom`.
pub fn port_topic(output: &str) -> String {
    format!("port.{output}")
}

/// The address of an operation of a service: `TrajectoryPlanner.planning.plan`.
pub(crate) fn address(service: &str, operation: &str) -> String {
    format!("{service}.{operation}")
}
