//! The message types of a composite, for what describes the messages of its run.

use std::collections::BTreeMap;

use asmotion_datum::Schema;
use asmotion_plan::Plan;

/// The message types of all ports, as `Component.port`.
pub(super) fn port_types(plan: &Plan) -> BTreeMap<String, Schema> {
    let ports = plan.components.iter().flat_map(|component| {
        let ports = component.inputs.iter().chain(&component.outputs);
        ports.filter_map(|port| {
            let schema = plan.types.get(&port.kind)?;
            Some((format!("{}.{}", component.name, port.name), schema.clone()))
        })
    });
    ports.collect()
}
