//! Properties watched in runs of composites: a mutant of the navigation that moves during an e-stop, and the crossings of watching
//! with the other features of a run.

use asmotion_recording::{RecordingItem, RunReader};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Whether the specification stops on an e-stop.
const STOPS: &str = "if mode != IDLE then r_halt[IDLE] endif";
/// The mutant goes on.
const MOVES: &str = "if mode != IDLE then r_move[true] endif";
const PROPERTY: &str = "ag(estop implies ax(not moving))";
const SAFE: &str = "watch = { safe_rule = \"r_halt[IDLE]\" }\n";

/// A copy of `specs/navigation` in which each text is replaced by the other.
fn navigation(changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    copy(&specs, folder.path());
    for (file, from, to) in changes {
        let path = folder.path().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "`{from}` is not in {file}");
        std::fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
    folder
}

fn copy(from: &Path, to: &Path) {
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            std::fs::create_dir(&target).unwrap();
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Exit code and all output.
fn asmotion(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).current_dir(folder).env("CI", "");
    let output = command.output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    (output.status.code().unwrap(), text)
}

const COMPOSITE: &str = "navigation.composite.toml";
const SPECIFICATION: &str = "navigate.asm";

/// The e-stop is pressed after 8 s.
const PRESSED: (&str, &str, &str) = (
    COMPOSITE,
    "[\"1.0 goal 26.4 4.2 0.0\"]",
    "[\"1.0 goal 26.4 4.2 0.0\", \"8.0 estop on\"]",
);
const MUTANT: (&str, &str, &str) = (SPECIFICATION, STOPS, MOVES);
const WATCHED: (&str, &str, &str) = (
    COMPOSITE,
    "lifecycle  = { safe =",
    "watch = { safe_rule = \"r_halt[IDLE]\" }\nlifecycle  = { safe =",
);

fn mission(folder: &Path, expectations: &str) -> (i32, String) {
    let text = std::fs::read_to_string(folder.join("estop.mission.toml")).unwrap();
    let text = text.replace("snapshot  = true\n", "") + expectations;
    std::fs::write(folder.join("watched.mission.toml"), text).unwrap();
    asmotion(folder, &["test", "watched.mission.toml"])
}

#[test]
fn a_mutant_that_moves_during_an_e_stop_is_stopped_in_the_step_where_it_happens() {
    let folder = navigation(&[MUTANT, WATCHED]);
    // the rover stops, permission is withdrawn, and a new goal lets it go on
    let (code, out) = mission(
        folder.path(),
        "\n[[expect]]\nwithin_s = 60\neventually = \"violations(ASMCoordinator) = 1\"\n\
         \n[[expect]]\nnever = \"violations(ASMCoordinator) > 1\"\n",
    );
    assert_eq!(code, 0, "{out}");
    let (code, out) = asmotion(folder.path(), &["run", COMPOSITE, "--for", "5", "--json"]);
    assert!(!out.contains("\"violation\""), "{code} {out}");
}

#[test]
fn without_a_safe_rule_the_violation_is_reported_and_the_mission_fails() {
    let folder = navigation(&[MUTANT]);
    let (code, out) = mission(
        folder.path(),
        "\n[[expect]]\ndoc = \"keeps its promises\"\nalways = \"violations(ASMCoordinator) = 0\"\n",
    );
    assert_eq!(code, 1, "{out}");
    assert!(out.contains("keeps its promises"), "{out}");
    assert!(out.contains("stands still within 0.6 s"), "{out}");
    // the original keeps them
    let folder = navigation(&[]);
    let (code, out) = mission(
        folder.path(),
        "\n[[expect]]\nalways = \"violations(ASMCoordinator) = 0\"\n",
    );
    assert_eq!(code, 0, "{out}");
    let (code, out) = mission(
        folder.path(),
        "\n[[expect]]\nalways = \"violations(MapServer) = 0\"\n",
    );
    assert_eq!(code, 2, "{out}");
    assert!(out.contains("runs no specification"), "{out}");
}

/// The lines of `--json` about violations, and those about steps.
fn events(out: &str) -> (Vec<Value>, Vec<Value>) {
    let lines = out
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    let lines: Vec<Value> = lines.collect();
    let of = |kind: &str| {
        let found = lines.iter().filter(|line| line["type"] == kind);
        found.cloned().collect()
    };
    (of("violation"), of("step"))
}

#[test]
fn a_violation_is_in_the_story_in_json_and_in_the_trace_before_its_step() {
    let folder = navigation(&[MUTANT, WATCHED, PRESSED]);
    let arguments = [
        "run",
        COMPOSITE,
        "--for",
        "10",
        "--json",
        "--trace",
        "run.trace",
    ];
    let (_, out) = asmotion(folder.path(), &arguments);
    let (violations, steps) = events(&out);
    assert_eq!(violations.len(), 1, "{violations:?}");
    let violation = &violations[0]["violation"];
    assert_eq!(violation["property"], PROPERTY);
    assert_eq!(violation["reaction"], "safe_rule");
    assert_eq!(violation["conditions"][0]["text"], "estop");
    let at = violations[0]["t"].as_f64().unwrap();
    assert!((8.0..8.2).contains(&at), "{at}");
    let step = steps.iter().find(|it| it["step"]["safe_rule"].is_string());
    let step = step.unwrap();
    assert_eq!(step["t"], violations[0]["t"]);
    assert_eq!(step["step"]["number"], violation["step"]);
    let trace = std::fs::read_to_string(folder.path().join("run.trace")).unwrap();
    let violated = trace.find("asm/Violation").unwrap();
    let made = trace.find("\n  R r_halt[IDLE]").unwrap();
    assert!(violated < made);
    // the specification alone does not give the step
    let replayed = ["sim", SPECIFICATION, "--replay-inputs", "run.trace"];
    let (code, out) = asmotion(folder.path(), &replayed);
    assert_ne!(code, 0, "{out}");
    assert!(out.contains("the safe rule `r_halt[IDLE]`"), "{out}");
    let (_, out) = asmotion(folder.path(), &["run", COMPOSITE, "--for", "10"]);
    assert!(
        out.contains(PROPERTY) && out.contains("the safe rule makes the step"),
        "{out}"
    );
    // the same run twice: the same trace
    let again = ["run", COMPOSITE, "--for", "10", "--trace", "again.trace"];
    asmotion(folder.path(), &again);
    let again = std::fs::read_to_string(folder.path().join("again.trace")).unwrap();
    assert!(trace == again);
}

#[test]
fn a_run_with_a_violation_and_no_safe_rule_can_be_replayed() {
    let folder = navigation(&[MUTANT, PRESSED]);
    let (_, out) = asmotion(
        folder.path(),
        &["run", COMPOSITE, "--for", "10", "--trace", "run.trace"],
    );
    assert!(out.contains(PROPERTY), "{out}");
    let replayed = ["sim", SPECIFICATION, "--replay-inputs", "run.trace"];
    let (code, out) = asmotion(folder.path(), &replayed);
    assert_eq!(code, 0, "{out}");
}

#[test]
fn a_recording_has_a_mark_at_the_violation() {
    let folder = navigation(&[MUTANT, WATCHED, PRESSED]);
    let recorded = ["run", COMPOSITE, "--for", "10", "--record", "run.mcap"];
    let (_, out) = asmotion(folder.path(), &recorded);
    assert!(folder.path().join("run.mcap").exists(), "{out}");
    let reader = RunReader::open(&folder.path().join("run.mcap")).unwrap();
    let (mut marks, mut steps) = (Vec::new(), Vec::new());
    for item in reader {
        match item {
            RecordingItem::Message { channel, at, data } if channel == "marks" => {
                marks.push((
                    at,
                    serde_json::from_str::<Value>(&data.json().unwrap()).unwrap(),
                ));
            }
            RecordingItem::Step { step, .. } => {
                assert!(step.is_intact);
                steps.push(step.cycle);
            }
            RecordingItem::Text { .. } | RecordingItem::Message { .. } | RecordingItem::End(_) => {}
            RecordingItem::Cut(reason) => panic!("{reason}"),
        }
    }
    let [(at, mark)] = marks.as_slice() else {
        panic!("{marks:?}");
    };
    assert_eq!(mark["component"], "ASMCoordinator");
    let step = steps.iter().find(|step| step.replaced.is_some()).unwrap();
    assert_eq!(mark["step"], step.number);
    assert_eq!(at.nanos(), step.time_ns);
    assert_eq!(step.violations[0].property, PROPERTY);
    let replaced = step.replaced.as_ref().unwrap();
    assert_eq!(replaced.rule, "r_halt[IDLE]");
    // the mutant would have moved on
    let moves =
        |it: &asmotion_coordinator::UpdateRecord| it.location == "moving" && it.after == "true";
    assert!(replaced.updates.iter().any(moves) && !step.updates.iter().any(moves));
}

#[test]
fn a_recording_is_replayed_with_its_safe_rule() {
    let folder = navigation(&[MUTANT, WATCHED, PRESSED]);
    let run = |arguments: &[&str]| asmotion(folder.path(), arguments);
    let (_, out) = run(&["run", COMPOSITE, "--for", "10", "--record", "run.mcap"]);
    assert!(folder.path().join("run.mcap").exists(), "{out}");
    let (code, out) = run(&["replay", "run.mcap"]);
    assert_eq!(code, 0, "{out}");

    // the safe rule wrote the mode, and the replay knows why
    let (code, out) = run(&["replay", "run.mcap", "--explain", "mode"]);
    assert_eq!(code, 0, "{out}");
    assert!(
        out.contains("the safe rule `r_halt[IDLE]` made it"),
        "{out}"
    );

    // the mutant without its mistake needs no safe rule
    let text = std::fs::read_to_string(folder.path().join(SPECIFICATION)).unwrap();
    std::fs::write(
        folder.path().join("mended.asm"),
        text.replacen(MOVES, STOPS, 1),
    )
    .unwrap();
    let (code, out) = run(&["replay", "run.mcap", "--spec", "mended.asm"]);
    assert_eq!(code, 1, "{out}");
    for part in [
        "rule that makes the step",
        "the safe rule `r_halt[IDLE]`",
        "the main rule",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }

    // neither a session nor a scenario goes beyond the step of the safe rule, and both say so
    let (_, out) = run(&["replay", "run.mcap", "--export", "scenario"]);
    assert!(
        out.contains("the safe rule `r_halt[IDLE]` made the step"),
        "{out}"
    );
    let (_, out) = run(&["repl", "--from", "run.mcap"]);
    assert!(
        out.contains("which the safe rule `r_halt[IDLE]` made"),
        "{out}"
    );
}

#[test]
fn a_replay_names_the_property_that_an_edited_specification_violates() {
    let folder = navigation(&[PRESSED]);
    let run = |arguments: &[&str]| asmotion(folder.path(), arguments);
    let (_, out) = run(&["run", COMPOSITE, "--for", "10", "--record", "run.mcap"]);
    let text = std::fs::read_to_string(folder.path().join(SPECIFICATION)).unwrap();
    // a property that the run does not hold
    let strict = text.replacen("CTLSPEC", "CTLSPEC ag(mode = IDLE)\n\tCTLSPEC", 1);
    assert_ne!(text, strict, "{out}");
    std::fs::write(folder.path().join("strict.asm"), strict).unwrap();
    let (code, out) = run(&["replay", "run.mcap", "--spec", "strict.asm"]);
    assert_eq!(code, 1, "{out}");
    assert!(out.contains("violated property"), "{out}");
    assert!(out.contains("CTLSPEC `ag(mode = IDLE)`"), "{out}");
}

#[test]
fn what_is_written_under_watch_is_checked() {
    let check = |keys: &str| {
        let change = format!("{keys}\nlifecycle  = {{ safe =");
        let folder = navigation(&[(COMPOSITE, "lifecycle  = { safe =", &change)]);
        asmotion(folder.path(), &["check", COMPOSITE])
    };
    let (code, out) = check("watch = { safe_rule = \"r_halted[IDLE]\" }");
    assert!(code == 1 && out.contains("C200"), "{out}");
    let (code, out) = check("watch = { properties = [{ property = \"tries\" }] }");
    assert!(code == 1 && out.contains("C200"), "{out}");
    let (code, out) = check(SAFE);
    assert!(code == 0 && out.contains("C201"), "{out}");
    assert!(
        out.contains("2 temporal properties, which a run cannot watch"),
        "{out}"
    );
    let folder = navigation(&[(
        COMPOSITE,
        "activity   = { period_ms = 100 }",
        "watch = { temporal = true }\nactivity   = { period_ms = 100 }",
    )]);
    let (code, out) = asmotion(folder.path(), &["check", COMPOSITE]);
    assert!(
        code == 1 && out.contains("only properties of an ASM"),
        "{out}"
    );
}

#[test]
fn a_property_of_the_composite_with_a_time_is_watched() {
    let property = "watch = { properties = [{ property = \"ag(mode = FOLLOWING implies af(mode = ARRIVED))\", within_ms = 3000 }] }\n\
                    lifecycle  = { safe =";
    let folder = navigation(&[(COMPOSITE, "lifecycle  = { safe =", property)]);
    let (_, out) = asmotion(folder.path(), &["run", COMPOSITE, "--for", "10", "--json"]);
    let (violations, _) = events(&out);
    let late = violations[0]["violation"]["late_after_s"].as_f64();
    assert_eq!(late, Some(3.0), "{violations:?}");
}

#[test]
fn two_coordinators_are_watched_on_their_own() {
    let folder = navigation(&[MUTANT, WATCHED]);
    let path = folder.path().join("two_rovers.mission.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let once = |rover: &str| {
        format!(
            "\n[[expect]]\nwithin_s = 20\neventually = \"violations({rover}/ASMCoordinator) = 1\"\n"
        )
    };
    std::fs::write(&path, text + &once("Left") + &once("Right")).unwrap();
    let (code, out) = asmotion(folder.path(), &["test", "two_rovers.mission.toml"]);
    assert_eq!(code, 0, "{out}");
}

#[test]
fn a_specification_verified_before_the_start_is_watched_as_well() {
    // the proof is about the inputs of the composite, and passes for the original only
    let verify = "verify = { ctl = true, ltl = true, refuse_start_on_failure = true }\nlifecycle  = { safe =";
    let folder = navigation(&[(COMPOSITE, "lifecycle  = { safe =", verify)]);
    let (code, out) = asmotion(folder.path(), &["run", COMPOSITE, "--for", "3"]);
    assert!(out.starts_with("time up in FOLLOWING"), "{code} {out}");
    assert!(!out.contains("C201") && !out.contains("violated"), "{out}");
    let folder = navigation(&[MUTANT, (COMPOSITE, "lifecycle  = { safe =", verify)]);
    let (code, out) = asmotion(folder.path(), &["run", COMPOSITE, "--for", "3"]);
    assert!(code == 1 && out.contains("does not start"), "{out}");
}

#[test]
fn a_safe_rule_that_fails_lets_the_life_cycle_decide() {
    let unsafe_rule = "watch = { safe_rule = \"r_move[true]\" }\nlifecycle  = { on_exception = \"reset\", max_resets = 2, safe =";
    let folder = navigation(&[
        MUTANT,
        PRESSED,
        (COMPOSITE, "lifecycle  = { safe =", unsafe_rule),
    ]);
    let arguments = [
        "run",
        COMPOSITE,
        "--for",
        "10",
        "--json",
        "--trace",
        "run.trace",
    ];
    let (_, out) = asmotion(folder.path(), &arguments);
    let (violations, steps) = events(&out);
    assert_eq!(violations.len(), 1, "{violations:?}");
    assert_eq!(violations[0]["violation"]["reaction"], "failed");
    assert!(out.contains("the step of the safe rule violates"), "{out}");
    // nothing of the step left; after the reset the specification begins in its initial state, in which it stays
    let number = violations[0]["violation"]["step"].as_u64().unwrap();
    let last = steps.last().unwrap()["step"]["number"].as_u64().unwrap();
    assert!(last < number, "{last} {number}");
    let trace = std::fs::read_to_string(folder.path().join("run.trace")).unwrap();
    assert!(trace.contains("life ASMCoordinator Exception"), "{out}");
}
