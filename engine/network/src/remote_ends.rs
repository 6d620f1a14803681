//! The remote ends of a system, collected before it is attached to buses.

use std::collections::BTreeMap;

use asmotion_bus::PublishOptions;
use asmotion_component::declaration::{OperationDeclaration, ReferenceDeclaration};
use asmotion_datum::Shape;
use asmotion_runtime::ComponentEnd;

use crate::remote::RemoteRoute;

/// The remote ends of a system, except its topics.
#[derive(Default)]
pub(crate) struct RemoteEnds {
    /// The bus of each component, by position in the system; empty if there is only one bus.
    pub component_buses: BTreeMap<usize, String>,
    /// Publishing options by topic; topics that are not listed use the default.
    pub publish_options: BTreeMap<String, PublishOptions>,
    /// Outputs connected to inputs of other processes.
    pub exposed: Vec<(ComponentEnd, PublishOptions)>,
    /// Services that other processes may call.
    pub offered: Vec<OfferedService>,
    /// References to services of other processes.
    pub remote_references: Vec<RemoteReference>,
}

/// A service that other processes may call.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct OfferedService {
    pub service: ComponentEnd,
    /// Prefix of its operations' addresses.
    pub name: String,
    /// The bus, if there are several.
    pub bus: Option<String>,
}

/// A reference to a service of another process.
pub(crate) struct RemoteReference {
    pub route: RemoteRoute,
    /// The bus, if there are several.
    pub bus: Option<String>,
}

/// Returns whether an end on `bus` uses the bus named `this`. A single bus has no name and is used by all ends.
pub(crate) fn is_on(bus: Option<&str>, this: Option<&str>) -> bool {
    this.is_none() || bus == this
}

/// Name of a topic in events of the system.
pub(crate) fn outer_topic(topic: &str) -> String {
    format!("bus topic {topic}")
}

/// Name of an offered service in changes of the system.
pub(crate) fn outer_service(name: &str) -> String {
    format!("service {name}")
}

/// The topic of an output that is connected to inputs of other processes, for example `port.RoverDriver.odom`.
pub fn port_topic(output: &str) -> String {
    format!("port.{output}")
}

/// The address of an operation, for example `TrajectoryPlanner.planning.plan`.
pub(crate) fn address(service: &str, operation: &str) -> String {
    format!("{service}.{operation}")
}

/// The calling component, and its reference with what it leads to in words. `from` is `Component.reference`.
pub(crate) fn caller_and_service(from: &str, service: &str) -> (String, String) {
    let (caller, reference) = from.rsplit_once('.').unwrap_or((from, ""));
    (caller.to_owned(), format!("`{reference}` at {service}"))
}

/// Gives operations that a reference declares without types those of its interface.
pub(crate) fn complete_types(reference: &mut ReferenceDeclaration, known: &[OperationDeclaration]) {
    for operation in &mut reference.operations {
        let of_interface = known.iter().find(|it| it.name == operation.name);
        if let Some(of_interface) = of_interface
            && operation.request.shape == Shape::Any
            && operation.response.shape == Shape::Any
        {
            operation.clone_from(of_interface);
        }
    }
}
