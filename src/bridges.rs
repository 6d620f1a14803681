//! Components that join a composite with ROS.

use std::collections::BTreeMap;

use asmotion_assembly::Make;
use asmotion_composite::Catalogue;
use asmotion_composite::model::BuiltinComponent;
use asmotion_datum::Word as _;
use asmotion_plan::{Component, Implementation, Plan};
use asmotion_runtime::{Run, System};

use crate::broker::BrokerSettings;
use crate::feature::without_bridges;

/// The ros-bridges of a mission, and the components that they show to ROS.
#[derive(Default)]
pub(crate) struct Bridges {
    #[cfg(feature = "ros")]
    desk: crate::ros_desk::RosDesk,
    #[cfg(feature = "ros")]
    buses: crate::bus_places::BusPlaces,
}

impl Bridges {
    /// The bridges of a mission of this name with these brokers, by name; without a name if one carries everything.
    pub(crate) fn on(brokers: &BTreeMap<Option<&str>, &BrokerSettings>, composite: &str) -> Self {
        #[cfg(not(feature = "ros"))]
        let _ = (brokers, composite);
        Self {
            #[cfg(feature = "ros")]
            buses: crate::bus_places::BusPlaces::of(brokers, composite),
            ..Self::default()
        }
    }

    /// Returns the constructor of a ros-bridge, as [`make`] does.
    pub(crate) fn make(
        &self,
        catalogue: &dyn Catalogue,
        component: &Component,
        plan: &Plan,
    ) -> Option<Make> {
        make_in(self, catalogue, component, plan)
    }

    /// Observes the components that bridges of the plan show. To be called before the system runs.
    pub(crate) fn observe(&self, system: &mut System, plan: &Plan) {
        #[cfg(feature = "ros")]
        self.desk.observe(system, plan);
        #[cfg(not(feature = "ros"))]
        let _ = (system, plan);
    }

    /// Carries out what clients in ROS want of components. To be called regularly while the system runs.
    pub(crate) fn process(&mut self, run: &mut dyn Run) {
        #[cfg(feature = "ros")]
        self.desk.process(run);
        #[cfg(not(feature = "ros"))]
        let _ = run;
    }

    /// Another version of the composite runs.
    pub(crate) fn follow(&self) {
        #[cfg(feature = "ros")]
        self.desk.follow();
    }
}

/// Returns the constructor of a ros-bridge; `None` for other components, and for bridges that no build connects. In a build without
/// the feature it fails, and says so.
pub(crate) fn make(catalogue: &dyn Catalogue, component: &Component, plan: &Plan) -> Option<Make> {
    make_in(&Bridges::default(), catalogue, component, plan)
}

fn make_in(
    bridges: &Bridges,
    catalogue: &dyn Catalogue,
    component: &Component,
    plan: &Plan,
) -> Option<Make> {
    let Implementation::Builtin { name, bridge, .. } = &component.implementation else {
        return None;
    };
    if *name != BuiltinComponent::RosBridge.word() {
        return None;
    }
    let named = bridge.as_ref()?;
    let bridge = plan.bridges.iter().find(|it| it.name == *named)?;
    if let Some(left_out) = without_bridges(bridge.kind) {
        return Some(Box::new(move |_: &mut _| Err(left_out.to_string())));
    }
    #[cfg(feature = "ros")]
    {
        let desk = bridges.desk.components();
        with_ros::make(catalogue, component, plan, bridge, (desk, &bridges.buses))
    }
    #[cfg(not(feature = "ros"))]
    {
        let _ = (bridges, catalogue, component);
        None
    }
}

#[cfg(feature = "ros")]
mod with_ros {
    use std::collections::BTreeSet;
    use std::time::Duration;

    use asmotion_component::Interface;
    use asmotion_component::declaration::OperationDeclaration;
    use asmotion_composite::model::{
        BridgeKind, Direction, Durability, PlannedMapEntry, PlannedRosEntry, RosReliability,
    };
    use asmotion_datum::Schema;
    use asmotion_plan::Bridge;
    use asmotion_ros_gateway::{
        ComponentDesk, FieldConverter, MappedFeedback, MappedFrame, MappedOperation, MappedTopic,
        Ros1Settings, Ros1Transport, RosBridge, RosDirection, RosTransport, ShownComponent,
    };

    use super::{Catalogue, Component, Make, Plan};
    use crate::build::ros_messages;
    use crate::bus_places::BusPlaces;
    use crate::ros_host::own_host;

    pub(super) fn make(
        catalogue: &dyn Catalogue,
        component: &Component,
        plan: &Plan,
        bridge: &Bridge,
        (desk, buses): (ComponentDesk, &BusPlaces),
    ) -> Option<Make> {
        let node = bridge.node.clone();
        let node = node.unwrap_or_else(|| node_name(component, plan));
        let transport = match bridge.kind {
            BridgeKind::Ros1 => ros1(node, bridge, relays(component, plan, buses)),
            BridgeKind::Ros2 => ros2(node, bridge, relays(component, plan, buses)),
            BridgeKind::Rosbridge => return None,
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
        let (shown, transforms) = (shown(component), bridge.transforms.clone());
        Some(Box::new(move |interface: &mut Interface| {
            let bridge = RosBridge::new(transport?, mapped, interface)?;
            let bridge = bridge.with_operations(operations, interface)?;
            let bridge = bridge.showing(shown, desk);
            let bridge = bridge.with_transforms_of(&transforms);
            Ok(Box::new(bridge) as Box<dyn asmotion_component::Component>)
        }))
    }

    fn ros1(
        node: String,
        bridge: &Bridge,
        relays: Vec<(String, String)>,
    ) -> Result<Box<dyn RosTransport>, String> {
        let settings = Ros1Settings {
            node,
            master: master(bridge),
            host: own_host(&master(bridge)),
            relays,
        };
        let definitions = ros_messages::of_bridge(bridge.kind, &bridge.definitions)?;
        Ok(Box::new(Ros1Transport::new(settings, definitions)))
    }

    #[cfg(feature = "ros2")]
    fn ros2(
        node: String,
        bridge: &Bridge,
        relays: Vec<(String, String)>,
    ) -> Result<Box<dyn RosTransport>, String> {
        use crate::ros_domain::{networks, own_domain};
        use asmotion_ros_gateway::{Ros2Settings, Ros2Transport};

        let domain = match bridge.domain {
            // in the range of the key
            Some(domain) => u16::try_from(domain).unwrap_or(u16::MAX),
            None => own_domain()?,
        };
        let settings = Ros2Settings {
            node,
            domain,
            networks: networks()?,
            relays,
        };
        let definitions = ros_messages::of_bridge(bridge.kind, &bridge.definitions)?;
        Ok(Box::new(Ros2Transport::new(settings, definitions)))
    }

    #[cfg(not(feature = "ros2"))]
    fn ros2(
        _: String,
        _: &Bridge,
        _: Vec<(String, String)>,
    ) -> Result<Box<dyn RosTransport>, String> {
        Err(crate::feature::LeftOut::new::<crate::feature::Ros2>().to_string())
    }

    /// The topics of ROS whose messages a bridge brings to a topic from which it sends them to another topic of ROS, with that one.
    /// So are the topics of ROS that it brings to a topic on a bus, and those to which it sends one from there.
    fn relays(component: &Component, plan: &Plan, buses: &BusPlaces) -> Vec<(String, String)> {
        let mut brought = Vec::new();
        let mut sent = Vec::new();
        let mut abroad = BTreeSet::new();
        for entry in &component.special.map {
            let PlannedMapEntry::Ros(entry) = entry else {
                continue;
            };
            let (ports, entries) = match entry.direction {
                Direction::FromRos => (&component.outputs, &mut brought),
                Direction::ToRos => (&component.inputs, &mut sent),
            };
            let port = ports.iter().find(|port| port.name == entry.from);
            if let Some(topic) = port.and_then(|port| port.topic.as_ref()) {
                entries.push((topic, &entry.ros));
            }
            let outside = buses.of_port(plan, component, &entry.from);
            abroad.extend(outside.into_iter().map(|outside| match entry.direction {
                Direction::FromRos => (entry.ros.clone(), outside),
                Direction::ToRos => (outside, entry.ros.clone()),
            }));
        }
        let pairs = brought.iter().flat_map(|(topic, from)| {
            let onward = sent
                .iter()
                .filter(move |(same, to)| same == topic && to != from);
            onward.map(move |(_, to)| ((*from).clone(), (*to).clone()))
        });
        pairs.chain(abroad).collect()
    }

    /// The components that a bridge shows: one entry for each name in ROS.
    fn shown(component: &Component) -> Vec<ShownComponent> {
        let special = &component.special;
        let parameters = special.parameters.iter().map(|it| (it, true));
        let managed = special.managed.iter().map(|it| (it, false));
        let mut shown: Vec<ShownComponent> = Vec::new();
        for ((name, ros), has_parameters) in parameters.chain(managed) {
            let (component, property) = match name.split_once('.') {
                Some((component, property)) => (component, Some(property.to_owned())),
                None => (name.as_str(), None),
            };
            let mut known = shown.iter_mut();
            if let Some(same) = known.find(|it| it.ros == *ros && it.component == component) {
                same.has_parameters |= has_parameters;
                same.is_managed |= !has_parameters;
                continue;
            }
            shown.push(ShownComponent {
                component: component.to_owned(),
                property,
                ros: ros.clone(),
                has_parameters,
                is_managed: !has_parameters,
            });
        }
        shown
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
            is_best_effort: qos.reliability == RosReliability::BestEffort,
            deadline: qos.deadline_ms.map(Duration::from_millis),
            lifespan: qos.lifespan_ms.map(Duration::from_millis),
            converters: entry
                .convert
                .iter()
                // a wrong one has been reported, and the composite does not start
                .filter_map(|(path, text)| FieldConverter::parse(path, text).ok())
                .collect(),
            transform: entry.transform.as_ref().map(|of| MappedFrame {
                frame: of.frame.clone(),
                timeout: Duration::from_millis(of.timeout_ms),
            }),
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
        let known = catalogue.operations(interface);
        let known = known.or_else(|| plan.interfaces.get(interface).cloned());
        let known = known.unwrap_or_default();
        let declared = |name: &str| {
            let found = known.iter().find(|it| it.name == name).cloned();
            found.unwrap_or_else(|| OperationDeclaration::opaque(name))
        };
        let cancel = entry.cancel.as_deref();
        let cancel = cancel.and_then(|cancel| cancel.split_once('.'));
        let mapped_port = |named: &String| {
            let port = ports.iter().find(|port| port.name == *named);
            let schema = port.and_then(|port| plan.types.get(&port.kind)).cloned();
            MappedFeedback {
                port: named.clone(),
                schema: schema.unwrap_or_else(|| Schema::opaque("")),
            }
        };
        Some(MappedOperation {
            port: port.to_owned(),
            interface: interface.clone(),
            operation: declared(name),
            cancel: cancel.map(|(_, name)| declared(name)),
            feedback: entry.feedback.as_ref().map(mapped_port),
            result: entry.result.as_ref().map(mapped_port),
            ros: entry.ros.clone(),
            kind: entry.kind.clone(),
            direction,
        })
    }
}
