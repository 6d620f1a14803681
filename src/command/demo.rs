//! `asmotion demo`: a rover is coordinated to its goal, with nothing to install.

use asmotion_datum::Datum;
use clap::{Args, ValueEnum};
use std::path::Path;

use super::run::{Common, virtual_clock};
use crate::exit::Exit;
use crate::mission::Mission;
use crate::terminal::Terminal;

/// What the demo needs, so that the binary needs no other file.
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

/// Shows a rover being coordinated to its goal, in a simulated world.
#[derive(Args)]
pub struct Demo {
    /// Virtual seconds in one second of the wall; 0 is as fast as possible.
    #[arg(long, default_value_t = 8.0)]
    speed: f64,

    /// What the world has in store.
    #[arg(long, value_enum, default_value_t = World::Blocked)]
    world: World,

    #[command(flatten)]
    common: Common,
}

/// What the world has in store, beyond the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum World {
    /// Nothing but what the map shows.
    Plain,
    /// Things in the way that can be passed.
    Cluttered,
    /// The corridor is closed while the rover is in it.
    Blocked,
}

impl World {
    /// The obstacles that no map shows.
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

/// What closes the corridor of the demo, and something on the way around.
pub const BLOCKED_CORRIDOR: &str = r#"[
    { "at_s": 0.0, "disc": [20.0, 12.8, 0.25] },
    { "at_s": 12.0, "block": [17.0, 7.0, 0.4, 2.0, 0.0] }
]"#;

impl Demo {
    /// Runs it.
    pub fn run(self, terminal: &mut Terminal) -> Exit {
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
        let mut mission = Mission::new(composite.display().to_string());
        mission.clock = match virtual_clock(self.speed) {
            Ok(clock) => clock,
            Err(problem) => {
                terminal.error(problem);
                return Exit::Usage;
            }
        };
        let obstacles: Datum =
            asmotion_datum::json::decode(self.world.obstacles()).unwrap_or_default();
        mission
            .properties
            .push(("World".to_owned(), "obstacles".to_owned(), obstacles));
        self.common.run("the navigation demo", mission, terminal)
    }
}

/// Writes the demo's files into a temporary folder, which is removed when the demo is over.
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
