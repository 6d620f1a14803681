//! Simulating specifications.

use super::{file, run};

#[test]
fn sim_takes_its_inputs_by_name() {
    let script = "[default]\nestop = false\ncancelArrived = false\ngoalArrived = false\nevent = \"NOTHING\"\n\
                  [[step]]\ngoalArrived = true\n[[step]]\nevent = \"MAP_OK\"\n[[step]]\nevent = \"PATH_OK\"\n";
    let (_folder, path) = file("inputs.toml", script);
    let (code, out, err) = run(&[
        "sim",
        "specs/navigation/navigate.asm",
        "--env",
        &path,
        "--quiet",
    ]);
    assert_eq!(code, 0, "{err}");
    assert!(
        out.contains("mode = FOLLOWING") && out.contains("moving = true"),
        "{out}"
    );
}

#[test]
fn a_script_with_mistakes_says_where_they_are() {
    let (_folder, path) = file(
        "inputs.toml",
        "[default]\nestopp = false\nevent = \"NOTHIN\"\n",
    );
    let (code, _, err) = run(&["sim", "specs/navigation/navigate.asm", "--env", &path]);
    assert_eq!(code, 2);
    assert!(err.contains("did you mean `estop`?"), "{err}");
    assert!(err.contains("inputs.toml:3:9"), "{err}");
}

#[test]
fn what_lies_outside_its_domain_is_told_unless_the_reference_is_followed() {
    let text = "asm levels
import StandardLibrary
signature:
  domain Level subsetof Integer
  monitored wish: Level
  controlled level: Level
  controlled n: Integer
definitions:
  domain Level = {$l in {0 : 9} | $l != 5 : $l}
  main rule r_Main = n := wish
default init s0:
  function level = 12
";
    let (folder, path) = file("levels.asm", text);
    let script = folder.path().join("levels.toml").display().to_string();
    std::fs::write(&script, "[default]\nwish = 5\n").unwrap();
    let sim = ["sim", &path, "--env", &script, "--steps", "1"];
    let compatible = ["--compat", "asmeta"];

    let (code, out, err) = run(&["check", &path]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(
        err.contains("W030") && err.contains("initial value of `level`"),
        "{err}"
    );
    let (code, out, err) = run(&sim);
    assert_eq!(code, 3, "{out}{err}");
    assert!(err.contains("W030") && err.contains("R022"), "{err}");
    assert!(
        err.contains("the value came from `[default]` in the script"),
        "{err}"
    );

    let (code, _, err) = run(&[&["check", &path], &compatible[..]].concat());
    assert_eq!((code, err.contains("W030")), (0, false), "{err}");
    let (code, out, err) = run(&[&sim[..], &compatible[..]].concat());
    assert_eq!((code, err.contains("W030")), (0, false), "{out}{err}");
    assert!(out.contains("n := 5"), "{out}");
}

#[test]
fn the_same_seed_simulates_the_same_run() {
    let sim = |seed: &str| {
        run(&[
            "sim",
            "specs/allocation/allocation.asm",
            "--steps",
            "40",
            "--seed",
            seed,
        ])
        .1
    };
    assert_eq!(sim("3"), sim("3"));
    assert_ne!(sim("3"), sim("4"));
}

#[test]
fn a_step_that_fails_exits_with_3_and_shows_both_writers() {
    let clash = "asm clash\nimport StandardLibrary\nsignature:\n  controlled x: Integer\ndefinitions:\n  \
                 main rule r_Main = par x := 1 x := 2 endpar\n";
    let (_folder, path) = file("clash.asm", clash);
    let (code, _, err) = run(&["sim", &path]);
    assert_eq!(code, 3);
    assert!(
        err.contains("inconsistent update of `x` in step 1"),
        "{err}"
    );
    assert!(
        err.contains("writes 2") && err.contains("writes 1 in the same step"),
        "{err}"
    );
}

#[test]
fn a_step_that_fails_shows_the_values_at_hand() {
    let text = "asm drive\nimport StandardLibrary\nsignature:\n  domain Speed subsetof Integer\n  \
                enum domain Robot = {ROB_A | ROB_B}\n  monitored wish: Robot -> Integer\n  \
                controlled speed: Robot -> Speed\ndefinitions:\n  domain Speed = {0 : 9}\n  \
                rule r_drive($r in Robot) = speed($r) := wish($r) + 1\n  \
                main rule r_Main = forall $x in Robot do r_drive[$x]\n";
    let (folder, path) = file("drive.asm", text);
    let inputs = folder.path().join("inputs.toml");
    std::fs::write(
        &inputs,
        "[[step]]\n\"wish(ROB_A)\" = 3\n\"wish(ROB_B)\" = 12\n",
    )
    .unwrap();
    let (code, _, err) = run(&["sim", &path, "--env", &inputs.display().to_string()]);
    assert_eq!(code, 3, "{err}");
    for said in [
        "13 is not an element of `Speed`",
        "at this point, `$r` = ROB_B, `$x` = ROB_B, `wish($r)` = 12",
        "called here",
        "inputs of the step: `wish(ROB_A)` = 3, `wish(ROB_B)` = 12",
    ] {
        assert!(err.contains(said), "{said}: {err}");
    }
}

#[test]
fn a_trace_replays_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (first, again) = (path("first.trace"), path("again.trace"));
    let spec = "specs/allocation/allocation.asm";
    let (code, _, err) = run(&[
        "sim", spec, "--seed", "5", "--steps", "30", "--trace", &first, "-q",
    ]);
    assert_eq!(code, 0, "{err}");
    let (code, _, err) = run(&[
        "sim",
        spec,
        "--replay-inputs",
        &first,
        "--trace",
        &again,
        "-q",
    ]);
    assert_eq!(code, 0, "{err}");
    let text = std::fs::read_to_string(&first).unwrap();
    assert_eq!(
        text.matches("@step").count(),
        30,
        "as many steps as were recorded"
    );
    assert!(text.contains("\nM "), "inputs are recorded");
    assert_eq!(text, std::fs::read_to_string(&again).unwrap());
}

#[test]
fn a_trace_of_another_specification_is_a_wrong_usage() {
    let (_folder, trace) = file("wrong.trace", "@step 1\nM wings = 2\n");
    let (code, _, err) = run(&["sim", "specs/patrol/patrol.asm", "--replay-inputs", &trace]);
    assert_eq!(code, 2);
    assert!(err.contains("`wings = 2`"), "{err}");
}

#[test]
fn a_folder_of_specifications_is_simulated_file_by_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, body: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, body).unwrap();
    };
    let header = "import StandardLibrary\nsignature:\n  controlled n: Integer\ndefinitions:\n";
    write(
        "a/runs.asm",
        &format!("asm runs {header} main rule r_Main = n := 1\n"),
    );
    write(
        "a/lib.asm",
        "module lib import StandardLibrary export * signature: definitions: rule r_x = skip",
    );
    write(
        "clash.asm",
        &format!("asm clash {header} main rule r_Main = par n := 1 n := 2 endpar\n"),
    );
    write(
        "wrong.asm",
        &format!("asm wrong {header} main rule r_Main = m := 1\n"),
    );
    let path = folder.path().display().to_string();
    let traces = tempfile::tempdir().unwrap();
    let (code, out, err) = run(&[
        "sim",
        &path,
        "--steps",
        "3",
        "--trace",
        &traces.path().display().to_string(),
    ]);
    assert_eq!(code, 3, "{out}{err}");
    insta::assert_snapshot!(out, @"
      module a/lib.asm
          ok a/runs.asm
       fault clash.asm: R001 inconsistent update of `n` in step 1
    rejected wrong.asm: A001 unknown function `m`
    ");
    assert!(
        err.contains(
            "4 specifications, 4 steps: 1 ran, 1 stopped by a fault, 1 rejected, 1 module"
        ),
        "{err}"
    );
    let trace = std::fs::read_to_string(traces.path().join("clash.trace")).unwrap();
    assert!(
        trace.ends_with("@error CLASH\n@end CLASH\nI n = undef\n"),
        "{trace}"
    );
}

#[test]
fn a_script_plays_a_partner() {
    let courier = "specs/courier/courier.asm";
    let script = "specs/courier/courier.late.env.toml";
    let (code, out, err) = run(&["sim", courier, "--env", script]);
    assert_eq!(code, 0, "{err}");
    let asked = out.find("-> dispatcher: call job(0)").unwrap();
    let answered = out.find("goal := 2").unwrap();
    let reported = out.find("-> dispatcher: done(2)").unwrap();
    assert!(asked < answered && answered < reported, "{out}");
}
