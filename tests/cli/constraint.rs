//! Constraints (`INVAR`) that read inputs: verification assumes them, and every step of a run checks them.

use super::{file, run};
use std::collections::BTreeSet;

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
        !err.contains("C201") && !err.contains("does not start"),
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

#[test]
fn a_random_simulation_draws_inputs_that_verification_considers() {
    let (_folder, door) = file("door.asm", DOOR);
    for seed in ["1", "2", "3"] {
        let arguments = ["sim", &door, "--steps", "100", "--seed", seed, "--json"];
        let (code, out, err) = run(&arguments);
        assert_eq!(code, 0, "{out}{err}");
        let mut seen = BTreeSet::new();
        for line in out.lines().take(100) {
            let step: serde_json::Value = serde_json::from_str(line).unwrap();
            seen.insert(step["inputs"].to_string());
        }
        // if it is not opened, it does not matter whether it is closed
        let expected = [
            r#"{"closed":"false","opened":"true"}"#,
            r#"{"opened":"false"}"#,
        ];
        assert!(seen.iter().eq(expected), "{seen:?}");
        assert_eq!(run(&arguments).1, out);
    }
    // what is held is given
    let lines = "set opened := true\nrun 20\nset closed := true\nstep\n";
    let mut command = super::asmotion();
    let command = command.args(["repl", &door, "--random"]);
    let output = command.write_stdin(lines).output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(text.contains(&format!("{REASON} 21")), "{text}");
    assert!(text.contains("[R014]"), "{text}");
}

#[test]
fn a_random_simulation_ends_where_no_inputs_satisfy_a_constraint() {
    let text = DOOR.replace(
        "INVAR not (opened and closed)",
        "INVAR side = LEFT or opened = closed\n  INVAR opened != closed",
    );
    let (folder, door) = file("door.asm", text);
    let trace = folder.path().join("door.trace").display().to_string();
    let (code, out, err) = run(&["sim", &door, "--trace", &trace]);
    assert_eq!(code, 3, "{out}{err}");
    for part in [
        "error[R024]: no inputs satisfy the constraints `side = LEFT or opened = closed`, `opened != closed` in step 2",
        "tried with all values that a random simulation draws: `opened`, `closed`",
    ] {
        assert!(err.contains(part), "{out}{err}");
    }
    let (_, json, _) = run(&["sim", &door, "--json"]);
    let fault: serde_json::Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
    assert_eq!(
        (&fault["type"], &fault["code"]),
        (&"fault".into(), &"R024".into()),
        "{json}"
    );
    // the trace has the step that failed; replayed, its inputs are given
    let recorded = std::fs::read_to_string(&trace).unwrap();
    assert!(
        recorded.contains("@step 2\nM ")
            && recorded.contains("\n@invariant pre ")
            && recorded.contains("\n@end INV\n"),
        "{recorded}"
    );
    let (code, out, err) = run(&["sim", &door, "--replay-inputs", &trace]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(err.contains("[R014]"), "{out}{err}");
}

/// The constraint is undef while the door is opened.
fn undefined() -> String {
    DOOR.replace(
        "INVAR not (opened and closed)",
        "INVAR isSeen(opened) or closed",
    )
    .replace(
        "  controlled side",
        "  controlled isSeen: Boolean -> Boolean\n  controlled side",
    )
    .replace(
        "CTLSPEC ag(not (opened and closed))",
        "CTLSPEC ag(opened implies closed)",
    )
    .replace(
        "function side",
        "function isSeen($b in Boolean) = if $b then undef else true endif\n  function side",
    )
}

#[test]
fn a_constraint_that_is_undef_excludes_inputs_everywhere() {
    let reason = "the constraint `isSeen(opened) or closed` is undef in step";
    let script = "[default]\nopened = false\nclosed = false\n[[step]]\n[[step]]\nopened = true\n";
    let (folder, script) = file("door.env.toml", script);
    let path = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let door = path("door.asm", &undefined());
    let (code, out, err) = run(&["verify", &door]);
    assert_eq!(code, 0, "{out}{err}");
    let (code, out, err) = run(&["sim", &door, "--steps", "100"]);
    assert_eq!(code, 0, "{out}{err}");
    let (code, out, err) = run(&["sim", &door, "--env", &script]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(err.contains(&format!("{reason} 2")), "{out}{err}");
    let scenario = path(
        "door.avalla",
        "scenario seen\nload door.asm\nset opened := false;\nset closed := false;\nstep\nset opened := true;\nstep\n",
    );
    let (code, out, err) = run(&["test", &scenario]);
    assert_eq!(code, 1, "{out}{err}");
    assert!(
        (out.clone() + &err).contains(&format!("{reason} 2")),
        "{out}{err}"
    );
    path("door.asm", &undefined().replace(" or closed", ""));
    let composite = path("doors.composite.toml", COMPOSITE);
    let (code, out, err) = run(&["run", &composite, "--for", "3"]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(
        err.contains("the constraint `isSeen(opened)` is undef in step"),
        "{out}{err}"
    );
}
