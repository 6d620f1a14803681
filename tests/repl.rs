//! Sessions of `asmotion repl`.

use std::path::Path;

/// The output for these input lines.
fn talk(arguments: &[&str], lines: &str) -> String {
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("repl");
    let output = command.args(arguments).write_stdin(lines).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

const NAVIGATE: &str = "specs/navigation/navigate.asm";

/// Inputs with which the first step succeeds.
const INPUTS: &str = "set goalArrived := true\nset estop := false\nset cancelArrived := false\nset event := NOTHING\n";

#[test]
fn it_steps_and_tells_what_was_read_and_written() {
    let lines = format!("{INPUTS}watch mode\nstep\nmode = WAIT_MAP and tries < maxTries\n");
    insta::assert_snapshot!(talk(&[NAVIGATE], &lines));
}

#[test]
fn it_says_who_wrote_a_location_last() {
    let lines = format!(
        "{INPUTS}step\nset goalArrived := false\nset event := MAP_OK\nstep\nwho mode\nwho moving\nfire mode := FAILED\nwho mode\nset tries := 2\nwho tries\n"
    );
    insta::assert_snapshot!(talk(&[NAVIGATE], &lines));
}

#[test]
fn it_undoes_any_number_of_events() {
    let lines = "run 500\nundo 499\nstate\nundo 1000\nstate\nstep 1\nstate\n";
    let out = talk(&["specs/patrol/patrol.asm", "--random"], lines);
    let first: Vec<&str> = out.split("499 undone, 1 steps left\n").collect();
    let after_first = first[1].split("1 undone").next().unwrap();
    assert!(
        out.trim_end().ends_with(after_first.trim_end()),
        "the first step does the same again: {out}"
    );
    assert!(out.contains("1 undone, 0 steps left"), "{out}");
}

#[test]
fn a_run_stops_at_a_location_a_rule_and_a_condition() {
    let lines = format!(
        "{INPUTS}break r_enter\nrun\nset goalArrived := false\nset event := MAP_OK\nunbreak 1\nbreak if mode = WAIT_PATH\nbreak moving\nrun\nset event := PATH_OK\nrun\n"
    );
    insta::assert_snapshot!(talk(&[NAVIGATE], &lines));
}

#[test]
fn a_run_stops_at_a_rule_that_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("idle.asm");
    let text = "asm idle import StandardLibrary signature: controlled n: Integer definitions:
      rule r_idle = skip
      main rule r_Main = par n := n + 1 if n mod 3 = 2 then r_idle[] endif endpar
      default init s0: function n = 0";
    std::fs::write(&path, text).unwrap();
    let lines = "break r_idle\nrun\nn\nn + 1\nrun\nn\nundo 2\nrun\nn\n";
    let out = talk(&[&path.display().to_string()], lines);
    assert_eq!(out.matches("break: `r_idle` ran").count(), 3, "{out}");
    let values: Vec<&str> = out
        .lines()
        .filter(|line| line.parse::<u64>().is_ok())
        .collect();
    assert_eq!(values, ["3", "4", "6", "6"], "{out}");
}

#[test]
fn what_goes_wrong_is_told_and_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clash.asm");
    let text =
        "asm clash import StandardLibrary signature: monitored m: Integer controlled n: Integer
      definitions: main rule r_Main = par n := m if m > 1 then n := 0 endif endpar";
    std::fs::write(&path, text).unwrap();
    let lines = "step\nset m := 1\nstep\nset m := 2\nstep\nn\nwings\nset n + 1\nhistory\n";
    let out = talk(&[&path.display().to_string()], lines);
    insta::assert_snapshot!(out);
}

#[test]
fn what_happened_is_saved_as_a_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("found.avalla");
    let lines = format!(
        "{INPUTS}step\nset goalArrived := false\nset event := MAP_OK\nstep\nfire tries := 1\nsave {}\n",
        path.display()
    );
    talk(&[NAVIGATE], &lines);
    let saved = std::fs::read_to_string(&path).unwrap();
    let home = Path::new(env!("CARGO_MANIFEST_DIR"))
        .canonicalize()
        .unwrap();
    let saved = saved.replace(&home.display().to_string(), "HOME");
    insta::assert_snapshot!(saved);
}

#[test]
fn a_saved_scenario_names_what_extend_added() {
    let folder = tempfile::tempdir().unwrap();
    let text = "asm orders import StandardLibrary signature: abstract domain Order
      controlled size: Order -> Integer controlled last: Order
      definitions: main rule r_Main = extend Order with $o do par size($o) := 3 last := $o endpar
      default init s0: function size($o in Order) = 0";
    std::fs::write(folder.path().join("orders.asm"), text).unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let lines = format!(
        "step\nstep\nset size(order!1) := 4\nstep\nsave {}\n",
        path("found.avalla")
    );
    talk(&[&path("orders.asm")], &lines);
    let saved = std::fs::read_to_string(path("found.avalla")).unwrap();
    assert!(saved.contains("check last = order!2;"), "{saved}");
    assert!(saved.contains("exec size(order!1) := 4;"), "{saved}");
    let mut test = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = test.args(["test", &path("found.avalla")]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{saved}{output:?}");
}

#[test]
fn a_recorded_run_is_stepped_back_and_forth() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("run.trace").display().to_string();
    let spec = "asm-lang/verify/tests/models/lamp.asm";
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let verify = ["verify", spec, "--property", "level < 2", "--trace", &trace];
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command.args(verify).assert().code(1);
    let lines = "step\nlevel\nstep\nlevel\nundo\nlevel\nstep\nlevel\nstep 5\nundo 9\nset isPressed := false\nset isLocked := true\nstep\nlevel\nundo 3\nrun\nlevel\n";
    let out = talk(&[spec, "--from", &trace], lines);
    let levels: Vec<&str> = out.lines().filter(|line| line.len() == 1).collect();
    assert_eq!(levels, ["1", "2", "1", "2", "0", "2"], "{out}");
    let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let missing = ["repl", spec, "--from", "nowhere.trace"];
    command.args(missing).assert().code(2);
}
