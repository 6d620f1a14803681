//! A company's program: asmotion with a component, a planner, a map format, a transport and a command of its own.
//!
//! The program is this test binary, started again with [`ARGUMENTS`] set.

use std::path::Path;
use std::process::Command;
use std::sync::{Arc, LazyLock};

use asmotion::{App, AppCommand, BrokerAddress, Exit, clap};
use asmotion_bus::{Bus, BusError, LocalBus};
use asmotion_component::{Component, Cycle, Fault, In, Interface, Out, Ports};
use asmotion_geometry::{FREE, Grid, GridLayout, Pose};
use asmotion_map::{Map, MapError, MapFormat, MapSettings, MapSource};
use asmotion_planner::{NoPath, PlannedPath, Planner};

/// Arguments of the program, one on each line.
const ARGUMENTS: &str = "ASMOTION_TEST_APP";

asmotion_datum::message! {
    /// Distance of two fingers.
    pub struct Opening = "acme/Opening" {
        /// m
        pub width: f64,
    }
}

#[derive(Ports)]
struct GripperPorts {
    /// Commanded opening.
    command: In<Opening>,
    /// The opening, written on change.
    opening: Out<Opening>,
}

/// Opens and closes at once.
struct Gripper(GripperPorts);

impl Gripper {
    fn new(interface: &mut Interface) -> Self {
        Self(interface.ports())
    }
}

impl Component for Gripper {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(command) = cycle.read(self.0.command).new().cloned() {
            cycle.write(self.0.opening, command);
        }
        Ok(())
    }
}

/// Finds no path.
struct Hesitant;

impl Planner for Hesitant {
    fn plan(&mut self, _: &Grid, _: &Pose, _: &Pose) -> Result<PlannedPath, NoPath> {
        Err(NoPath::Unreachable { explored: 0 })
    }
}

/// Every file is an empty hall.
struct Hall;

impl MapFormat for Hall {
    fn endings(&self) -> &'static [&'static str] {
        &[".hall"]
    }

    fn load(&self, source: &MapSource<'_>, _: &MapSettings) -> Result<Map, MapError> {
        source.bytes()?;
        let layout = GridLayout::new(1.0, 10, 10, Pose::identity()).unwrap();
        Ok(Map {
            grid: Grid::new(layout, FREE),
            points: Vec::new(),
            origin: None,
            notes: Vec::new(),
        })
    }
}

/// A bus within the process.
fn connect(broker: &BrokerAddress) -> Result<Arc<dyn Bus>, BusError> {
    static BUS: LazyLock<LocalBus> = LazyLock::new(LocalBus::new);
    if broker.url == "inside://nowhere" {
        let reason = "there is nothing".to_owned();
        return Err(BusError::Disconnected { reason });
    }
    Ok(Arc::new(BUS.clone()))
}

/// Moves the gripper to its reference position.
#[derive(clap::Args)]
struct Home {
    /// Closes it, too
    #[arg(long)]
    close: bool,
}

impl AppCommand for Home {
    const NAME: &'static str = "home";

    #[expect(clippy::print_stdout, reason = "a command prints")]
    fn run(self, app: &App) -> Exit {
        let components = app.build().catalogue().components();
        println!(
            "home, close = {}, {} components",
            self.close,
            components.len()
        );
        Exit::Ok
    }
}

fn app() -> App {
    App::standard()
        .name("acme", "7.0")
        .component("acme::Gripper", Gripper::new)
        .planner("hesitant", |_| Box::new(Hesitant))
        .map_format("hall", &Hall)
        .transport("inside", connect)
        .command::<Home>()
}

/// The program, if it is started as such.
#[test]
fn acme() {
    if let Ok(arguments) = std::env::var(ARGUMENTS) {
        let exit = app().run(std::iter::once("acme").chain(arguments.lines()));
        std::process::exit(match exit {
            Exit::Ok => 0,
            Exit::Findings => 1,
            Exit::Usage => 2,
            Exit::Fault => 3,
            Exit::Undecided => 4,
        });
    }
}

/// Runs the program in a folder. Returns its exit code and what it printed.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["app::acme", "--exact", "--nocapture", "--test-threads=1"])
        .env(ARGUMENTS, arguments.join("\n"))
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

const COMPOSITE: &str = r#"schema = "composite/1"

[composite]
name = "cell"

[components.Gripper]
implementation = { rust = "acme::Gripper" }
activity  = { period_ms = 10 }
subscribe = { command = "acme/Opening" }
publish   = { opening = "acme/Opening" }

[components.Coordinator]
implementation = { asm = "cell.asm" }
task      = { period_ms = 50 }
subscribe = { opening = "acme/Opening" }
publish   = { command = "acme/Opening" }

[components.Coordinator.bind.monitored]
opening = { topic = "opening", receive = "last", field = "width", none = 0.0 }

[components.Coordinator.bind.out]
command = { topic = "command", field = "width", publish = "on_change" }

[[promote]]
topic = "opening"
as    = "opening"
"#;

const SPECIFICATION: &str = "asm cell
//@Final ARRIVED
import StandardLibrary

signature:
	enum domain Mode = {OPENING | ARRIVED}
	monitored opening: Real
	out command: Real
	controlled mode: Mode

definitions:
	main rule r_Main =
		if mode = OPENING then
			par
				command := 0.08
				if opening = 0.08 then mode := ARRIVED endif
			endpar
		endif

default init s0:
	function mode = OPENING
";

fn cell() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.composite.toml"), COMPOSITE).unwrap();
    std::fs::write(folder.path().join("cell.asm"), SPECIFICATION).unwrap();
    folder
}

#[test]
fn a_component_of_the_program_is_checked_described_and_run() {
    let cell = cell();
    let (code, text) = run(cell.path(), &["check", "cell.composite.toml", "cell.asm"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("no findings"), "{text}");
    let (code, text) = run(cell.path(), &["describe", "cell.composite.toml"]);
    assert!(code == Some(0) && text.contains("acme/Opening"), "{text}");
    let (code, text) = run(cell.path(), &["run", "cell.composite.toml"]);
    assert!(code == Some(0) && text.contains("ARRIVED"), "{text}");
    let (code, text) = run(
        cell.path(),
        &["run", "cell.composite.toml", "--clock", "wall"],
    );
    assert!(code == Some(0) && text.contains("ARRIVED"), "{text}");
    let wrong = COMPOSITE.replace(
        "command = \"acme/Opening\" }\npublish   = { opening",
        "comand = \"acme/Opening\" }\npublish   = { opening",
    );
    std::fs::write(cell.path().join("cell.composite.toml"), wrong).unwrap();
    let (code, text) = run(cell.path(), &["check", "cell.composite.toml"]);
    assert!(
        code == Some(1) && text.contains("did you mean `command`"),
        "{text}"
    );
}

#[test]
fn a_transport_of_the_program_carries_a_system() {
    let cell = cell();
    let run = |url| run(cell.path(), &["run", "cell.composite.toml", "--bus", url]);
    let (code, text) = run("inside://here");
    assert!(code == Some(0) && text.contains("ARRIVED"), "{text}");
    let (code, text) = run("inside://nowhere");
    assert!(
        code != Some(0) && text.contains("inside://nowhere") && text.contains("there is nothing"),
        "{text}"
    );
}

#[test]
fn a_planner_and_a_map_format_of_the_program_are_used() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("works.hall"), "a hall").unwrap();
    let composite = r#"schema = "composite/1"

[composite]
name = "hall"

[components.Maps]
implementation = { rust = "nav::MapServer" }
task       = { period_ms = 100 }
properties = { source = "works.hall", place = "works" }

[components.Planner]
implementation = { rust = "nav::TrajectoryPlanner" }
task       = { period_ms = 100 }
properties = { algorithm = "hesitant" }
"#;
    std::fs::write(folder.path().join("hall.composite.toml"), composite).unwrap();
    let arguments = ["run", "hall.composite.toml", "--for", "1"];
    let (code, text) = run(folder.path(), &arguments);
    assert!(code == Some(0), "{text}");
    let unknown = composite.replace("hesitant", "bold");
    std::fs::write(folder.path().join("hall.composite.toml"), unknown).unwrap();
    let (code, text) = run(folder.path(), &["check", "hall.composite.toml"]);
    assert!(code == Some(1) && text.contains("hesitant"), "{text}");
}

#[test]
fn a_command_of_the_program_is_one_of_its_commands() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text) = run(folder.path(), &["home", "--close"]);
    assert!(
        code == Some(0) && text.contains("home, close = true, 14 components"),
        "{text}"
    );
    let (code, text) = run(folder.path(), &["--help"]);
    assert!(code == Some(0) && text.contains("home"), "{text}");
    assert!(
        text.contains("Moves the gripper to its reference position"),
        "{text}"
    );
    let (code, text) = run(folder.path(), &["--version"]);
    assert!(code == Some(0) && text.contains("acme 7.0"), "{text}");
    let (code, text) = run(folder.path(), &["home", "--open"]);
    assert!(code == Some(2) && text.contains("--open"), "{text}");
}

#[test]
fn additions_that_contradict_each_other_are_named() {
    asmotion_datum::message! {
        /// Another type of the same name.
        pub struct OtherOpening = "acme/Opening" {
            /// mm
            pub millimetres: u32,
        }
    }
    let twice = app()
        .component("acme::Gripper", Gripper::new)
        .message::<OtherOpening>()
        .command::<Home>();
    assert_eq!(twice.run(["acme", "schema"]), Exit::Usage);
    let problems = twice.problems();
    assert_eq!(problems.len(), 3, "{problems:#?}");
    assert!(problems[0].contains("component `acme::Gripper` is registered twice"));
    assert!(problems[1].contains("message `acme/Opening` is registered with different fields"));
    assert!(problems[2].contains("command `home` is registered twice"));
    assert!(app().problems().is_empty());
}
