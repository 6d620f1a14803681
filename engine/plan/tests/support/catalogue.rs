//! A catalogue with a few components of the navigation architecture.

use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use asmotion_component::declaration::{
    Declaration, OperationDeclaration, PortDeclaration, PropertyDeclaration, ReferenceDeclaration,
    ServiceDeclaration,
};
use asmotion_composite::model::{BridgeKind, BuiltinComponent};
use asmotion_composite::{
    Catalogue, ComponentFactory, RosFolderProblem, RosFolders, RosMessage, RosMessages,
    RosOperation, RosOperations,
};
use asmotion_datum::{Datum, OutlineKey, Schema, Shape};
use asmotion_diagnostics::Loader;

/// A catalogue with a few components, message types and interfaces.
pub struct SmallBuild;

impl Catalogue for SmallBuild {
    fn components(&self) -> Vec<String> {
        [
            "nav::MapServer",
            "nav::Planner",
            "nav::Follower",
            "nav::Rover",
            "nav::Laser",
            "nav::Mixer",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn factory(&self, _: &str) -> Option<ComponentFactory> {
        None
    }

    fn declaration(&self, component: &str) -> Option<Arc<Declaration>> {
        Some(Arc::new(match component {
            "nav::MapServer" => Declaration {
                outputs: vec![port("map", "nav_msgs/OccupancyGrid")],
                services: vec![service("maps", "nav/MapService")],
                properties: vec![
                    property("source", Shape::Text, Datum::text("")),
                    ranged("resolution_m", 0.05, 0.01, 1.0, "m"),
                ],
                ..Declaration::default()
            },
            "nav::Planner" => Declaration {
                outputs: vec![port("trajectory", "nav_msgs/Path")],
                services: vec![service("planning", "nav/PlanService")],
                references: vec![reference("maps", "nav/MapService")],
                properties: vec![
                    ranged("inflation_m", 0.35, 0.0, 2.0, "m"),
                    PropertyDeclaration {
                        choices: vec![Datum::text("astar"), Datum::text("lattice")],
                        ..property("algorithm", Shape::Text, Datum::text("astar"))
                    },
                ],
                ..Declaration::default()
            },
            // calls `getMap` with another request, and one that no service has
            "nav::Surveyor" => Declaration {
                references: vec![ReferenceDeclaration {
                    operations: vec![
                        operation("getMap", "std_msgs/Bool", "nav_msgs/OccupancyGrid"),
                        operation("eraseMap", "nav/Place", "std_msgs/Empty"),
                    ],
                    ..reference("maps", "nav/MapService")
                }],
                ..Declaration::default()
            },
            "nav::Archive" => Declaration {
                services: vec![ServiceDeclaration {
                    operations: vec![operation("getMap", "nav/Place", "nav_msgs/OccupancyGrid")],
                    ..service("maps", "nav/MapService")
                }],
                ..Declaration::default()
            },
            "nav::Follower" => Declaration {
                inputs: vec![
                    port("path", "nav_msgs/Path"),
                    port("odom", "nav_msgs/Odometry"),
                ],
                outputs: vec![
                    port("twist", "geometry_msgs/Twist"),
                    port("event", "nav/Event"),
                ],
                ..Declaration::default()
            },
            "nav::Rover" => Declaration {
                inputs: vec![port("twist", "geometry_msgs/Twist")],
                outputs: vec![port("odom", "nav_msgs/Odometry")],
                ..Declaration::default()
            },
            "nav::Laser" => Declaration {
                outputs: vec![port("scan", "sensor_msgs/LaserScan")],
                ..Declaration::default()
            },
            "nav::Mixer" => Declaration {
                inputs: vec![port("twist", "geometry_msgs/Twist")],
                outputs: vec![port("twist", "geometry_msgs/Twist")],
                ..Declaration::default()
            },
            _ => return None,
        }))
    }

    fn has(&self, builtin: BuiltinComponent) -> bool {
        matches!(
            builtin,
            BuiltinComponent::PortProxy
                | BuiltinComponent::Remote
                | BuiltinComponent::RosBridge
                | BuiltinComponent::WebMonitor
        )
    }

    fn ros(&self, kind: BridgeKind) -> Option<&dyn RosMessages> {
        (kind != BridgeKind::Rosbridge).then_some(self)
    }

    fn ros_with(
        &self,
        kind: BridgeKind,
        folders: &[PathBuf],
        _: &dyn Loader,
    ) -> Option<RosFolders> {
        self.ros(kind)?;
        let wrong = |(folder, path): (usize, &PathBuf)| RosFolderProblem {
            folder,
            file: None,
            line: None,
            reason: format!("{}: no such folder", path.display()),
        };
        Some(RosFolders {
            messages: Rc::new(Self),
            problems: folders.iter().enumerate().map(wrong).collect(),
        })
    }

    fn way_to_bridges(&self, _: BridgeKind) -> Option<String> {
        None
    }

    fn messages(&self) -> Vec<String> {
        [
            "std_msgs/Bool",
            "std_msgs/String",
            "geometry_msgs/Twist",
            "geometry_msgs/PoseStamped",
            "nav_msgs/Path",
            "nav_msgs/Odometry",
            "nav_msgs/OccupancyGrid",
            "sensor_msgs/LaserScan",
            "nav/Event",
            "nav/Place",
            "nav/PlanRequest",
        ]
        .map(str::to_owned)
        .to_vec()
    }

    fn schema(&self, message: &str) -> Option<Schema> {
        let float = Schema::plain(Shape::F64);
        let time = || {
            let whole = |name, shape| field(name, Schema::plain(shape));
            let fields = vec![whole("sec", Shape::I32), whole("nanosec", Shape::U32)];
            Schema::record("builtin_interfaces/Time", fields)
        };
        let text = || Schema::plain(Shape::Text);
        let fields = match message {
            "std_msgs/Empty" => Vec::new(),
            "std_msgs/Bool" => vec![field("data", Schema::plain(Shape::Bool))],
            "std_msgs/String" => vec![field("data", text())],
            "geometry_msgs/Twist" => vec![field("linear", float.clone()), field("angular", float)],
            "geometry_msgs/PoseStamped" => vec![field("stamp", time()), field("pose", float)],
            "nav_msgs/Path" => {
                let pose = self.schema("geometry_msgs/PoseStamped")?;
                vec![field("poses", Schema::many(pose, None))]
            }
            "nav_msgs/Odometry" => vec![
                field("pose", self.schema("geometry_msgs/PoseStamped")?),
                field("twist", self.schema("geometry_msgs/Twist")?),
            ],
            "nav_msgs/OccupancyGrid" => {
                vec![field("data", Schema::many(Schema::plain(Shape::I8), None))]
            }
            "sensor_msgs/LaserScan" => vec![field("ranges", Schema::many(float, None))],
            "nav/Event" => {
                vec![
                    field("stamp", time()),
                    field("code", text()),
                    field("detail", text()),
                ]
            }
            "nav/Place" => vec![field("name", text())],
            "nav/PlanRequest" => {
                let pose = self.schema("geometry_msgs/PoseStamped")?;
                let map = self.schema("nav_msgs/OccupancyGrid")?;
                vec![
                    field("map", map),
                    field("start", pose.clone()),
                    field("goal", pose),
                ]
            }
            _ => return None,
        };
        Some(Schema {
            name: message.to_owned().into(),
            shape: Shape::Record(fields),
        })
    }

    fn interfaces(&self) -> Vec<String> {
        Vec::new()
    }

    fn operations(&self, interface: &str) -> Option<Vec<OperationDeclaration>> {
        let operation = |name: &str, request, response| {
            let (request, response) = (self.schema(request)?, self.schema(response)?);
            Some(vec![OperationDeclaration {
                while_stopped: false,
                name: name.to_owned(),
                request,
                response,
            }])
        };
        match interface {
            "nav/MapService" => operation("getMap", "nav/Place", "nav_msgs/OccupancyGrid"),
            "arm/Driving" => operation("drive", "geometry_msgs/Twist", "std_msgs/Empty"),
            "arm/Measuring" => operation("measure", "std_msgs/Empty", "nav_msgs/Odometry"),
            "nav/PlanService" => operation("plan", "nav/PlanRequest", "nav_msgs/Path"),
            _ => None,
        }
    }
}

fn field(name: &'static str, schema: Schema) -> OutlineKey {
    OutlineKey::new(name, "", schema)
}

fn port(name: &str, message: &str) -> PortDeclaration {
    let schema = SmallBuild.schema(message).expect("a message of this build");
    PortDeclaration {
        name: name.to_owned(),
        schema,
        doc: String::new(),
        safe: None,
        command: false,
        optional: false,
    }
}

fn service(name: &str, interface: &str) -> ServiceDeclaration {
    ServiceDeclaration {
        name: name.to_owned(),
        interface: interface.to_owned(),
        doc: String::new(),
        operations: Catalogue::operations(&SmallBuild, interface).unwrap_or_default(),
    }
}

fn reference(name: &str, interface: &str) -> ReferenceDeclaration {
    ReferenceDeclaration {
        name: name.to_owned(),
        interface: interface.to_owned(),
        doc: String::new(),
        optional: true,
        operations: Catalogue::operations(&SmallBuild, interface).unwrap_or_default(),
    }
}

fn operation(name: &str, request: &str, response: &str) -> OperationDeclaration {
    let message = |name| SmallBuild.schema(name).expect("a message of this build");
    OperationDeclaration {
        name: name.to_owned(),
        request: message(request),
        response: message(response),
        while_stopped: false,
    }
}

fn property(name: &str, shape: Shape, default: Datum) -> PropertyDeclaration {
    PropertyDeclaration {
        name: name.to_owned(),
        doc: String::new(),
        schema: Schema::plain(shape),
        unit: String::new(),
        default,
        range: None,
        choices: Vec::new(),
        conversion: asmotion_component::PropertyConversion::default(),
    }
}

fn ranged(name: &str, default: f64, least: f64, greatest: f64, unit: &str) -> PropertyDeclaration {
    PropertyDeclaration {
        unit: unit.to_owned(),
        range: Some((Datum::Float(least), Datum::Float(greatest))),
        ..property(name, Shape::F64, Datum::Float(default))
    }
}

impl RosMessages for SmallBuild {
    fn names(&self) -> Vec<String> {
        let mut names = self.messages();
        names.retain(|name| !name.starts_with("nav/"));
        names
    }

    fn find(&self, name: &str) -> Option<RosMessage> {
        let known = RosMessages::names(self).iter().any(|it| it == name);
        let schema = self.schema(name).filter(|_| known)?;
        let definition = format!("# definition of {name}\n");
        Some(RosMessage { schema, definition })
    }

    fn operations(&self) -> Option<&dyn RosOperations> {
        Some(self)
    }
}

impl RosOperations for SmallBuild {
    fn names(&self) -> Vec<String> {
        ["nav_msgs/GetPlan", "move_base_msgs/MoveBase"]
            .map(str::to_owned)
            .to_vec()
    }

    fn find(&self, name: &str) -> Option<RosOperation> {
        let pose = || self.schema("geometry_msgs/PoseStamped");
        let record = |fields| Schema::record("", fields);
        let (request, response, feedback) = match name {
            "nav_msgs/GetPlan" => {
                let tolerance = Schema::plain(Shape::F32);
                let request = record(vec![
                    field("start", pose()?),
                    field("goal", pose()?),
                    field("tolerance", tolerance),
                ]);
                let response = record(vec![field("plan", self.schema("nav_msgs/Path")?)]);
                (request, response, None)
            }
            "move_base_msgs/MoveBase" => {
                let goal = record(vec![field("target_pose", pose()?)]);
                let feedback = record(vec![field("base_position", pose()?)]);
                (goal, record(Vec::new()), Some(feedback))
            }
            _ => return None,
        };
        let definition = format!("# definition of {name}\n");
        Some(RosOperation {
            request,
            response,
            feedback,
            definition,
        })
    }
}
