//! Traces of runs, replayed with their specifications; and what a run that does not end waits for.

use super::{NAVIGATION, run};
use std::path::Path;

const COUNTER: &str = "asm counter
import StandardLibrary
signature:
  enum domain Colour = {RED | GREEN | BLUE}
  monitored level: Real
  controlled n: Integer
  controlled colour: Colour
  controlled seen: Seq(Real)
  controlled label: String
definitions:
  main rule r_Main =
    if isDef(level) then
      choose $c in Colour with $c != colour do
        par
          n := n + 1
          colour := $c
          seen := [level]
          label := \"a, \\\"b\\\" = c\"
        endpar
    endif
default init s0:
  function n = 0
  function colour = RED
";

/// Two coordinators of one specification; the first one's choices reach neither the other nor its inputs.
const TWO: &str = r#"schema = "composite/1"
[composite]
name = "two"

[components.First]
implementation = { asm = "counter.asm" }
task = { period_ms = 20 }
subscribe = { level = "std_msgs/Float64" }

[components.First.bind.monitored]
level = { topic = "level" }

[components.Second]
implementation = { asm = "counter.asm" }
task = { period_ms = 30 }
subscribe = { level = "std_msgs/Float64" }

[components.Second.bind.monitored]
level = { topic = "level" }

[components.Source]
implementation = { asm = "source.asm" }
task = { period_ms = 50 }
publish = { level = "std_msgs/Float64" }

[components.Source.bind.out]
level = { topic = "level" }
"#;

const SOURCE: &str = "asm source
import StandardLibrary
signature:
  controlled tick: Integer
  out level: Real
definitions:
  main rule r_Main =
    par
      tick := tick + 1
      level := itor(tick) / 3.0
    endpar
default init s0:
  function tick = 0
";

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn path(folder: &tempfile::TempDir, name: &str) -> String {
    folder.path().join(name).display().to_string()
}

/// The last value of a location that a component wrote, according to a trace.
fn last(trace: &str, component: &str, location: &str) -> String {
    let head = format!(" report {component} asm/Step ");
    let update = format!("  U {location} = ");
    let mut is_own = false;
    let mut found = None;
    for line in trace.lines() {
        if !line.starts_with("  ") {
            is_own = line.contains(&head);
        } else if let (true, Some(value)) = (is_own, line.strip_prefix(&update)) {
            found = Some(value.to_owned());
        }
    }
    found.unwrap_or_else(|| panic!("{component} never wrote {location}: {trace}"))
}

#[test]
fn a_trace_of_a_run_replays_to_the_same_states_in_both_clocks() {
    for clock in ["virtual", "wall"] {
        let folder = folder(&[
            ("counter.asm", COUNTER),
            ("source.asm", SOURCE),
            ("two.composite.toml", TWO),
        ]);
        let (composite, trace) = (
            path(&folder, "two.composite.toml"),
            path(&folder, "run.trace"),
        );
        let recording = ["--clock", clock, "--for", "1", "--trace", &trace, "-q"];
        let (code, out, err) = run(&[&["run", &*composite], &recording[..]].concat());
        assert!(code < 2, "the time is up: {out}{err}");
        let recorded = std::fs::read_to_string(&trace).unwrap();
        assert!(recorded.contains("  C "), "choices are recorded");
        for (component, specification) in [("First", "counter.asm"), ("Source", "source.asm")] {
            let specification = path(&folder, specification);
            let replay = ["--replay-inputs", &trace, "--component", component, "-q"];
            let (code, out, err) = run(&[&["sim", &*specification], &replay[..]].concat());
            assert_eq!(code, 0, "{clock}: {out}{err}");
            let locations: &[&str] = match component {
                "First" => &["n", "colour", "seen", "label"],
                _ => &["tick", "level"],
            };
            for location in locations {
                let line = format!("  {location} = {}\n", last(&recorded, component, location));
                assert!(out.contains(&line), "{clock}: {line} in {out}");
            }
        }

        let counter = path(&folder, "counter.asm");
        let (code, _, err) = run(&["sim", &counter, "--replay-inputs", &trace]);
        assert_eq!(code, 2, "{err}");
        assert!(
            err.contains("several coordinators (First, Second, Source)"),
            "{err}"
        );
        let select = ["--component", "Frist"];
        let (code, _, err) =
            run(&[&["sim", &*counter, "--replay-inputs", &trace], &select[..]].concat());
        assert_eq!(code, 2, "{err}");
        assert!(err.contains("did you mean `First`?"), "{err}");

        std::fs::write(&counter, COUNTER.replace("n := n + 1", "n := n + 2")).unwrap();
        let select = ["--component", "First", "-q"];
        let (code, _, err) =
            run(&[&["sim", &*counter, "--replay-inputs", &trace], &select[..]].concat());
        assert_eq!(code, 1, "{err}");
        assert!(
            err.contains("step 1 ") || err.contains("deviates: the run wrote"),
            "{err}"
        );
    }
}

#[test]
fn the_trace_of_a_mission_replays() {
    let folder = tempfile::tempdir().unwrap();
    let trace = path(&folder, "run.trace");
    let (code, out, err) = run(&["run", NAVIGATION, "--trace", &trace, "-q"]);
    assert_eq!(code, 0, "{out}{err}");
    let navigate = "specs/navigation/navigate.asm";
    let (code, out, err) = run(&["sim", navigate, "--replay-inputs", &trace, "-q"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("  mode = ARRIVED\n"), "{out}");
}

#[test]
fn a_file_without_steps_is_not_replayed() {
    let folder = folder(&[
        ("counter.asm", COUNTER),
        ("none.trace", "0 life World PreOperational Stopped\n"),
        ("text.txt", "hello\n"),
    ]);
    let counter = path(&folder, "counter.asm");
    for name in ["none.trace", "text.txt"] {
        let trace = path(&folder, name);
        let (code, out, err) = run(&["sim", &counter, "--replay-inputs", &trace]);
        assert_eq!(code, 2, "{out}");
        assert!(err.contains("there is nothing to replay"), "{err}");
    }
}

/// The lines about what the coordinators of a run wait for, and their JSON.
fn waits(folder: &Path, arguments: &[&str]) -> (String, serde_json::Value) {
    let composite = folder.join("c.composite.toml").display().to_string();
    let limit = ["--for", "2", "-q", "--until", "mode=DONE"];
    let command = [&["run", &*composite], &limit[..], arguments].concat();
    let (code, out, err) = run(&command);
    assert_eq!(code, 1, "{out}{err}");
    let lines = out.lines().filter(|line| line.starts_with("  waits"));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    let (_, json, _) = run(&[&command[..], &["--json"]].concat());
    let last = json.lines().last().unwrap();
    let summary: serde_json::Value = serde_json::from_str(last).unwrap();
    (text, summary["stalled"].clone())
}

const STUCK: &str = "asm stuck
import StandardLibrary
signature:
  enum domain Mode = {IDLE | PLANNING | DONE}
  enum domain Reply = {PLANNED}
  monitored go: Boolean
  monitored reply: Reply
  controlled mode: Mode
definitions:
  rule r_idle = if mode = IDLE and go then mode := PLANNING endif
  rule r_planning = if mode = PLANNING and reply = PLANNED then mode := DONE endif
  main rule r_Main = par r_idle[] r_planning[] endpar
default init s0:
  function mode = IDLE
";

const STUCK_COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "stuck"

[components.Coordinator]
implementation = { asm = "stuck.asm" }
task = { period_ms = 100 }
subscribe = { go = "std_msgs/Bool", event = "nav/Event" }

[components.Coordinator.bind.monitored]
go = { topic = "go", none = false }
reply = { topic = "event", map = "code" }

[[promote]]
topic = "go"
as = "go"

[[promote]]
topic = "event"
as = "event"
"#;

#[test]
fn a_run_whose_time_is_up_says_what_it_waits_for() {
    for clock in ["virtual", "wall"] {
        let folder = folder(&[("stuck.asm", STUCK), ("c.composite.toml", STUCK_COMPOSITE)]);
        let (lines, json) = waits(folder.path(), &["--clock", clock]);
        assert!(
            lines.contains("Coordinator in mode = IDLE since the start"),
            "{lines}"
        );
        let silent = "no message has arrived for `go` (topic `go`, which no component publishes)";
        assert!(lines.contains(silent), "{lines}");
        assert_eq!(json[0]["component"], "Coordinator");
        assert_eq!(json[0]["reasons"][0], silent);
    }
}

/// Without a goal, a run is completed when its time is up, also if its coordinator has done nothing at all.
#[test]
fn a_completed_run_in_which_nothing_happened_says_the_control_state_and_what_it_waits_for() {
    let folder = folder(&[("stuck.asm", STUCK), ("c.composite.toml", STUCK_COMPOSITE)]);
    let composite = folder.path().join("c.composite.toml").display().to_string();
    for clock in ["virtual", "wall"] {
        let command = ["run", &composite, "--for", "1", "--clock", clock, "-q"];
        let (code, out, err) = run(&command);
        assert_eq!(code, 0, "{out}{err}");
        // on a busy machine, a run ends later
        assert!(out.starts_with("completed in IDLE after 1."), "{out}");
        assert!(
            out.contains(
                "Coordinator in mode = IDLE since the start: no message has arrived for `go`"
            ),
            "{out}"
        );
        let (_, json, _) = run(&[&command[..], &["--json"]].concat());
        let summary: serde_json::Value =
            serde_json::from_str(json.lines().last().unwrap()).unwrap();
        assert_eq!(summary["control_state"], "IDLE");
        assert_eq!(summary["stalled"][0]["component"], "Coordinator");
    }
}

#[test]
fn a_control_state_without_exit_is_named() {
    let text = STUCK
        .replace("and go then", "then")
        .replace("mode = PLANNING and reply", "mode = DONE and reply");
    let folder = folder(&[("stuck.asm", &text), ("c.composite.toml", STUCK_COMPOSITE)]);
    let (lines, _) = waits(folder.path(), &[]);
    assert!(
        lines.contains("in mode = PLANNING since 0.0 s: no rule leaves `mode = PLANNING`"),
        "{lines}"
    );
}

/// Chooses one of the elements; its step number `n = 4` fails.
const FAILING: &str = "asm failing
import StandardLibrary
signature:
  controlled n: Integer
  controlled chosen: Integer
definitions:
  INVARIANT
  main rule r_Main = choose $c in {1 : 5} with true do par n := n + STEP chosen := $c endpar
default init s0:
  function n = 0
  function chosen = 0
";

const FAILING_COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "fails"
[components.Coordinator]
implementation = { asm = "failing.asm" }
activity = { period_ms = 100 }
"#;

#[test]
fn a_step_that_failed_fails_in_the_replay() {
    for (invariant, step, code) in [
        ("invariant inv_small over n: n < 4", "1", "R014"),
        ("", "1 + idiv(0, 3 - n)", "R"),
    ] {
        let text = FAILING.replace("INVARIANT", invariant);
        let folder = folder(&[
            ("failing.asm", &text.replace("STEP", step)),
            ("c.composite.toml", FAILING_COMPOSITE),
        ]);
        let (composite, trace) = (path(&folder, "c.composite.toml"), path(&folder, "t"));
        let (exit, out, err) = run(&["run", &composite, "--for", "2", "--trace", &trace, "-q"]);
        assert_eq!(exit, 3, "{out}{err}");
        let specification = path(&folder, "failing.asm");
        let replay = ["sim", &specification, "--replay-inputs", &trace, "-q"];
        let (exit, out, err) = run(&replay);
        assert_eq!(exit, 3, "{out}{err}");
        assert!(err.contains(code), "{err}");

        std::fs::write(
            &specification,
            text.replace("STEP", "1").replace("n < 4", "n < 9"),
        )
        .unwrap();
        let (exit, _, err) = run(&replay);
        assert_eq!(exit, 1, "{err}");
        let succeeds =
            "step 4 (at 0.3 s of the run) failed, and in the replay it writes `chosen = ";
        assert!(err.contains(succeeds), "{err}");
    }
}
