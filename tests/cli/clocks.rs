//! The composites of `specs` do the same on the wall clock as in virtual time, in any order of their components.

use super::run;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The values of each control state of each specification of a run, in order. The key is the component and the location.
type ControlStates = BTreeMap<(String, String), Vec<String>>;

/// Functions that contain a control state.
const CONTROL_STATES: &[&str] = &["mode", "state", "status", "tstate"];

/// The runs that reach the end of each composite of `specs`.
const RUNS: &[(&str, &[&str])] = &[
    (
        "allocation/allocation",
        // the last of the tasks
        &["--until", "tstate(TASK1)=DONE"],
    ),
    ("ball_tracker/ball_tracker", &["--until", "mode=DONE"]),
    ("courier/courier", &["--until", "jobs=3"]),
    ("navigation/navigation", &["--goal", "3,7"]),
    (
        "navigation/two_rovers",
        &[
            "--set",
            r#"Left/Operator.script=["1.0 goal 22.0 5.5 0.0"]"#,
            "--set",
            r#"Right/Operator.script=["1.0 goal 3.0 7.0 0.0"]"#,
        ],
    ),
    (
        "navigation/web",
        // a gateway needs the wall clock
        &["--goal", "3,7", "--http", "off"],
    ),
    ("youbot/youbot", &["--until", "mode=IDLE"]),
];

/// Composites that are not run in both clocks, with the reason.
const OTHERS: &[(&str, &str)] = &[
    (
        "fleet/fleet",
        "twenty rovers on the wall clock need more than two processors: `fleet` tests it in virtual time",
    ),
    (
        "fleet/rover",
        "a part of `fleet`, without others in its world",
    ),
    (
        "nav2/nav2",
        "nodes of ROS run on the wall clock: `nav2` tests it",
    ),
    (
        "youbot/youbot_driver",
        "a part of others, without a specification of its own",
    ),
];

/// Runs a composite to its end, within two minutes; returns the control states.
fn control_states(clock: &str, composite: &str, arguments: &[&str]) -> ControlStates {
    let command = ["run", composite, "--clock", clock, "--json", "--for", "120"];
    let (code, out, err) = run(&[&command, arguments].concat());
    let mut states = ControlStates::new();
    for line in out.lines() {
        let event: serde_json::Value = serde_json::from_str(line).expect(line);
        if event["type"] != "step" {
            continue;
        }
        let component = event["component"].as_str().unwrap();
        for update in event["step"]["updates"].as_array().unwrap() {
            let location = update["location"].as_str().unwrap();
            let function = location.split('(').next().unwrap();
            if CONTROL_STATES.contains(&function) && update["before"] != update["after"] {
                let key = (component.to_owned(), location.to_owned());
                let after = update["after"].as_str().unwrap().to_owned();
                states.entry(key).or_default().push(after);
            }
        }
    }
    assert!(
        !states.is_empty(),
        "{composite} has no control state: {err}"
    );
    let last: Vec<&str> = out.lines().rev().take(20).collect();
    assert_eq!(
        code, 0,
        "{composite} on the {clock} clock: {states:?}\n{err}\nthe last lines, newest first: {last:#?}"
    );
    states
}

/// Runs a composite in both clocks, at the same time, until it reaches its end.
fn is_the_same_in_both_clocks(composite: &str, arguments: &[&str]) {
    let (real, simulated) = std::thread::scope(|scope| {
        let real = scope.spawn(|| control_states("wall", composite, arguments));
        let simulated = control_states("virtual", composite, arguments);
        (real.join().unwrap(), simulated)
    });
    let locations = |states: &ControlStates| states.keys().cloned().collect::<Vec<_>>();
    assert_eq!(locations(&real), locations(&simulated), "{composite}");
    for (location, simulated) in &simulated {
        let real = &real[location];
        // the run ends between two steps of the other specifications
        let both = real.len().min(simulated.len());
        assert_eq!(real[..both], simulated[..both], "{composite}: {location:?}");
        assert!(
            real.len().abs_diff(simulated.len()) <= 1,
            "{composite}: {location:?}"
        );
    }
}

/// The composites below `specs`, without their suffix.
fn composites() -> BTreeSet<String> {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs");
    let folders = std::fs::read_dir(specs).unwrap();
    let folders = folders
        .map(|it| it.unwrap().path())
        .filter(|it| it.is_dir());
    let files = folders.flat_map(|folder| {
        let name = folder.file_name().unwrap().to_str().unwrap().to_owned();
        let files = std::fs::read_dir(folder).unwrap();
        files.filter_map(move |file| {
            let file = file.unwrap().file_name().into_string().unwrap();
            Some(format!("{name}/{}", file.strip_suffix(".composite.toml")?))
        })
    });
    files.collect()
}

#[test]
fn c19_every_composite_goes_through_the_same_control_states_in_both_clocks() {
    let run = RUNS.iter().map(|(name, _)| *name);
    let known: BTreeSet<String> = run
        .chain(OTHERS.iter().map(|(name, _)| *name))
        .map(str::to_owned)
        .collect();
    assert_eq!(
        composites(),
        known,
        "composites without a run in both clocks"
    );
    std::thread::scope(|scope| {
        for (name, arguments) in RUNS {
            scope.spawn(move || {
                is_the_same_in_both_clocks(&format!("specs/{name}.composite.toml"), arguments);
            });
        }
    });
}

#[test]
fn the_order_of_components_in_the_file_is_without_effect() {
    let folder = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/courier");
    for file in std::fs::read_dir(&from).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    let composite = folder.path().join("courier.composite.toml");
    let text = std::fs::read_to_string(&composite).unwrap();
    let reversed = reverse_components(&text);
    assert_ne!(reversed, text);
    std::fs::write(&composite, reversed).unwrap();
    is_the_same_in_both_clocks(composite.to_str().unwrap(), &["--until", "jobs=3"]);
}

/// Reverses the order of the components of a composite file.
fn reverse_components(text: &str) -> String {
    let name = |line: &str| {
        let table = line.strip_prefix("[components.")?;
        let end = table.find(['.', ']'])?;
        Some(table[..end].to_owned())
    };
    let (mut others, mut components) = (String::new(), Vec::<(String, String)>::new());
    let mut current = None;
    for line in text.lines() {
        if line.starts_with('[') {
            current = name(line);
        }
        let table = match &current {
            None => &mut others,
            Some(current) => {
                if components.last().is_none_or(|(last, _)| last != current) {
                    components.push((current.clone(), String::new()));
                }
                &mut components.last_mut().unwrap().1
            }
        };
        table.push_str(line);
        table.push('\n');
    }
    let components = components.iter().rev().map(|(_, text)| text.as_str());
    others + &components.collect::<String>()
}
