//! The catalogue for composites: component names with constructors, message names with schemas, interface names with
//! operations. The checker of composites reads these tables too; nothing is run here.
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
use asmotion_datum::Schema;
use asmotion_messages::{
    DriverSetPeriod, DriverState, GetJointsPositions, GetMap, MoveTo, Notify, Plan,
    SetJointsPositions, SetPeriod, Solve,
};

pub use asmotion_messages::MESSAGES;

/// Creates a component and declares it on the interface.
pub type MakeComponent = fn(&mut Interface) -> Box<dyn Component>;

/// The rows of the catalogue; each component has a constructor `new`.
macro_rules! catalogue {
    ($($name:literal => $component:ty;)+) => {
        &[$(($name, |interface| Box::new(<$component>::new(interface)))),+]
    };
}

/// All components by their names in composites.
pub const COMPONENTS: &[(&str, MakeComponent)] = catalogue! {
    "nav::MapServer" => asmotion_map::MapServer;
    "nav::TrajectoryPlanner" => asmotion_planner::TrajectoryPlanner;
    "nav::TrajectoryAdapter" => asmotion_adapter::TrajectoryAdapter;
    "nav::TrajectoryFollower" => asmotion_follower::TrajectoryFollower;
    "nav::Operator" => asmotion_operator::ScriptedOperator;
    "nav::sim::RoverDriver" => asmotion_rover::RoverDriver;
    "nav::sim::LaserDriver" => asmotion_laser::LaserDriver;
    "nav::sim::World" => asmotion_world::World;
    "nav::sim::Traffic" => asmotion_world::Traffic;
    "nav::CollisionMonitor" => asmotion_collision_monitor::CollisionMonitor;
    "youbot::DummyDriver" => asmotion_youbot::DummyDriver;
    "youbot::Kinematics" => asmotion_youbot::Kinematics;
    "youbot::Operator" => asmotion_youbot::YoubotOperator;
};

/// Protocols of components by their names in composites: specifications of what they send, depending on what they receive.
pub const PROTOCOLS: &[(&str, &str)] = &[
    ("nav::MapServer", asmotion_map::PROTOCOL),
    ("nav::TrajectoryPlanner", asmotion_planner::PROTOCOL),
    ("nav::TrajectoryAdapter", asmotion_adapter::PROTOCOL),
    ("nav::TrajectoryFollower", asmotion_follower::PROTOCOL),
    ("nav::Operator", asmotion_operator::PROTOCOL),
    ("nav::sim::RoverDriver", asmotion_rover::PROTOCOL),
    ("nav::sim::LaserDriver", asmotion_laser::PROTOCOL),
    (
        "nav::CollisionMonitor",
        asmotion_collision_monitor::PROTOCOL,
    ),
];

/// Returns the operations of an interface.
pub type Operations = fn() -> Vec<OperationDeclaration>;

/// All service interfaces by name.
pub const INTERFACES: &[(&str, Operations)] = &[
    (GetMap::INTERFACE, || {
        vec![OperationDeclaration::of::<GetMap>()]
    }),
    (Plan::INTERFACE, || vec![OperationDeclaration::of::<Plan>()]),
    (DriverState::INTERFACE, || {
        vec![
            OperationDeclaration::of::<DriverSetPeriod>(),
            OperationDeclaration::of::<DriverState>(),
        ]
    }),
    (Solve::INTERFACE, || {
        vec![OperationDeclaration::of::<Solve>()]
    }),
    (MoveTo::INTERFACE, || {
        vec![OperationDeclaration::of::<MoveTo>()]
    }),
    (Notify::INTERFACE, || {
        vec![OperationDeclaration::of::<Notify>()]
    }),
    (GetJointsPositions::INTERFACE, || {
        vec![OperationDeclaration::of::<GetJointsPositions>()]
    }),
    (SetJointsPositions::INTERFACE, || {
        vec![OperationDeclaration::of::<SetJointsPositions>()]
    }),
    (SetPeriod::INTERFACE, || {
        vec![OperationDeclaration::of::<SetPeriod>()]
    }),
];

/// The constructor of the component with this name.
pub fn component(name: &str) -> Option<MakeComponent> {
    row(COMPONENTS, name)
}

/// The protocol of the component with this name.
pub fn protocol(name: &str) -> Option<&'static str> {
    row(PROTOCOLS, name)
}

/// The operations of the interface with this name.
pub fn interface(name: &str) -> Option<Vec<OperationDeclaration>> {
    row(INTERFACES, name).map(|operations| operations())
}

/// The schema of the message with this name.
pub fn message(name: &str) -> Option<&'static Schema> {
    row(MESSAGES, name).map(|schema| schema())
}

fn row<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    let (_, found) = table.iter().find(|(row, _)| *row == name)?;
    Some(*found)
}

#[cfg(test)]
mod tests {
    use super::*;

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
                // a component decides itself what it answers while it is stopped
                let mut operations = service.operations.clone();
                for operation in &mut operations {
                    operation.while_stopped = false;
                }
                let known = interface(&service.interface);
                assert_eq!(known.as_deref(), Some(&operations[..]), "{name}");
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
