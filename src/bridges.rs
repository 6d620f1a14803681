//! Components that join a composite with ROS.

use asmotion_assembly::Make;
use asmotion_composite::Catalogue;
use asmotion_plan::{Component, Plan};

/// Returns the constructor of a ros-bridge; `None` for other components, and if this build has no node of this kind.
#[cfg(not(feature = "ros"))]
pub(crate) fn make(_: &dyn Catalogue, _: &Component, _: &Plan) -> Option<Make> {
    None
}

#[cfg(feature = "ros")]
pub(crate) use with_ros::make;

#[cfg(feature = "ros")]
mod with_ros {
    use asmotion_component::Interface;
    use asmotion_component::declaration::OperationDeclaration;
    use asmotion_composite::model::{
        BridgeKind, BuiltinComponent, Direction, Durability, PlannedMapEntry, PlannedRosEntry,
    };
    use asmotion_datum::{Schema, Word as _};
    use asmotion_plan::{Bridge, Implementation};
    use asmotion_ros_gateway::{
        FieldConverter, MappedFeedback, MappedOperation, MappedTopic, Ros1Settings, Ros1Transport,
        RosBridge, RosDirection,
    };

    use super::{Catalogue, Component, Make, Plan};
    use crate::build::ros_messages;
    use crate::ros_host::own_host;

    pub(crate) fn make(
        catalogue: &dyn Catalogue,
        component: &Component,
        plan: &Plan,
    ) -> Option<Make> {
        let Implementation::Builtin { name, bridge, .. } = &component.implementation else {
            return None;
        };
        let named = bridge.as_ref()?;
        let bridge = plan.bridges.iter().find(|it| it.name == *named)?;
        if *name != BuiltinComponent::RosBridge.word() || bridge.kind != BridgeKind::Ros1 {
            return None;
        }
        let settings = Ros1Settings {
            node: bridge
                .node
                .clone()
                .unwrap_or_else(|| node_name(component, plan)),
            master: master(bridge),
            host: own_host(&master(bridge)),
        };
        let (mut mapped, mut operations) = (Vec::new(), Vec::new());
        for entry in &component.special.map {
            let PlannedMapEntry::Ros(entry) = entry else {
                continue;
            };
            match entry.from.split_once('.') {
                None => mapped.push(mapped_topic(component, plan, entry)),
                Some(named) => {
                    let operation = mapped_operation(catalogue, component, plan, entry, named);
                    operations.extend(operation);
                }
            }
        }
        Some(Box::new(move |interface: &mut Interface| {
            let transport = Ros1Transport::new(settings, ros_messages::noetic());
            let bridge = RosBridge::new(Box::new(transport), mapped, interface)?;
            let bridge = bridge.with_operations(operations, interface)?;
            Ok(Box::new(bridge) as Box<dyn asmotion_component::Component>)
        }))
    }

    fn master(bridge: &Bridge) -> String {
        let master = bridge.master.as_ref();
        master.map_or(String::new(), |it| it.reveal().to_owned())
    }

    /// The name of the node of a bridge without one, such as `/navigation_RosBridge`.
    fn node_name(component: &Component, plan: &Plan) -> String {
        let text = format!("{}_{}", plan.name, component.name);
        let sign = |sign: char| {
            if sign.is_ascii_alphanumeric() {
                sign
            } else {
                '_'
            }
        };
        let name: String = text.chars().map(sign).collect();
        let digit = name.starts_with(|first: char| first.is_ascii_digit());
        format!("/{}{name}", if digit { "_" } else { "" })
    }

    fn mapped_topic(component: &Component, plan: &Plan, entry: &PlannedRosEntry) -> MappedTopic {
        let (ports, direction) = match entry.direction {
            Direction::ToRos => (&component.inputs, RosDirection::ToRos),
            Direction::FromRos => (&component.outputs, RosDirection::FromRos),
        };
        let port = ports.iter().find(|port| port.name == entry.from);
        let schema = port.and_then(|port| plan.types.get(&port.kind)).cloned();
        let qos = entry.qos.clone().unwrap_or_default();
        MappedTopic {
            port: entry.from.clone(),
            topic: port.and_then(|port| port.topic.clone()),
            schema: schema.unwrap_or_else(|| Schema::opaque(entry.kind.clone())),
            ros: entry.ros.clone(),
            kind: entry.kind.clone(),
            queue: usize::try_from(qos.depth).unwrap_or(usize::MAX),
            is_latched: qos.durability == Durability::TransientLocal,
            converters: entry
                .convert
                .iter()
                // a wrong one has been reported, and the composite does not start
                .filter_map(|(path, text)| FieldConverter::parse(path, text).ok())
                .collect(),
            direction,
        }
    }

    /// The operation of a service (to ROS) or a reference (from ROS); `None` if the component has none of this name.
    fn mapped_operation(
        catalogue: &dyn Catalogue,
        component: &Component,
        plan: &Plan,
        entry: &PlannedRosEntry,
        (port, name): (&str, &str),
    ) -> Option<MappedOperation> {
        let (listed, ports, direction) = match entry.direction {
            Direction::ToRos => (&component.services, &component.outputs, RosDirection::ToRos),
            Direction::FromRos => (
                &component.references,
                &component.inputs,
                RosDirection::FromRos,
            ),
        };
        let interface = &listed.iter().find(|it| it.name == port)?.interface;
        // with an unknown interface, conversions depend on the data at run time
        let known = catalogue.operations(interface).unwrap_or_default();
        let declared = |name: &str| {
            let found = known.iter().find(|it| it.name == name).cloned();
            found.unwrap_or_else(|| OperationDeclaration::opaque(name))
        };
        let cancel = entry.cancel.as_deref();
        let cancel = cancel.and_then(|cancel| cancel.split_once('.'));
        let feedback = entry.feedback.as_ref().map(|feedback| {
            let port = ports.iter().find(|port| port.name == *feedback);
            let schema = port.and_then(|port| plan.types.get(&port.kind)).cloned();
            MappedFeedback {
                port: feedback.clone(),
                schema: schema.unwrap_or_else(|| Schema::opaque("")),
            }
        });
        Some(MappedOperation {
            port: port.to_owned(),
            interface: interface.clone(),
            operation: declared(name),
            cancel: cancel.map(|(_, name)| declared(name)),
            feedback,
            ros: entry.ros.clone(),
            kind: entry.kind.clone(),
            direction,
        })
    }
}
