//! `asmotion verify` with inputs that have no finite domain.

use super::{file, run};

const BRAKING: &str = "asm braking
import StandardLibrary
import CTLLibrary
signature:
  monitored distance: Integer
  monitored slope: Real
  monitored order: String
  controlled brakes: Boolean
  controlled limit: Integer
definitions:
  CTLSPEC stops: ag(distance < 5 implies ax(brakes))
  main rule r_Main = par
    brakes := distance < limit and slope <= 0.5
    switch order
      case \"careful\": limit := 20
      case \"fast\": limit := 10
    endswitch
  endpar
default init s0:
  function brakes = false
  function limit = 10
";

#[test]
fn compared_inputs_have_representatives_and_violations_are_repeated_by_sim() {
    let (folder, path) = file("braking.asm", BRAKING);
    let trace = folder.path().join("run.trace").display().to_string();
    let scenario = folder.path().join("run.avalla").display().to_string();
    let (exit, out, err) = run(&["verify", &path, "--trace", &trace, "--avalla", &scenario]);
    assert_eq!(exit, 1, "{out}{err}");
    let notes: Vec<&str> = out
        .lines()
        .filter(|it| it.contains("is only compared"))
        .collect();
    insta::assert_snapshot!("represented", notes.join("\n"));
    let (exit, out, err) = run(&["sim", &path, "--replay-inputs", &trace]);
    assert_eq!(exit, 0, "{out}{err}");
    assert!(out.contains("slope = 1.5"), "{out}");
    let (exit, out, err) = run(&["test", &scenario]);
    assert_eq!(exit, 1, "{out}{err}");
    // machines read the same
    let (_, out, _) = run(&["verify", &path, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let distance = &json["represented"][0];
    assert_eq!(distance["function"], "distance");
    assert_eq!(distance["values"][0]["value"], "4");
    assert_eq!(distance["values"][0]["stands_for"], "all below 5");
    assert_eq!(distance["values"][1]["stands_for"], serde_json::Value::Null);
}

#[test]
fn inputs_whose_values_matter_are_refused_or_given_values() {
    let text = BRAKING.replace("brakes := distance", "brakes := distance + 1");
    let (_folder, path) = file("braking.asm", &text);
    let (exit, out, err) = run(&["verify", &path]);
    assert_eq!((exit, out.as_str()), (1, ""));
    assert!(
        err.contains("M001") && err.contains("--values distance="),
        "{err}"
    );
    assert!(err.contains("`+` computes with its value here"), "{err}");
    let (exit, out, err) = run(&["verify", &path, "--values", "distance=0, 9, 10"]);
    assert_eq!((exit, err.as_str()), (1, ""), "{out}");
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

/// Runs a verification with at most this much memory, in MiB.
#[cfg(target_os = "linux")]
fn limited(mib: u64, path: &str) -> (Option<i32>, String) {
    let command = format!("ulimit -v {}; exec \"$0\" verify \"$1\"", mib * 1024,);
    let output = std::process::Command::new("sh")
        .args(["-c", &command, env!("CARGO_BIN_EXE_asmotion"), path])
        .output()
        .unwrap();
    let out = String::from_utf8(output.stdout).unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), out + &err)
}

/// A step with 2^40 combinations of inputs has a way out, and needs little memory to say so.
#[cfg(target_os = "linux")]
#[test]
fn too_many_inputs_in_a_step_are_refused_with_little_memory() {
    let cells = "asm cells
import StandardLibrary
signature:
  domain Cell subsetof Integer
  monitored occupied: Cell -> Boolean
  controlled isFree: Boolean
definitions:
  domain Cell = {1:40}
  main rule r_Main = isFree := (forall $c in Cell with occupied($c) or not occupied($c))
";
    let number = "asm number
import StandardLibrary
signature:
  domain Wide subsetof Integer
  monitored number: Wide
  controlled last: Wide
definitions:
  domain Wide = {0 : 1099511627776}
  main rule r_Main = last := number
";
    for (name, text, code, way_out) in [
        ("cells.asm", cells, "M002", "use smaller domains"),
        ("number.asm", number, "M001", "--values number="),
    ] {
        let (_folder, path) = file(name, text);
        let (exit, output) = limited(600, &path);
        assert_eq!(exit, Some(1), "{output}");
        assert!(
            output.contains(code) && output.contains(way_out),
            "{output}"
        );
    }
}
