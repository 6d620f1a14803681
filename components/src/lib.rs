//! The catalogue: what a composite may name. Component name to constructor, message name to schema, interface name to
//! operations. A checker reads these tables; nothing here runs.
//!
//! ```
//! let make = asmotion_components::component("nav::TrajectoryFollower").ok_or("no such component")?;
//! let mut scratch = asmotion_component::Interface::new();
//! make(&mut scratch);
//! assert!(scratch.declaration().input("path").is_some());
//! # Ok::<(), &str>(())
//! ```

use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{Component, Interface, Operation};
use asmotion_datum::{Message, Schema};
use asmotion_messages::{
    DriverSetPeriod, DriverState, GetJointsPositions, GetMap, MoveTo, Notify, Plan,
    SetJointsPositions, SetPeriod, Solve,
};

pub use asmotion_messages::MESSAGES;

/// Makes a component: declares it on the interface.
pub type Make = fn(&mut Interface) -> Box<dyn Component>;

/// Every component by the name a composite gives it.
pub const COMPONENTS: &[(&str, Make)] = &[
    ("nav::MapServer", |interface| {
        Box::new(asmotion_map::MapServer::new(interface))
    }),
    ("nav::TrajectoryPlanner", |interface| {
        Box::new(asmotion_planner::TrajectoryPlanner::new(interface))
    }),
    ("nav::TrajectoryAdapter", |interface| {
        Box::new(asmotion_adapter::TrajectoryAdapter::new(interface))
    }),
    ("nav::TrajectoryFollower", |interface| {
        Box::new(asmotion_follower::TrajectoryFollower::new(interface))
    }),
    ("nav::Operator", |interface| {
        Box::new(asmotion_operator::Operator::new(interface))
    }),
    ("nav::sim::RoverDriver", |interface| {
        Box::new(asmotion_rover::RoverDriver::new(interface))
    }),
    ("nav::sim::LaserDriver", |interface| {
        Box::new(asmotion_laser::LaserDriver::new(interface))
    }),
    ("nav::sim::World", |interface| {
        Box::new(asmotion_world::World::new(interface))
    }),
    ("youbot::DummyDriver", |interface| {
        Box::new(asmotion_youbot::DummyDriver::new(interface))
    }),
    ("youbot::Kinematics", |interface| {
        Box::new(asmotion_youbot::Kinematics::new(interface))
    }),
    ("youbot::Operator", |interface| {
        Box::new(asmotion_youbot::Operator::new(interface))
    }),
];

/// The operations of an interface.
pub type Operations = fn() -> Vec<OperationDeclaration>;

/// Every service interface by its name.
pub const INTERFACES: &[(&str, Operations)] = &[
    (GetMap::INTERFACE, || vec![operation::<GetMap>()]),
    (Plan::INTERFACE, || vec![operation::<Plan>()]),
    (DriverState::INTERFACE, || {
        vec![operation::<DriverSetPeriod>(), operation::<DriverState>()]
    }),
    (Solve::INTERFACE, || vec![operation::<Solve>()]),
    (MoveTo::INTERFACE, || vec![operation::<MoveTo>()]),
    (Notify::INTERFACE, || vec![operation::<Notify>()]),
    (GetJointsPositions::INTERFACE, || {
        vec![operation::<GetJointsPositions>()]
    }),
    (SetJointsPositions::INTERFACE, || {
        vec![operation::<SetJointsPositions>()]
    }),
    (SetPeriod::INTERFACE, || vec![operation::<SetPeriod>()]),
];

/// The constructor of a component.
pub fn component(name: &str) -> Option<Make> {
    row(COMPONENTS, name)
}

/// The operations of an interface.
pub fn interface(name: &str) -> Option<Vec<OperationDeclaration>> {
    row(INTERFACES, name).map(|operations| operations())
}

/// The schema of a message.
pub fn message(name: &str) -> Option<&'static Schema> {
    row(MESSAGES, name).map(|schema| schema())
}

fn row<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    let (_, found) = table.iter().find(|(row, _)| *row == name)?;
    Some(*found)
}

fn operation<O: Operation>() -> OperationDeclaration {
    OperationDeclaration {
        name: O::NAME.to_owned(),
        request: O::Request::schema().clone(),
        response: O::Response::schema().clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_component::declaration::PortDeclaration;

    /// Inputs, outputs, services and references of a component, as text.
    fn shape(name: &str) -> String {
        let mut scratch = Interface::new();
        component(name).unwrap()(&mut scratch);
        let ports = |ports: &[PortDeclaration]| {
            let words = ports
                .iter()
                .map(|port| format!("{}: {}", port.name, port.schema));
            words.collect::<Vec<_>>().join(", ")
        };
        let declaration = scratch.declaration();
        let services = declaration
            .services
            .iter()
            .map(|service| format!("{}: {}", service.name, service.interface));
        let references = declaration.references.iter().map(|reference| {
            let optional = if reference.optional { "?" } else { "" };
            format!("{}: {}{optional}", reference.name, reference.interface)
        });
        [
            ports(&declaration.inputs),
            ports(&declaration.outputs),
            services.collect::<Vec<_>>().join(", "),
            references.collect::<Vec<_>>().join(", "),
        ]
        .join(" | ")
    }

    #[test]
    fn every_component_has_the_ports_that_were_agreed() {
        for (name, expected) in [
            (
                "nav::TrajectoryAdapter",
                "path: nav_msgs/Path, scan: sensor_msgs/LaserScan, odom: nav_msgs/Odometry, map: nav_msgs/OccupancyGrid, permit: std_msgs/Bool | adapted: nav_msgs/Path, event: nav/Event, obstacles: nav/Obstacles |  | ",
            ),
            (
                "nav::TrajectoryFollower",
                "path: nav_msgs/Path, odom: nav_msgs/Odometry, permit: std_msgs/Bool | twist: geometry_msgs/Twist, event: nav/Event |  | ",
            ),
            (
                "nav::sim::RoverDriver",
                "twist: geometry_msgs/Twist, encoders: rover/Encoders | wheels: rover/WheelSpeeds, odom: nav_msgs/Odometry |  | ",
            ),
            (
                "nav::sim::LaserDriver",
                "scene: world/Scene, truth: geometry_msgs/PoseStamped | scan: sensor_msgs/LaserScan |  | ",
            ),
            (
                "nav::sim::World",
                "wheels: rover/WheelSpeeds | encoders: rover/Encoders, truth: geometry_msgs/PoseStamped, scene: world/Scene, event: nav/Event |  | ",
            ),
        ] {
            assert_eq!(shape(name), expected, "{name}");
        }
        assert!(shape("nav::MapServer").contains("maps: nav/MapService"));
        assert!(shape("nav::TrajectoryPlanner").contains("planning: nav/PlanService"));
    }

    #[test]
    fn every_declaration_holds_together_and_is_documented() {
        for (name, make) in COMPONENTS {
            let mut scratch = Interface::new();
            make(&mut scratch);
            assert_eq!(scratch.problems(), [], "{name}");
            let declaration = scratch.declaration();
            let ports = declaration.inputs.iter().chain(&declaration.outputs);
            for port in ports {
                assert!(
                    message(&port.schema.name).is_some(),
                    "{name}: {} is not in the table",
                    port.schema
                );
                assert!(!port.doc.is_empty(), "{name}.{}", port.name);
            }
            for property in &declaration.properties {
                assert!(!property.doc.is_empty(), "{name}.{}", property.name);
            }
            for service in &declaration.services {
                assert_eq!(
                    interface(&service.interface).as_deref(),
                    Some(&service.operations[..]),
                    "{name}"
                );
            }
        }
    }

    #[test]
    fn it_does_not_know_what_there_is_not() {
        assert!(component("nav::Follower").is_none());
        assert!(message("nav_msgs/Pose").is_none());
        assert!(interface("").is_none());
    }
}
