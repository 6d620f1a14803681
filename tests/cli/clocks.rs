//! The composites of `specs` do the same on the wall clock as in virtual time, in any order of their components.

use super::run;
use std::collections::BTreeMap;
use std::path::Path;

/// The control states of each specification of a run, in order.
type ControlStates = BTreeMap<String, Vec<String>>;

/// Names of functions that contain a control state.
const CONTROL_STATES: &[&str] = &["mode", "state", "status(undef)"];

/// Runs a composite; returns the exit code and the control states.
fn control_states(clock: &str, composite: &str, arguments: &[&str]) -> (i32, ControlStates) {
    let command = ["run", composite, "--clock", clock, "--json"];
    let (code, out, err) = run(&[&command, arguments].concat());
    let mut states = ControlStates::new();
    for line in out.lines() {
        let event: serde_json::Value = serde_json::from_str(line).expect(line);
        if event["type"] != "step" {
            continue;
        }
        let component = event["component"].as_str().unwrap().to_owned();
        for update in event["step"]["updates"].as_array().unwrap() {
            let location = update["location"].as_str().unwrap();
            if CONTROL_STATES.contains(&location) && update["before"] != update["after"] {
                let after = update["after"].as_str().unwrap();
                let states = states.entry(component.clone()).or_default();
                states.push(format!("{location} = {after}"));
            }
        }
    }
    assert!(
        !states.is_empty(),
        "{composite} has no control state: {err}"
    );
    (code, states)
}

/// Runs a composite in both clocks, at the same time, until it reaches its end.
fn is_the_same_in_both_clocks(composite: &str, arguments: &[&str]) {
    let (real, simulated) = std::thread::scope(|scope| {
        let real = scope.spawn(|| control_states("wall", composite, arguments));
        let simulated = control_states("virtual", composite, arguments);
        (real.join().unwrap(), simulated)
    });
    assert_eq!(
        simulated.0, 0,
        "{composite} in virtual time: {:?}",
        simulated.1
    );
    assert_eq!(real.0, 0, "{composite} on the wall clock: {:?}", real.1);
    let components = |states: &ControlStates| states.keys().cloned().collect::<Vec<_>>();
    assert_eq!(components(&real.1), components(&simulated.1), "{composite}");
    for (component, simulated) in &simulated.1 {
        let real = &real.1[component];
        // the run ends between two steps of the other specifications
        let both = real.len().min(simulated.len());
        assert_eq!(real[..both], simulated[..both], "{composite}: {component}");
        assert!(
            real.len().abs_diff(simulated.len()) <= 1,
            "{composite}: {component}"
        );
    }
}

#[test]
fn c19_every_composite_goes_through_the_same_control_states_in_both_clocks() {
    let runs: [(&str, &[&str]); 4] = [
        ("navigation/navigation", &["--goal", "3,7"]),
        ("youbot/youbot", &["--until", "mode=IDLE"]),
        ("courier/courier", &["--until", "jobs=3"]),
        ("ball_tracker/ball_tracker", &["--until", "mode=DONE"]),
    ];
    std::thread::scope(|scope| {
        for (name, arguments) in runs {
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
