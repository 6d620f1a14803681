//! `asmotion verify`.

use super::{file, run};
use crate::rovers;

const PHILOSOPHERS: &str = "asm-lang/verify/tests/models/philosophers.asm";
const LAMP: &str = "asm-lang/verify/tests/models/lamp.asm";

/// Replaces the time of a verification, which differs from run to run.
fn without_time(text: &str) -> String {
    let lines = text.lines().map(|line| match line.rsplit_once(" deep, ") {
        Some((start, _)) => format!("{start} deep, TIME\n"),
        None => format!("{line}\n"),
    });
    lines.collect()
}

#[test]
fn every_specification_of_the_repository_that_can_be_verified_is_correct() {
    for name in [
        "allocation",
        "estop",
        "nav2",
        "navigation",
        "patrol",
        "recovery",
        "youbot",
    ] {
        let folder = format!("specs/{name}");
        let specification = match name {
            "navigation" => "navigate",
            "nav2" => "navigate_to_pose",
            name => name,
        };
        let (exit, out, err) = run(&["verify", &format!("{folder}/{specification}.asm")]);
        // a slow verification reports its progress
        let mut messages = err
            .lines()
            .filter(|line| !line.trim_start().starts_with("Exploring "));
        assert_eq!((exit, messages.next()), (0, None), "{name}: {out}");
        assert!(out.contains(" 0 violated, 0 not known"), "{out}");
    }
}

#[test]
fn a_violation_is_shown_step_by_step() {
    let (exit, out, _) = run(&["verify", PHILOSOPHERS]);
    assert_eq!(exit, 1);
    insta::assert_snapshot!("philosophers", without_time(&out));
    let (exit, out, _) = run(&[
        "verify",
        LAMP,
        "--property",
        "obeys",
        "--property",
        "level < 3",
        "--possible",
        "level = 2",
    ]);
    assert_eq!(exit, 1);
    insta::assert_snapshot!("lamp", without_time(&out));
    let (exit, out, _) = run(&["verify", "asm-lang/verify/tests/models/faulty.asm"]);
    assert_eq!(exit, 1);
    insta::assert_snapshot!("faulty", without_time(&out));
}

#[test]
fn the_trace_of_a_violation_is_repeated_by_sim() {
    let (_folder, trace) = file("run.trace", "");
    let (exit, _, _) = run(&["verify", PHILOSOPHERS, "--trace", &trace]);
    assert_eq!(exit, 1);
    let (exit, out, err) = run(&["sim", PHILOSOPHERS, "--replay-inputs", &trace, "--quiet"]);
    assert_eq!(exit, 3, "{out}{err}");
    assert!(err.contains("inv_wrong"), "{err}");
}

#[test]
fn exit_codes_tell_a_violation_from_what_is_not_known() {
    let (exit, out, _) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "inv_exclusive",
        "--bound",
        "3",
    ]);
    assert_eq!(exit, 4);
    assert!(out.contains("unknown") && out.contains("--bound"), "{out}");
    // a violation within the bound is a violation
    let (exit, _, _) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "inv_wrong",
        "--bound",
        "4",
    ]);
    assert_eq!(exit, 1);
    let (exit, _, _) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "inv_exclusive",
        "--states",
        "5",
    ]);
    assert_eq!(exit, 4);
    let (exit, _, _) = run(&["verify", PHILOSOPHERS, "--property", "inv_exclusive"]);
    assert_eq!(exit, 0);
    let (exit, _, err) = run(&["verify", "nowhere.asm"]);
    assert_eq!(exit, 2, "{err}");
    let (exit, _, err) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "ag(phase(0) = EATING)",
    ]);
    assert_eq!(exit, 1, "{err}");
    assert!(err.contains("A005") && err.contains("EATING"), "{err}");
    // of several specifications, a violation of one counts more than what is not known of another
    let undecided = "specs/allocation/allocation.asm";
    let (exit, _, _) = run(&["verify", undecided, "--bound", "4"]);
    assert_eq!(exit, 4);
    for files in [[PHILOSOPHERS, undecided], [undecided, PHILOSOPHERS]] {
        let [first, second] = files;
        let (exit, out, _) = run(&["verify", first, second, "--bound", "4"]);
        assert_eq!(exit, 1, "{out}");
    }
}

#[test]
fn json_has_the_verdicts_and_the_runs() {
    let (exit, out, _) = run(&["verify", LAMP, "--json"]);
    assert_eq!(exit, 1);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["states"], 4);
    let properties = json["properties"].as_array().unwrap();
    let obeys = properties.iter().find(|it| it["name"] == "obeys").unwrap();
    assert_eq!(obeys["verdict"], "violated");
    assert!(!obeys["run"]["steps"].as_array().unwrap().is_empty());
}

/// Verifies a property and writes the run as a scenario; returns the exit codes of both and the output of the test.
fn tested_again(spec: &str, arguments: &[&str]) -> (i32, i32, String) {
    let (_folder, scenario) = file("run.avalla", "");
    let mut all = vec!["verify", spec, "--avalla", &scenario];
    all.extend(arguments);
    let (verified, _, err) = run(&all);
    assert_ne!(verified, 2, "{err}");
    let (tested, out, err) = run(&["test", &scenario]);
    (verified, tested, out + &err)
}

#[test]
fn a_scenario_repeats_a_violation() {
    let (verified, tested, out) = tested_again(PHILOSOPHERS, &["--property", "inv_wrong"]);
    assert_eq!((verified, tested), (1, 1), "{out}");
    assert!(out.contains("inv_wrong"), "{out}");
    let (verified, tested, out) = tested_again(LAMP, &["--property", "obeys"]);
    assert_eq!((verified, tested), (1, 1), "{out}");
    assert!(out.contains("isOn"), "{out}");
    let (verified, tested, out) = tested_again(LAMP, &["--property", "level < 3"]);
    assert_eq!((verified, tested), (1, 1), "{out}");
    let (verified, tested, out) = tested_again("asm-lang/verify/tests/models/faulty.asm", &[]);
    assert_eq!((verified, tested), (1, 1), "{out}");
    // a cycle is repeated, which violates nothing in a finite run
    let (verified, tested, out) = tested_again(LAMP, &["--property", "darkens"]);
    assert_eq!((verified, tested), (1, 0), "{out}");
    // so does the run to a possible state
    let (verified, tested, out) = tested_again(LAMP, &["--possible", "level = 2"]);
    assert_eq!((verified, tested), (0, 0), "{out}");
    let (exit, _, _) = run(&["verify", LAMP, "--init", "s0", "--avalla", "run.avalla"]);
    assert_eq!(exit, 2);
}

#[test]
fn a_run_is_written_in_the_informal_trace_format() {
    let (_folder, path) = file("run.itf.json", "");
    let (exit, _, err) = run(&["verify", LAMP, "--property", "darkens", "--itf", &path]);
    assert_eq!(exit, 1, "{err}");
    let text = std::fs::read_to_string(&path).unwrap();
    let trace: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(trace["#meta"]["format"], "ITF");
    assert_eq!(trace["vars"], serde_json::json!(["isOn", "level"]));
    let states = trace["states"].as_array().unwrap();
    assert_eq!(states[0]["level"]["#bigint"], "0");
    assert_eq!(states[1]["#meta"]["updates"][0]["rule"], "r_Main");
    // the cycle returns to a state with equal values
    let (first, last) = (trace["loop"].as_u64().unwrap() as usize, states.len() - 1);
    for variable in ["isOn", "level"] {
        assert_eq!(states[first][variable], states[last][variable]);
    }
    let (exit, _, _) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "inv_wrong",
        "--itf",
        &path,
    ]);
    assert_eq!(exit, 1);
    let trace: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let phase = &trace["states"][0]["phase"]["#map"];
    assert_eq!(phase[0][0]["#bigint"], "0");
    assert_eq!(phase[0][1], "THINKS");
    assert!(trace.get("loop").is_none());
}

#[test]
fn fairness_can_be_given() {
    let fair = |names: &[&str]| {
        let mut arguments = vec!["verify", PHILOSOPHERS, "--property", "hungry"];
        arguments.extend(names);
        run(&arguments)
    };
    let (exit, out, _) = fair(&["--fair", "Philosopher", "--json"]);
    assert_eq!(exit, 1);
    assert!(out.contains("weak fairness of Philosopher"), "{out}");
    let (exit, _, err) = fair(&["--strongly-fair", "Philosophers"]);
    assert_eq!(exit, 1);
    assert!(
        err.contains("M020") && err.contains("did you mean `Philosopher`"),
        "{err}"
    );
}

#[cfg(unix)]
#[test]
fn an_interrupted_verification_reports_what_is_known() {
    let text = "asm large
import StandardLibrary
import CTLLibrary
signature:
  domain Count subsetof Integer
  controlled a: Count
  controlled b: Count
  monitored up: Boolean
definitions:
  domain Count = {0 : 3000000}
  invariant inv_small over a: a < 3
  CTLSPEC af(a = 5)
  main rule r_Main = if up then a := (a + 1) mod 3000000 else b := (b + 1) mod 3000000 endif
default init s0:
  function a = 0
  function b = 0
";
    let (_folder, path) = file("large.asm", text);
    let child = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(["verify", &path])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // a handler that is not installed yet would end the process, whose exit code then differs
    std::thread::sleep(std::time::Duration::from_secs(3));
    let sent = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{out}");
    assert!(out.contains("violated  invariant inv_small"), "{out}");
    assert!(out.contains("unknown   CTLSPEC af(a = 5)"), "{out}");
    assert!(
        out.contains("not all states were explored: it was interrupted"),
        "{out}"
    );
}

#[test]
fn advice_and_mutants_are_listed() {
    let text = "asm blinker
import StandardLibrary
import CTLLibrary
signature:
  enum domain Light = {GREEN | RED | BROKEN}
  controlled light: Light
  monitored pressed: Boolean
definitions:
  CTLSPEC changes: ag(ef(light = RED))
  main rule r_Main =
    if pressed then
      if light = GREEN then light := RED else light := GREEN endif
    endif
default init s0:
  function light = GREEN
";
    let (_folder, path) = file("blinker.asm", text);
    let (exit, out, err) = run(&["verify", &path, "--advice"]);
    assert_eq!((exit, err.as_str()), (0, ""), "{out}");
    assert!(out.contains("advice    `light` is never BROKEN"), "{out}");
    let (_, out, _) = run(&["verify", &path, "--advice", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["advice"][0]["kind"], "unused-value");

    let (exit, out, err) = run(&["verify", &path, "--mutants"]);
    assert_eq!((exit, err.as_str()), (1, ""), "{out}");
    assert!(
        out.contains("survives  `pressed` becomes `not (pressed)`"),
        "{out}"
    );
    assert!(out.contains("mutants are killed"), "{out}");
    let again = run(&["verify", &path, "--mutants"]);
    assert_eq!(again.1, out);
    let (_, out, _) = run(&["verify", &path, "--mutants", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let mutants = json["mutants"].as_array().unwrap();
    let killed = |it: &&serde_json::Value| it["change"] == "`light := RED` becomes `skip`";
    assert_eq!(
        mutants.iter().find(killed).unwrap()["fate"],
        "killed",
        "{out}"
    );
    let (exit, _, _) = run(&["verify", &path, "--mutants", "--trace", "x"]);
    assert_eq!(exit, 2);
    let (exit, _, _) = run(&["verify", &path, LAMP, "--watch"]);
    assert_eq!(exit, 2);
}

#[test]
fn mutants_have_the_same_fates_however_they_are_explored() {
    const SPECIFICATION: &str = "specs/patrol/patrol.asm";
    let fates = |options: &[&str]| {
        let (exit, out, err) = run(&[&["verify", SPECIFICATION, "--mutants"], options].concat());
        assert_eq!((exit, err.as_str()), (1, ""), "{options:?} {out}");
        out
    };
    let plain = fates(&[]);
    for options in [
        ["--threads", "3"].as_slice(),
        &["--storage", "disk"],
        &["--symmetry"],
        &["--engine", "symbolic"],
    ] {
        assert_eq!(fates(options), plain, "{options:?}");
    }
    // with another property, other mutants survive
    assert_ne!(fates(&["--property", "mode != PAUSED or wp < 100"]), plain);
}

#[cfg(unix)]
#[test]
fn a_watched_specification_is_verified_again() {
    let text = std::fs::read_to_string(LAMP).unwrap();
    let (folder, path) = file("lamp.asm", &text);
    let log = folder.path().join("out.txt");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(["verify", &path, "--watch"])
        .stdout(std::fs::File::create(&log).unwrap())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let shows = |wanted: &str| {
        for _ in 0..300 {
            if std::fs::read_to_string(&log).unwrap().contains(wanted) {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        panic!(
            "{wanted} is missing: {}",
            std::fs::read_to_string(&log).unwrap()
        );
    };
    shows("asmotion test run.avalla");
    let changed = text.replace(
        "CTLSPEC can_be_dark: ag(ef(not isOn))",
        "CTLSPEC can_be_dark: ag(ef(level = 0 and isOn))",
    );
    std::fs::write(&path, changed).unwrap();
    shows("changed   gone: CTLSPEC can_be_dark: ag(ef(not isOn))");
    shows("changed   new: violated, CTLSPEC can_be_dark: ag(ef(level = 0 and isOn))");
    let sent = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

const NAVIGATION: &str = "specs/navigation/navigation.composite.toml";

#[test]
fn a_composite_is_verified_with_what_its_components_send() {
    let (exit, out, err) = run(&["verify", NAVIGATION]);
    assert_eq!(exit, 0, "{out}{err}");
    assert!(out.contains("11 hold, 0 violated, 0 not known"), "{out}");
    assert!(out.contains("TrajectoryFollower behaves as in"), "{out}");
    assert!(
        out.contains(
            "CollisionMonitor receives nothing from ASMCoordinator: any event at any time"
        ),
        "{out}"
    );
    let property = "ag(mode = FOLLOWING implies ax(mode != ARRIVED))";
    let (exit, out, _) = run(&["verify", NAVIGATION, "--property", property]);
    assert_eq!(exit, 1, "{out}");
    assert!(
        out.contains("event = REACHED (from TrajectoryFollower.event)"),
        "{out}"
    );
    let (exit, out, _) = run(&["verify", NAVIGATION, "--property", property, "--json"]);
    assert_eq!(exit, 1, "{out}");
    let json: serde_json::Value = serde_json::from_str(&out).expect("a JSON object");
    assert_eq!(json["component"], "ASMCoordinator");
    assert_eq!(
        json["environment"]["components"][0]["component"],
        "TrajectoryAdapter"
    );
    assert_eq!(json["properties"][0]["verdict"], "violated");
    let (exit, out, _) = run(&["verify", NAVIGATION, "--bound", "2"]);
    assert_eq!(exit, 4, "{out}");
    let (exit, out, _) = run(&["verify", NAVIGATION, "--print-environment"]);
    assert_eq!(exit, 0, "{out}");
    assert!(out.contains("rule r_environment ="), "{out}");
}

#[test]
fn instances_that_differ_in_names_only_are_verified_once() {
    let folder = tempfile::tempdir().unwrap();
    let results = |third: &str| {
        let composite = rovers::write(folder.path(), third, |text| text);
        let (exit, out, err) = run(&["verify", composite.to_str().unwrap(), "--json"]);
        assert_eq!(exit, 1, "{out}{err}");
        let results = out.lines().map(|line| serde_json::from_str(line).unwrap());
        let results: Vec<serde_json::Value> = results.collect();
        assert!(
            results
                .iter()
                .all(|it| it["properties"][0]["verdict"] == "violated"),
            "{out}"
        );
        let of = |it: &serde_json::Value| (it["component"].clone(), it["alike"].clone());
        results.iter().map(of).collect::<Vec<_>>()
    };
    let alike = |names: &[&str]| serde_json::json!(names);
    assert_eq!(
        results("100"),
        [("Rover1".into(), alike(&["Rover2", "Rover3"]))]
    );
    // a driver with another period makes other steps
    assert_eq!(
        results("300"),
        [
            ("Rover1".into(), alike(&["Rover2"])),
            ("Rover3".into(), serde_json::Value::Null)
        ]
    );

    let path = rovers::write(folder.path(), "100", |text| text);
    let composite = path.to_str().unwrap();
    let (exit, out, err) = run(&["verify", composite]);
    assert_eq!(exit, 1, "{out}{err}");
    assert!(out.contains("rovers.composite.toml, Rover1\n"), "{out}");
    let said = "  alike Rover2, Rover3: the same results, up to names of components\n";
    assert!(out.ends_with(said), "{out}");
    let (exit, out, err) = run(&["verify", composite, "--component", "Rover2"]);
    assert_eq!(exit, 1, "{out}{err}");
    assert!(out.contains("arrived = true (from Driver2.there)"), "{out}");
    assert!(!out.contains("alike"), "{out}");

    let keys =
        "verify = { ctl = true, refuse_start_on_failure = true }\ntask = { period_ms = 100 }";
    rovers::write(folder.path(), "100", |text| {
        text.replace("task = { period_ms = 100 }", keys)
    });
    let (exit, out, err) = run(&["run", composite, "--speed", "0", "--for", "1"]);
    assert_eq!(exit, 1, "{out}{err}");
    let said = "`ag(mode != STOPPED)` of `Rover1` (and of `Rover2`, `Rover3`) is violated";
    assert_eq!(err.matches(said).count(), 1, "{err}");
    assert_eq!(err.matches("is violated").count(), 1, "{err}");
}

#[test]
fn a_run_of_a_composite_is_repeated_by_its_specification() {
    let folder =
        std::env::temp_dir().join(format!("asmotion-composite-run-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = |name: &str| folder.join(name).display().to_string();
    let (trace, scenario, states) = (path("run.trace"), path("run.avalla"), path("run.itf.json"));
    let property = "mode != ARRIVED";
    let (exit, out, err) = run(&[
        "verify",
        NAVIGATION,
        "--property",
        property,
        "--trace",
        &trace,
        "--avalla",
        &scenario,
        "--itf",
        &states,
    ]);
    assert_eq!(exit, 1, "{out}{err}");
    let (exit, out, err) = run(&[
        "sim",
        "specs/navigation/navigate.asm",
        "--replay-inputs",
        &trace,
    ]);
    assert_eq!(exit, 0, "{out}{err}");
    assert!(out.contains("ARRIVED"), "{out}");
    // the scenario fails only where the run violates the property
    let (exit, out, err) = run(&["test", &scenario]);
    assert_eq!(exit, 1, "{out}{err}");
    assert!(
        format!("{out}{err}").contains("mode != ARRIVED"),
        "{out}{err}"
    );
    let states = std::fs::read_to_string(&states).unwrap();
    let states: serde_json::Value = serde_json::from_str(&states).unwrap();
    assert!(states["states"].as_array().is_some_and(|it| it.len() > 3));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn options_of_composites_are_refused_where_they_have_no_effect() {
    for arguments in [
        vec!["verify", LAMP, "--component", "Lamp"],
        vec!["verify", NAVIGATION, "--component", "Nobody"],
        vec!["verify", NAVIGATION, "--profile", "none"],
        vec!["verify", NAVIGATION, "--set", "place"],
        vec!["verify", NAVIGATION, "--set", "nothing=1"],
        vec!["verify", NAVIGATION, "--environment", "hold"],
        vec!["verify", NAVIGATION, PHILOSOPHERS, "--trace", "run.trace"],
        vec!["verify", "nowhere.composite.toml"],
    ] {
        let (exit, out, err) = run(&arguments);
        assert_eq!(exit, 2, "{arguments:?}: {out}{err}");
    }
}

#[test]
fn verdicts_do_not_depend_on_threads_and_say_what_storage_they_depend_on() {
    const RECOVERY: &str = "specs/recovery/recovery.asm";
    // with an environment, states are no words, which would be smaller than fingerprints
    const ESTOP: &str = "specs/estop/estop.asm";
    let (_, one, _) = run(&["verify", PHILOSOPHERS, "--threads", "1"]);
    let (_, many, _) = run(&["verify", PHILOSOPHERS, "--threads", "5"]);
    assert_eq!(without_time(&one), without_time(&many));
    let (exit, exact, _) = run(&["verify", RECOVERY]);
    let (disk_exit, disk, _) = run(&["verify", RECOVERY, "--storage", "disk"]);
    assert_eq!(
        (exit, without_time(&exact)),
        (disk_exit, without_time(&disk))
    );
    let (exit, out, err) = run(&[
        "verify",
        ESTOP,
        "--environment",
        "hold",
        "--storage",
        "compact",
    ]);
    assert_eq!(exit, 4, "{out}{err}");
    let holds = out.lines().filter(|line| line.starts_with("  holds"));
    for line in holds {
        assert!(
            line.starts_with("  holds unless a state was missed:"),
            "{out}"
        );
    }
    assert!(
        out.contains("expected number of states that were missed is"),
        "{out}"
    );
    let (exit, out, _) = run(&[
        "verify",
        ESTOP,
        "--environment",
        "hold",
        "--storage",
        "compact",
        "--json",
    ]);
    assert_eq!(exit, 4);
    assert!(!out.contains("\"verdict\":\"holds\""), "{out}");
    assert!(out.contains("\"verdict\":\"holds-unless-missed\""), "{out}");
}

#[test]
fn a_limit_of_memory_says_how_large_it_is_and_where_it_comes_from() {
    let (exit, out, _) = run(&["verify", PHILOSOPHERS, "--memory", "0"]);
    assert_eq!(exit, 4, "{out}");
    let reason = "the memory reached its limit of 0 MiB, which `--memory` sets";
    assert!(out.contains(reason), "{out}");
    let (_, out, _) = run(&["verify", "--help"]);
    assert!(out.contains("[default: half"), "{out}");
}

#[test]
fn storage_that_fails_or_does_not_fit_is_refused() {
    let missing = [
        "verify",
        PHILOSOPHERS,
        "--storage",
        "disk",
        "--storage-folder",
    ];
    let (exit, _, err) = run(&[&missing[..], &["/nonexistent/folder"]].concat());
    // a small exploration needs no file
    assert!(exit == 1 && !err.contains("M013"), "{err}");
    for arguments in [
        &["--storage-folder", "/tmp"][..],
        &["--storage", "compact", "--mutants"],
        &["--storage", "compact", "--advice"],
    ] {
        let (exit, _, err) = run(&[&["verify", LAMP][..], arguments].concat());
        assert_eq!(exit, 2, "{arguments:?}: {err}");
    }
    let (exit, _, err) = run(&["verify", LAMP, "--threads", "0"]);
    assert_eq!(exit, 2, "{err}");
}

#[test]
fn a_cone_says_which_locations_are_left_out_and_nothing_about_paths() {
    let recovery = "specs/recovery/recovery.asm";
    let property = ["--property", "ag(mode = WAIT iff outstanding)"];
    let (exit, out, err) =
        run(&[&["verify", recovery, "--cone", "--json"], &property[..]].concat());
    assert_eq!((exit, err.as_str()), (0, ""), "{out}");
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let left_out = ["sendCall", "cancelCall", "recovery", "nextRec"];
    assert_eq!(json["left_out"], serde_json::json!(left_out));
    assert_eq!((&json["states"], &json["ends"]), (&16.into(), &0.into()));
    let (exit, out, _) = run(&[&["verify", recovery, "--cone"], &property[..]].concat());
    assert_eq!(exit, 0);
    let note = "note locations were left out on which the properties do not depend: of sendCall,";
    assert!(
        out.contains(note) && !out.contains("no step leads on"),
        "{out}"
    );
    // the general properties are about all locations
    let (exit, _, err) = run(&["verify", recovery, "--cone"]);
    assert!(exit == 2 && err.contains("needs `--property`"), "{err}");
}

#[test]
fn independent_steps_are_executed_in_one_order() {
    let text = "asm counters
import StandardLibrary
signature:
  enum domain Agents = {A1 | A2 | A3}
  domain Number subsetof Integer
  controlled n: Agents -> Number
  controlled rang: Boolean
definitions:
  domain Number = {0 : 4}
  main rule r_Main = choose $a in Agents with n($a) < 4 do
    par
      n($a) := n($a) + 1
      if $a = A3 and n($a) = 3 then rang := true endif
    endpar
default init s0:
  function n($a in Agents) = 0
  function rang = false
";
    let (_folder, path) = file("counters.asm", text);
    let states = |arguments: &[&str]| {
        let property = ["verify", &path, "--json", "--property", "rang or not rang"];
        let (exit, out, err) = run(&[&property[..], arguments].concat());
        assert_eq!((exit, err.as_str()), (0, ""), "{out}");
        let json: serde_json::Value = serde_json::from_str(&out).unwrap();
        (
            json["states"].as_u64().unwrap(),
            json["has_left_out_steps"].clone(),
        )
    };
    assert_eq!(states(&[]), (125, false.into()));
    let (few, has_left_out) = states(&["--independent"]);
    assert!(few < 30 && has_left_out == true, "{few}");
    // the last state is stuck, which is shown by a run of all
    let (exit, out, _) = run(&["verify", &path, "--independent"]);
    assert!(
        exit == 1
            && out.contains("note `--independent` has no effect: ")
            && out.contains("125 states"),
        "{out}"
    );
    let (exit, _, err) = run(&["verify", &path, "--independent", "--symmetry"]);
    assert!(exit == 2 && err.contains("without `--symmetry`"), "{err}");
}

/// Several specifications have the results that they have without reductions, which say why they do nothing.
#[test]
fn reductions_say_that_they_are_for_one_specification() {
    let system = [
        "verify",
        "--together",
        "specs/courier/courier.asm",
        "specs/courier/dispatcher.asm",
        "--bound",
        "8",
        "--property",
        "courier.jobs <= 1",
    ];
    let verdict = |out: &str| out.lines().nth(1).map(ToOwned::to_owned);
    let (plain_exit, plain, _) = run(&system);
    for option in ["--independent", "--symmetry", "--cone"] {
        let (exit, out, err) = run(&[&system[..], &[option]].concat());
        assert_eq!((exit, err.as_str()), (plain_exit, ""), "{out}");
        assert_eq!(verdict(&out), verdict(&plain), "{out}");
        let note = format!("note `{option}` has no effect: it is for one specification");
        assert!(out.contains(&note), "{out}");
    }
}

#[test]
fn symmetry_names_the_domains_and_says_when_it_has_no_effect() {
    let text = "asm workers
import StandardLibrary
signature:
  enum domain Worker = {ANN | BOB | CID}
  enum domain State = {IDLE | BUSY}
  controlled state: Worker -> State
definitions:
  invariant one over state: not (forall $w in Worker with state($w) = BUSY)
  main rule r_Main = choose $w in Worker with state($w) = IDLE do state($w) := BUSY
default init s0:
  function state($w in Worker) = IDLE
";
    let (_folder, path) = file("workers.asm", text);
    let states = |arguments: &[&str]| {
        let (exit, out, err) = run(&[&["verify", &path, "--json"], arguments].concat());
        assert_eq!((exit, err.as_str()), (1, ""), "{out}");
        let json: serde_json::Value = serde_json::from_str(&out).unwrap();
        (json["states"].clone(), json["symmetric"].clone())
    };
    let nothing = serde_json::json!([]);
    assert_eq!(states(&[]), (8.into(), nothing));
    let (few, symmetric) = states(&["--symmetry"]);
    assert_eq!(few, 4);
    assert!(symmetric.to_string().contains("Worker"), "{symmetric}");
    let allocation = "specs/allocation/allocation.asm";
    let (exit, out, _) = run(&["verify", allocation, "--symmetry"]);
    assert!(
        exit == 0 && out.contains("note `--symmetry` has no effect: "),
        "{out}"
    );
}
