//! `asmotion verify`.

use super::{file, run};

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
        "navigation",
        "patrol",
        "recovery",
        "youbot",
    ] {
        let folder = format!("specs/{name}");
        let specification = match name {
            "navigation" => "navigate",
            name => name,
        };
        let (exit, out, err) = run(&["verify", &format!("{folder}/{specification}.asm")]);
        assert_eq!((exit, err.as_str()), (0, ""), "{name}: {out}");
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
    let (exit, _, err) = run(&["verify", "specs/navigation/navigation.composite.toml"]);
    assert_eq!(exit, 2, "{err}");
    let (exit, _, err) = run(&[
        "verify",
        PHILOSOPHERS,
        "--property",
        "ag(phase(0) = EATING)",
    ]);
    assert_eq!(exit, 1, "{err}");
    assert!(err.contains("A005") && err.contains("EATING"), "{err}");
}

#[test]
fn infinite_inputs_are_refused_or_given_values() {
    let text = "asm braking
import StandardLibrary
signature:
  monitored distance: Integer
  controlled brakes: Boolean
definitions:
  invariant inv_brakes over brakes, distance: distance < 5 or not brakes or brakes
  main rule r_Main = brakes := distance < 10
default init s0:
  function brakes = false
";
    let (_folder, path) = file("braking.asm", text);
    let (exit, out, err) = run(&["verify", &path]);
    assert_eq!((exit, out.as_str()), (1, ""));
    assert!(
        err.contains("M001") && err.contains("--values distance="),
        "{err}"
    );
    let (exit, out, err) = run(&["verify", &path, "--values", "distance=0, 9, 10"]);
    assert_eq!((exit, err.as_str()), (0, ""), "{out}");
    assert!(out.contains("assumed distance in {0, 9, 10}"), "{out}");
    for wrong in [
        "distance",
        "brakes=true",
        "nothing=1",
        "distance=true and",
        "distance=\"a\"",
    ] {
        let (exit, _, err) = run(&["verify", &path, "--values", wrong]);
        assert_eq!(exit, 2, "{wrong}: {err}");
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
