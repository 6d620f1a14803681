//! `asmotion verify --engine symbolic`.

use super::{file, run};

const LAMP: &str = "asm-lang/verify/tests/models/lamp.asm";

#[test]
fn its_results_are_those_of_the_explicit_engine() {
    let json = |engine: &str| {
        let (exit, out, err) = run(&["verify", LAMP, "--engine", engine, "--json"]);
        assert_eq!((exit, err.as_str()), (1, ""));
        serde_json::from_str::<serde_json::Value>(&out).unwrap()
    };
    let (explicit, symbolic) = (json("explicit"), json("symbolic"));
    for key in [
        "states",
        "transitions",
        "depth",
        "excluded",
        "incomplete",
        "ends",
    ] {
        assert_eq!(symbolic[key], explicit[key], "{key}");
    }
    let verdicts = |json: &serde_json::Value| -> Vec<(String, String)> {
        let properties = json["properties"].as_array().unwrap().iter();
        properties
            .map(|it| (it["text"].to_string(), it["verdict"].to_string()))
            .collect()
    };
    assert_eq!(verdicts(&symbolic), verdicts(&explicit));
}

#[test]
fn its_runs_are_repeated_by_other_commands() {
    let (folder, trace) = file("run.trace", "");
    let scenario = folder.path().join("run.avalla").display().to_string();
    let itf = folder.path().join("run.itf.json").display().to_string();
    let arguments = ["--engine", "symbolic", "--property", "level < 3"];
    let exports = ["--trace", &trace, "--avalla", &scenario, "--itf", &itf];
    let (exit, out, err) = run(&[&["verify", LAMP][..], &arguments, &exports].concat());
    assert_eq!(exit, 1, "{out}{err}");
    let (exit, _, err) = run(&["sim", LAMP, "--replay-inputs", &trace, "--quiet"]);
    assert_eq!(exit, 0, "{err}");
    let (exit, out, err) = run(&["test", &scenario]);
    assert_eq!(exit, 1, "{out}{err}");
    assert!(err.contains("check level < 3;"), "{err}");
    let text = std::fs::read_to_string(&itf).unwrap();
    let itf: serde_json::Value = serde_json::from_str(&text).unwrap();
    let states = itf["states"].as_array().unwrap();
    assert_eq!(states.last().unwrap()["level"]["#bigint"], "3");
}

#[test]
fn memory_that_is_not_sufficient_leaves_properties_unknown() {
    let names: Vec<String> = (0..24).map(|index| format!("a{index}")).collect();
    let declared: Vec<String> = names
        .iter()
        .map(|it| format!("  controlled {it}: Wide\n"))
        .collect();
    // operands that are far from each other in the order of variables
    let products: Vec<String> = (0..23)
        .map(|index| {
            let other = (index + 12) % 24;
            format!("    a{index} := (a{index} * a{other} + 7) mod 128\n")
        })
        .collect();
    let initial: Vec<String> = names
        .iter()
        .map(|it| format!("  function {it} = 3\n"))
        .collect();
    let text = format!(
        "asm products\nimport StandardLibrary\nsignature:\n  domain Wide subsetof Integer\n  monitored next: Wide\n{}definitions:\n  \
         domain Wide = {{0:127}}\n  invariant small over a0: a0 < 128\n  main rule r_Main = par\n{}    a23 := next\n  endpar\n\
         default init s0:\n{}",
        declared.concat(),
        products.concat(),
        initial.concat()
    );
    let (_folder, path) = file("products.asm", &text);
    let (exit, out, err) = run(&["verify", &path, "--engine", "symbolic", "--memory", "1"]);
    assert_eq!(exit, 4, "{out}{err}");
    assert!(out.contains("unknown") && out.contains("memory"), "{out}");
}

#[test]
fn more_states_than_a_number_holds_are_no_number() {
    let text = "asm lamps
import StandardLibrary
signature:
  domain Lamp subsetof Integer
  monitored switched: Lamp -> Boolean
  controlled lit: Lamp -> Boolean
definitions:
  domain Lamp = {0 : 69}
  invariant inv over lit: not (lit(0) and not lit(0))
  main rule r_Main = forall $l in Lamp with true do lit($l) := switched($l)
default init s0:
  function lit($l in Lamp) = false
";
    let (_folder, path) = file("lamps.asm", text);
    let symbolic = ["verify", path.as_str(), "--engine", "symbolic"];
    let (exit, out, err) = run(&symbolic);
    assert_eq!(exit, 0, "{out}{err}");
    assert!(out.contains(": more than 10^19 states, "), "{out}");
    let (_, out, _) = run(&[&symbolic[..], &["--json"]].concat());
    let result: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert!(result["states"].is_null(), "{out}");
    assert_eq!(result["excluded"], 0);
    // the number is no limit for mutants either
    let (exit, out, err) = run(&[&symbolic[..], &["--mutants"]].concat());
    assert_eq!(exit, 0, "{out}{err}");
    assert!(out.contains("1 killed, 0 survive"), "{out}");
}
