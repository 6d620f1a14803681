//! The floor plan: which crate may use which. Arrows fall, none climbs.

use cargo_metadata::{DependencyKind, MetadataCommand};

/// The rooms from the ground up; a room uses only rooms below it.
const FLOORS: &[&[&str]] = &[
    // the language
    &["asm-source", "asm-value"],
    &["asm-syntax", "asm-stdlib"],
    &["asm-hir"],
    &["asm-ir"],
    &["asm-machine"],
    &["asm-simulate"],
    &["asm-lang"],
    &["asm-properties"],
    // the engine
    &["engine-datum", "engine-connection", "engine-bus-broker"],
    &["engine-bus"],
    &["engine-bus-amqp"],
    &["engine-component"],
    &["engine-bridge", "engine-coordinator", "engine-mqueue"],
    &["engine-assembly"],
    &["engine-scdl", "engine-drawing"],
    // the robot
    &["robot-messages"],
    &["robot-geometry"],
    &[
        "robot-map",
        "robot-planner",
        "robot-follower",
        "robot-adapter",
        "robot-rover",
        "robot-laser",
        "robot-youbot",
    ],
    &["robot-world", "robot-operator"],
    &["robot-components"],
    // the front door
    &["asmotion"],
];

fn floor(package: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&package))
}

/// Every arrow between two of our crates, development ones left out.
fn arrows() -> Vec<(String, String)> {
    let metadata = MetadataCommand::new()
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let mut arrows = Vec::new();
    for package in &metadata.packages {
        for dependency in &package.dependencies {
            if dependency.path.is_some() && dependency.kind == DependencyKind::Normal {
                arrows.push((package.name.to_string(), dependency.name.clone()));
            }
        }
    }
    arrows
}

#[test]
fn every_crate_has_its_floor() {
    let metadata = MetadataCommand::new()
        .no_deps()
        .exec()
        .expect("cargo metadata");
    for package in &metadata.packages {
        assert!(
            floor(&package.name).is_some(),
            "{} stands on no floor: add it to FLOORS",
            package.name
        );
    }
}

#[test]
fn no_arrow_climbs() {
    for (from, to) in arrows() {
        assert!(
            floor(&from) > floor(&to),
            "{from} uses {to}, which is not below it"
        );
    }
}

#[test]
fn components_know_the_cycle_and_the_data_alone() {
    for (from, to) in arrows()
        .iter()
        .filter(|(from, _)| from.starts_with("robot-"))
    {
        let allowed = to.starts_with("robot-") || to == "engine-component" || to == "engine-datum";
        assert!(allowed, "{from} uses {to}");
    }
}

#[test]
fn the_engine_knows_no_robot_and_the_language_knows_no_engine() {
    for (from, to) in arrows() {
        let engine_knows_robot = from.starts_with("engine-") && to.starts_with("robot-");
        let language_looks_up = from.starts_with("asm-") && !to.starts_with("asm-");
        assert!(
            !engine_knows_robot && !language_looks_up,
            "{from} uses {to}"
        );
    }
}
