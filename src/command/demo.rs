//! `asmotion demo`: a simulated rover is coordinated to its goal.

use asmotion_datum::Datum;
use clap::{Args, ValueEnum};
use std::path::Path;

use super::run::{MissionArguments, virtual_clock};
use crate::build::Build;
use crate::exit::Exit;
use crate::mission::Mission;
use crate::terminal::TerminalOutput;

/// Files of the demo, embedded so that the binary needs no others.
const FILES: &[(&str, &str)] = &[
    (
        "navigation.composite.toml",
        include_str!("../../specs/navigation/navigation.composite.toml"),
    ),
    (
        "navigate.asm",
        include_str!("../../specs/navigation/navigate.asm"),
    ),
    (
        "maps/office.geojson",
        include_str!("../../specs/navigation/maps/office.geojson"),
    ),
];

/// Runs a mission in which a specification coordinates a simulated rover.
#[derive(Args)]
pub struct Demo {
    /// Virtual seconds per second of real time; 0 is as fast as possible [default: 8, or 1 with a dashboard]
    #[arg(long)]
    speed: Option<f64>,

    /// Opens the dashboard in a browser, from which the rover can be sent to other goals; Ctrl-C ends the demo
    #[arg(long)]
    open: bool,

    /// Obstacles that the map does not show
    #[arg(long, value_enum, default_value_t = DemoWorld::Blocked)]
    world: DemoWorld,

    #[command(flatten)]
    common: MissionArguments,
}

/// Obstacles that the map does not show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DemoWorld {
    /// None
    Plain,
    /// Obstacles that can be passed
    Cluttered,
    /// An obstacle that closes the corridor while the rover is in it
    Blocked,
}

impl DemoWorld {
    /// The obstacles, as a value of the property `World.obstacles`.
    fn obstacles(self) -> &'static str {
        match self {
            Self::Plain => "[]",
            Self::Cluttered => CLUTTERED,
            Self::Blocked => BLOCKED_CORRIDOR,
        }
    }
}

const CLUTTERED: &str = r#"[
    { "at_s": 0.0, "disc": [14.5, 7.3, 0.25] },
    { "at_s": 0.0, "disc": [19.0, 6.6, 0.25] },
    { "at_s": 0.0, "disc": [23.5, 7.4, 0.25] }
]"#;

/// Obstacles that close the corridor of the demo, and one on the detour.
pub const BLOCKED_CORRIDOR: &str = r#"[
    { "at_s": 0.0, "disc": [20.0, 12.8, 0.25] },
    { "at_s": 12.0, "block": [17.0, 7.0, 0.4, 2.0, 0.0] }
]"#;

impl Demo {
    pub fn run(mut self, build: &Build, terminal: &mut TerminalOutput) -> Exit {
        let folder = match unpack() {
            Ok(folder) => folder,
            Err(error) => {
                terminal.error(format_args!(
                    "cannot unpack the demo into a temporary folder: {error}"
                ));
                return Exit::Usage;
            }
        };
        let composite = folder.path().join(FILES[0].0);
        let mut mission = Mission::with_build(build, composite.display().to_string());
        if let Err(problem) = self.prepare(&mut mission) {
            terminal.error(problem);
            return Exit::Usage;
        }
        let obstacles: Datum =
            asmotion_datum::json::decode(self.world.obstacles()).unwrap_or_default();
        mission
            .properties
            .push(("World".to_owned(), "obstacles".to_owned(), obstacles));
        self.common.run("the navigation demo", mission, terminal)
    }

    /// Sets the clock and the dashboard.
    fn prepare(&mut self, mission: &mut Mission) -> Result<(), String> {
        if self.open {
            // the rover is simulated
            self.common.dashboard.request_control();
            mission.until = Some(Vec::new());
            mission.unless = Some(Vec::new());
            if self.common.limit.is_none() {
                mission.limit = None;
            }
        }
        let usual = if self.common.dashboard.is_requested() {
            1.0
        } else {
            8.0
        };
        mission.clock = virtual_clock(self.speed.unwrap_or(usual))?;
        mission.dashboard = self.common.dashboard(None, self.open)?;
        Ok(())
    }
}

/// Writes the demo's files into a temporary folder, which is deleted at the end of the demo.
fn unpack() -> std::io::Result<tempfile::TempDir> {
    let folder = tempfile::Builder::new()
        .prefix("asmotion-demo-")
        .tempdir()?;
    for (name, text) in FILES {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new("")))?;
        std::fs::write(path, text)?;
    }
    Ok(folder)
}
