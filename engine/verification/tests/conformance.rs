//! Components against their protocols: what components do in simulated runs is what their protocols allow, and what the protocols
//! allow occurs.

use crate::scenarios::{Conformance, Dice, Scenario, observed};
use crate::support::{Files, in_repository};

const YOUBOT: &str = "specs/youbot/youbot.composite.toml";
const BALL_TRACKER: &str = "specs/ball_tracker/ball_tracker.composite.toml";
const ALLOCATION: &str = "specs/allocation/allocation.composite.toml";
const NAVIGATION: &str = "specs/navigation/navigation.composite.toml";

/// Events that no scenario provokes, with the reason.
const NOT_PROVOKED: &[(&str, &str, &str, &str)] = &[
    (
        "nav::CollisionMonitor",
        "event",
        "CONTACT",
        "the monitor stops the rover in time, and the world does not let it into an obstacle",
    ),
    (
        "nav::TrajectoryPlanner",
        "answer",
        "BAD_ALGORITHM",
        "an application registers its planners at start, and the property accepts only their names",
    ),
    (
        "nav::TrajectoryPlanner",
        "answer",
        "BAD_MAP",
        "the coordinator sends the map of the map server, which is a grid",
    ),
];

const PLACES: [(f64, f64); 8] = [
    (4.2, 15.6),
    (10.6, 16.6),
    (21.1, 15.2),
    (8.4, 9.8),
    (9.2, 4.2),
    (15.5, 3.4),
    (20.6, 3.0),
    (3.0, 7.0),
];

/// A rover that drives to one place after the other among obstacles, with everything that an operator can do.
pub fn drive(seed: u64) -> Scenario {
    let mut dice = Dice(seed);
    let mut script = Vec::new();
    let mut at = 1.0;
    while at < 75.0 {
        let (x, y) = *dice.one_of(&PLACES);
        let order = match dice.below(10) {
            0 => "cancel".to_owned(),
            1 => "estop on".to_owned(),
            // the inside of a bench, and a place outside of the map
            2 => "goal 0.7 17.0".to_owned(),
            3 => "goal 100 100".to_owned(),
            _ => format!("goal {x} {y}"),
        };
        let ends_stop = order == "estop on";
        script.push(format!("{at:.2} {order}"));
        at += 0.05 + dice.below(1200) as f64 / 100.0 * f64::from(u32::from(dice.below(4) > 0));
        if ends_stop {
            script.push(format!("{at:.2} estop off"));
        }
    }
    let mut obstacles = Vec::new();
    for _ in 0..dice.below(4) {
        let at = 2 + dice.below(50);
        obstacles.push(match dice.below(3) {
            // a hand's breadth in front of the rover, which cannot brake in time
            0 => format!(r#"{{"at_s": {at}, "until_s": {}, "frame": "robot", "disc": [0.31, 0.0, 0.05]}}"#, at + 6),
            // a wall across the way
            1 => format!(r#"{{"at_s": {at}, "until_s": {}, "frame": "robot", "block": [1.5, 0.0, 0.3, 4.0, 0.0]}}"#, at + 15),
            // something to evade
            _ => format!(r#"{{"at_s": {at}, "frame": "robot", "disc": [2.5, 0.1, 0.2]}}"#),
        });
    }
    let lines: Vec<String> = script.iter().map(|line| format!("{line:?}")).collect();
    Scenario {
        composite: NAVIGATION,
        settings: settings(&[("seed", &seed.to_string())]),
        properties: vec![
            ("Operator", "script", format!("[{}]", lines.join(", "))),
            ("World", "obstacles", format!("[{}]", obstacles.join(", "))),
        ],
        seconds: 80,
        seed,
        ..Scenario::default()
    }
}

/// Properties of the composite; its files are beside it, wherever the test runs.
fn settings(given: &[(&str, &str)]) -> Vec<(String, String)> {
    let maps = in_repository("specs/navigation/maps");
    let plan = format!("{maps}/office.geojson");
    let files = [("maps", maps.as_str()), ("plan", &plan)].into_iter();
    let files = files.filter(|(name, _)| !given.iter().any(|(known, _)| known == name));
    let all = files.chain(given.iter().copied());
    all.map(|(name, value)| (name.to_owned(), value.to_owned()))
        .collect()
}

/// Runs of navigation that end early: without a map, and from places from which no path leads away.
fn hindered() -> Vec<Scenario> {
    let run = |settings: &[(&str, &str)], obstacles: &str| Scenario {
        composite: NAVIGATION,
        settings: self::settings(settings),
        properties: vec![("World", "obstacles", obstacles.to_owned())],
        seconds: 20,
        ..Scenario::default()
    };
    let broken = in_repository("engine/verification/tests/maps");
    vec![
        run(&[("place", "nowhere")], "[]"),
        run(&[("maps", &broken), ("place", "broken")], "[]"),
        // the corridor is closed while the rover is in it
        Scenario {
            seconds: 40,
            ..run(
                &[],
                r#"[{"at_s": 12.0, "block": [15.0, 7.0, 0.4, 2.0, 0.0]}]"#,
            )
        },
        // a pillar appears a hand's breadth in front of the rover
        run(
            &[],
            r#"[{"at_s": 8.0, "frame": "robot", "disc": [0.31, 0.0, 0.05]}]"#,
        ),
        // in the bench of the lab
        run(&[("start", "[0.7, 17.0, 0.0]")], "[]"),
        // the only door of the server room is closed
        run(
            &[("start", "[4.2, 9.0, -1.57]")],
            r#"[{"block": [4.25, 8.0, 2.0, 0.4, 0.0]}]"#,
        ),
    ]
}

fn navigation(seeds: std::ops::Range<u64>) -> Vec<Scenario> {
    seeds.map(drive).chain(hindered()).collect()
}

fn other(composite: &'static str, seeds: std::ops::Range<u64>) -> Vec<Scenario> {
    let run = |seed| Scenario {
        composite,
        seconds: 60,
        seed,
        // the driver has an error from the beginning, or falls silent
        properties: match (composite, seed) {
            (YOUBOT, 1) => vec![("Driver/youBotDriver", "faults", "[0, 1]".to_owned())],
            _ => Vec::new(),
        },
        stops: match (composite, seed) {
            (YOUBOT, 2) => vec![(3_000, "Driver/youBotDriver")],
            _ => Vec::new(),
        },
        ..Scenario::default()
    };
    seeds.map(run).collect()
}

/// All protocols allow what was observed, and every event was observed except those that are listed: implementation, function,
/// value and the reason.
pub fn assert_allowed(
    found: &Conformance,
    expected: &[&str],
    not_provoked: &[(&str, &str, &str, &str)],
) {
    let names: Vec<&str> = found.keys().map(String::as_str).collect();
    assert_eq!(names, expected);
    for (name, found) in found {
        assert_eq!(found.deviation, None, "{name}");
    }
    for (name, found) in found {
        assert!(found.cycles > 100, "{name}: {} cycles", found.cycles);
        let missing = found.never_sent();
        let missing: Vec<(&str, &str)> = missing
            .iter()
            .map(|it| (it.function.as_str(), it.value.as_str()))
            .collect();
        let listed = not_provoked.iter().filter(|(of, ..)| of == name);
        let listed: Vec<(&str, &str)> = listed
            .map(|(_, function, value, _)| (*function, *value))
            .collect();
        assert_eq!(missing, listed, "{name}: events that never occurred");
    }
}

#[test]
fn components_of_navigation_do_what_their_protocols_say() {
    let found = observed(&navigation(0..6), &Files::default());
    assert_allowed(
        &found,
        &[
            "nav::CollisionMonitor",
            "nav::MapServer",
            "nav::Operator",
            "nav::TrajectoryAdapter",
            "nav::TrajectoryFollower",
            "nav::TrajectoryPlanner",
            "nav::sim::LaserDriver",
            "nav::sim::RoverDriver",
        ],
        NOT_PROVOKED,
    );
}

#[test]
fn components_with_a_specification_do_what_their_protocols_say() {
    let files = Files::default();
    for (composite, components) in [
        (YOUBOT, &["Driver/SCAyouBotDriver"][..]),
        (BALL_TRACKER, &["Camera", "Tracker"]),
        (ALLOCATION, &["Robot1", "Robot2"]),
    ] {
        let found = observed(&other(composite, 0..4), &files);
        assert_allowed(&found, components, NOT_PROVOKED);
    }
}

/// A changed protocol, with the folder and the change: what the component does is not allowed any more.
const MUTANTS: &[(&str, &str, &str)] = &[
    ("follower", "event := REACHED", "event := HALTED"),
    (
        "follower",
        "order = FOLLOW and not (isDef(permit) and not permit)",
        "order = FOLLOW and isDef(permit) and not permit",
    ),
    ("follower", "order := STOP", "order := NONE"),
    ("follower", "{FOLLOW, STOP, DONE}", "{STOP, DONE}"),
    (
        "follower",
        "event.plan = path.header.stamp",
        "event.stamp = path.header.stamp",
    ),
    ("adapter", "case HOLD: adapted := false", "case HOLD: skip"),
    (
        "adapter",
        "case DRIVE: adapted := true",
        "case DRIVE: adapted := false",
    ),
    ("adapter", "event := BLOCKED", "skip"),
    ("adapter", "route := UNDERWAY", "route := NOWHERE"),
    ("rover", "event := CONTACT", "skip"),
    (
        "rover",
        "commanded and not touching",
        "not commanded and not touching",
    ),
    ("rover", "if $leaves then touching := false endif", "skip"),
    ("collision-monitor", "if scan then r_feel[] endif", "skip"),
    (
        "collision-monitor",
        "$touches and not touched",
        "$touches and touched",
    ),
    (
        "collision-monitor",
        "if $less then twist := true endif",
        "skip",
    ),
    ("laser", "truth and known", "truth and not known"),
    ("laser", "scan := true", "skip"),
];

#[test]
fn a_changed_protocol_is_found() {
    for (component, from, to) in MUTANTS {
        let path = format!("components/{component}/protocol.asm");
        let files = Files::default().change(&path, from, to);
        let found = crate::disorder::observed_alone(component, &files);
        let is_found = found.values().any(|it| it.deviation.is_some());
        assert!(is_found, "{path}: `{from}` as `{to}` was not noticed");
    }
}

#[test]
fn an_event_that_never_occurs_is_found() {
    let path = "components/rover/protocol.asm";
    let files = Files::default()
        .change(path, "{CONTACT}", "{CONTACT | FIRE}")
        .change(
            path,
            "event := CONTACT",
            "choose $code in Code do event := $code",
        );
    let found = crate::disorder::observed_alone("rover", &files);
    let rover = &found["nav::sim::RoverDriver"];
    assert_eq!(rover.deviation, None);
    let missing: Vec<String> = rover.never_sent().into_iter().map(|it| it.value).collect();
    assert_eq!(missing, ["FIRE"]);
}

/// A changed component: composite, file and change.
const COMPONENT_MUTANTS: &[(&str, &str, &str, &str)] = &[
    (
        ALLOCATION,
        "specs/allocation/robot.asm",
        "if rest = 1 then lowBattery := false endif",
        "skip",
    ),
    (
        ALLOCATION,
        "specs/allocation/robot.asm",
        "down := true",
        "down := false",
    ),
    (
        ALLOCATION,
        "specs/allocation/robot.asm",
        "lowBattery := true",
        "down := true",
    ),
    (
        BALL_TRACKER,
        "specs/ball_tracker/camera.asm",
        "if warmth = 10 then",
        "if warmth = 10 and pan > 90.0 then",
    ),
    (
        BALL_TRACKER,
        "specs/ball_tracker/camera.asm",
        "case ON: par says := QUIET",
        "case ON: par says := READY",
    ),
    (
        BALL_TRACKER,
        "specs/ball_tracker/tracker.asm",
        "case REST: centred := false",
        "case REST: centred := true",
    ),
];

#[test]
fn a_changed_component_is_found() {
    for (composite, path, from, to) in COMPONENT_MUTANTS {
        let files = Files::default().change(path, from, to);
        let found = observed(&other(composite, 0..2), &files);
        let is_found = found
            .values()
            .any(|it| it.deviation.is_some() || !it.never_sent().is_empty());
        assert!(is_found, "{path}: `{from}` as `{to}` was not noticed");
    }
}
