//! Constraints (`INVAR`) that read inputs: verification assumes them, and every step of a run checks them.

use super::{file, run};

const DOOR: &str = "asm door
import StandardLibrary
import CTLLibrary
signature:
  enum domain Side = {LEFT | RIGHT}
  monitored opened: Boolean
  monitored closed: Boolean
  controlled side: Side
definitions:
  INVAR not (opened and closed)
  CTLSPEC ag(not (opened and closed))
  main rule r_Main = if side = LEFT then side := RIGHT else side := LEFT endif
default init s0:
  function side = LEFT
";

/// Opens the door while it is closed in the second step.
const SCRIPT: &str = "[default]
opened = false
closed = false

[[step]]

[[step]]
opened = true
closed = true
";

const SCENARIO: &str = "scenario contradiction
load door.asm
set opened := false;
set closed := true;
step
set opened := true;
step
";

/// Both inputs are the operator's e-stop, which it presses after a second.
const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "doors"
[components.Operator]
implementation = { rust = "nav::Operator" }
activity = { period_ms = 100 }
properties = { script = ["1.0 estop on"] }
publish = { estop = "std_msgs/Bool" }
[components.Door]
implementation = { asm = "door.asm" }
activity = { period_ms = 100 }
subscribe = { estop = "std_msgs/Bool" }
bind.monitored.opened = { topic = "estop", field = "data", none = false }
bind.monitored.closed = { topic = "estop", field = "data", none = false }
verify = { ctl = true, ltl = true, refuse_start_on_failure = true }
"#;

/// Writes the specification beside a file; returns the paths of both.
fn beside(name: &str, text: &str) -> (tempfile::TempDir, String, String) {
    let (folder, path) = file(name, text);
    let door = folder.path().join("door.asm");
    std::fs::write(&door, DOOR).unwrap();
    let door = door.to_str().unwrap().to_owned();
    (folder, path, door)
}

const REASON: &str = "the constraint `not (opened and closed)` does not hold in step";

#[test]
fn a_simulation_stops_at_inputs_that_verification_excludes() {
    let (_folder, script, door) = beside("door.env.toml", SCRIPT);
    let (code, out, err) = run(&["sim", &door, "--env", &script]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(
        err.contains("error[R014]") && err.contains(&format!("{REASON} 2")),
        "{out}{err}"
    );
    assert!(
        err.contains("what was verified under this constraint"),
        "{out}{err}"
    );
    // the reference tools ignore it
    let (code, out, err) = run(&["sim", &door, "--env", &script, "--compat", "asmeta"]);
    assert_eq!(code, 0, "{out}{err}");
}

#[test]
fn a_constraint_reads_inputs_through_definitions_and_one_about_the_state_alone_is_not_checked() {
    let (_folder, script, door) = beside("door.env.toml", SCRIPT);
    let with = |changes: &[(&str, &str)]| {
        let mut text = DOOR.to_owned();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        std::fs::write(&door, text).unwrap();
        run(&["sim", &door, "--env", &script])
    };
    let (code, out, err) = with(&[
        (
            "  controlled side",
            "  derived jammed: Boolean\n  controlled side",
        ),
        (
            "  INVAR not (opened and closed)",
            "  function jammed = opened and closed\n  INVAR not jammed",
        ),
    ]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(
        err.contains("the constraint `not jammed` does not hold in step 2"),
        "{out}{err}"
    );
    let (code, out, err) = with(&[("INVAR not (opened and closed)", "INVAR side = LEFT")]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(
        err.contains("2 temporal properties, which runs do not check"),
        "{out}{err}"
    );
}

#[test]
fn a_scenario_fails_at_inputs_that_verification_excludes() {
    let (_folder, scenario, _) = beside("door.avalla", SCENARIO);
    let (code, out, err) = run(&["test", &scenario]);
    assert_eq!(code, 1, "{out}{err}");
    assert!(
        (out.clone() + &err).contains(&format!("{REASON} 2")),
        "{out}{err}"
    );
}

#[test]
fn a_run_whose_properties_are_verified_stops_where_their_assumption_is_wrong() {
    let (_folder, composite, _) = beside("doors.composite.toml", COMPOSITE);
    let arguments = ["run", &composite, "--for", "3"];
    let (code, out, err) = run(&arguments);
    assert_eq!(code, 3, "{out}{err}");
    assert!(
        !err.contains("W031") && !err.contains("does not start"),
        "{err}"
    );
    let fault = err.lines().find(|line| line.contains("fault of Door"));
    assert!(
        fault.is_some_and(|line| line.contains("R014")) && err.contains(REASON),
        "{out}{err}"
    );
    let (_, json, _) = run(&[&arguments[..], &["--json"]].concat());
    let mut events = json
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let fault = events
        .find(|event| event["type"] == "fault")
        .expect("a fault");
    assert_eq!(fault["component"], "Door");
    assert!(fault["fault"].as_str().unwrap().contains(REASON), "{fault}");
}
