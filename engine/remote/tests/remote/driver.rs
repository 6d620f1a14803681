//! A driver of two joints, and a composite with it.

use std::time::Duration;

use asmotion_component::declaration::OperationDeclaration;
use asmotion_component::{
    Component, Cycle, Fault, In, Interface, Operation, Out, Property, Provided,
};
use asmotion_composite::{Constructor, Context, EmptyEnvironment, NoSpecifications, Tables};
use asmotion_datum::{Message, Schema};
use asmotion_lang::MemoryFiles;
use asmotion_plan::Opened;

asmotion_datum::message! {
    /// Positions of the joints.
    pub struct Joints = "test/Joints" {
        /// radians
        pub position: [f64; 2],
    }
}

/// Positions that take a cycle of [`LONG_CYCLE`].
pub const LONG_WAY: [f64; 2] = [1e3, 1e3];
/// A cycle in which the component cannot be asked.
const LONG_CYCLE: Duration = Duration::from_millis(700);

/// Mirrors joint positions.
pub struct Mirror;

impl Operation for Mirror {
    type Request = Joints;
    type Response = Joints;
    const INTERFACE: &'static str = "test/Mirror";
    const NAME: &'static str = "mirror";
}

/// Reports each commanded position as reached.
struct Driver {
    commands: In<Joints>,
    status: Out<Joints>,
    _scale: Property<f64>,
    mirror: Provided<Mirror>,
}

impl Driver {
    fn make(interface: &mut Interface) -> Box<dyn Component> {
        Box::new(Self {
            commands: interface.input("commands", "where to go"),
            status: interface.output("status", "where it is"),
            _scale: interface.property("scale", 1.0, "of all that is told"),
            mirror: interface.serve("mirror", "turned about"),
        })
    }
}

impl Component for Driver {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(joints) = cycle.read(self.commands).new().cloned() {
            if joints.position == LONG_WAY {
                std::thread::sleep(LONG_CYCLE);
            }
            cycle.write(self.status, joints);
        }
        for request in cycle.requests(self.mirror) {
            let position = request.argument.position.map(|it| -it);
            cycle.reply(self.mirror, request.id, Ok(Joints { position }));
        }
        Ok(())
    }
}

const COMPONENTS: &[(&str, Constructor)] = &[("test::Driver", Driver::make)];

/// The tables of the test components.
pub const BUILD: Tables = Tables {
    components: COMPONENTS,
    messages: &[(Joints::NAME, Joints::schema as fn() -> &'static Schema)],
    interfaces: &[(Mirror::INTERFACE, mirror)],
    builtins: &[],
    ros: None,
};

fn mirror() -> Vec<OperationDeclaration> {
    vec![OperationDeclaration {
        while_stopped: false,
        name: Mirror::NAME.to_owned(),
        request: Joints::schema().clone(),
        response: Joints::schema().clone(),
    }]
}

/// A driver, and a broker that it may use.
const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "arm"

[properties]
broker = { type = "uri", default = "amqp://arm1/cell" }

[brokers.main]
url = "${properties.broker}"

[components.Driver]
implementation = { rust = "test::Driver" }
task = { period_ms = 10 }
subscribe = { commands = "test/Joints" }
publish = { status = "test/Joints" }
"#;

/// A loader with the composite.
pub fn files() -> MemoryFiles {
    let mut files = MemoryFiles::new();
    files.add("arm.composite.toml", COMPOSITE);
    files
}

/// Opens the composite with these properties.
pub fn open(settings: &[(String, String)]) -> Opened {
    let files = files();
    let context = Context {
        loader: &files,
        environment: &EmptyEnvironment,
        catalogue: &BUILD,
        specifications: &NoSpecifications,
        programs: &asmotion_composite::NoPrograms,
        settings,
    };
    let opened = asmotion_plan::open("arm.composite.toml", &context);
    assert!(
        !opened.report.has_errors(),
        "{:?}",
        opened.report.diagnostics
    );
    opened
}

/// Joints at these positions.
pub fn joints(position: [f64; 2]) -> Joints {
    Joints { position }
}
