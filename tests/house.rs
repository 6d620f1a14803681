//! The floor plan: which crate may use which. Arrows fall, none climbs.

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::collections::BTreeSet;
use std::process::Command;

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
    &["engine-bus-amqp", "engine-gateway"],
    &["engine-component"],
    &["engine-bridge", "engine-coordinator", "engine-mqueue"],
    &["engine-assembly"],
    &["engine-scdl", "engine-drawing", "engine-remote"],
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

/// Every crate that a crate is built from, as `cargo tree` says.
fn built_from(package: &str) -> BTreeSet<String> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "-e", "normal", "--prefix", "none", "--offline"])
        .args(["--locked", "-p", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo tree");
    let text = String::from_utf8(tree.stdout).expect("text");
    let names = text.lines().filter_map(|line| line.split(' ').next());
    names.map(str::to_owned).collect()
}

#[test]
fn j5_the_core_is_built_without_any_transport() {
    // begins of words in the names of crates
    const TRANSPORTS: [&str; 8] = [
        "amqp", "lapin", "rabbit", "ros", "rcl", "corba", "tokio", "hyper",
    ];
    let is_transport = |name: &str| {
        let mut words = name.split(['-', '_']);
        words.any(|word| {
            TRANSPORTS
                .iter()
                .any(|transport| word.starts_with(transport))
        })
    };
    for core in [
        "engine-bus",
        "engine-component",
        "engine-coordinator",
        "engine-bridge",
        "engine-assembly",
        "robot-components",
    ] {
        let used = built_from(core);
        assert!(used.contains("engine-datum"), "{core}: {used:?}");
        let found: Vec<_> = used.iter().filter(|name| is_transport(name)).collect();
        assert!(found.is_empty(), "{core} is built from {found:?}");
    }
    let amqp = built_from("engine-bus-amqp");
    assert!(amqp.iter().any(|name| is_transport(name)), "{amqp:?}");
}

/// Another back end is another crate beside `engine-bus-amqp`: who joins systems names it, and nobody below.
#[test]
fn j6_back_ends_are_named_only_where_systems_are_joined_and_pass_one_suite() {
    let arrows = arrows();
    let knowing = arrows.iter().filter(|(_, to)| to == "engine-bus-amqp");
    let knowing: BTreeSet<&str> = knowing.map(|(from, _)| &**from).collect();
    assert_eq!(knowing, BTreeSet::from(["asmotion", "engine-remote"]));
    for suite in [
        "engine/bus/tests/local.rs",
        "engine/bus/amqp/tests/rabbitmq/contract.rs",
    ] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(suite);
        let text = std::fs::read_to_string(path).expect(suite);
        assert!(text.contains("contract::violations("), "{suite}");
    }
}
