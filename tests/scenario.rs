//! `asmotion test`: the results of scenarios, and the diagnostics of failures.

mod corpus;

use assert_cmd::Command;
use std::path::Path;

/// A small specification, and scenarios about it.
const DOOR: &str = "asm door
import StandardLibrary
signature:
  enum domain Mode = {OPEN | CLOSED | LOCKED}
  domain Count subsetof Integer
  monitored push: Boolean
  monitored key: Boolean
  controlled mode: Mode
  controlled count: Count
  controlled guest: Integer
definitions:
  domain Count = {0 : 2}
  rule r_admit = choose $g in {1 : 9} with $g mod 2 = 0 do guest := $g
  invariant inv_count over count: count < 2 or mode != LOCKED
  main rule r_Main =
    if push then
      switch mode
        case OPEN: mode := CLOSED
        case CLOSED:
          if key then mode := LOCKED
          else par mode := OPEN count := count + 1 r_admit[] endpar endif
      endswitch
    endif
default init s0:
  function mode = CLOSED
  function count = 0
";

/// Runs `asmotion test` in a folder with these files: exit code, standard output, standard error.
fn test(files: &[(&str, &str)], arguments: &[&str]) -> (i32, String, String) {
    let folder = folder(files);
    run(folder.path(), arguments, "", false)
}

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("door.asm"), DOOR).unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn run(folder: &Path, arguments: &[&str], input: &str, on_server: bool) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(folder).arg("test").args(arguments);
    command
        .env_remove("FORCE_COLOR")
        .env_remove("CLICOLOR_FORCE");
    command.env("CI", if on_server { "true" } else { "" });
    let output = command.write_stdin(input).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

/// A scenario about the door.
fn about(commands: &str) -> String {
    format!("scenario s\nload door.asm\n{commands}\n")
}

/// The verdict on a scenario about the door.
fn verdict(commands: &str) -> String {
    verdict_as(commands, &[])
}

fn verdict_as(commands: &str, arguments: &[&str]) -> String {
    let (_, out, error) = test(&[("s.avalla", &about(commands))], arguments);
    let word = out.split_whitespace().next();
    word.map_or(error, str::to_owned)
}

/// The output for a scenario about the door, without the summary.
fn said(commands: &str) -> String {
    let (_, out, error) = test(&[("s.avalla", &about(commands))], &[]);
    format!("{out}{}", uncounted(&error))
}

/// Removes the summary line, which contains the duration.
fn uncounted(error: &str) -> String {
    let lines = error.lines();
    let lines: Vec<&str> = lines
        .filter(|line| !line.trim_start().starts_with("Tested"))
        .collect();
    lines.join("\n")
}

#[test]
fn our_own_specifications_keep_their_scenarios() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (code, out, error) = run(root, &["specs"], "", true);
    assert_eq!(code, 0, "{out}{error}");
    let tested = [
        "allocation",
        "estop",
        "nav2",
        "navigation",
        "patrol",
        "recovery",
        "youbot",
    ];
    for specification in tested {
        assert!(out.contains(&format!("specs/{specification}/")), "{out}");
    }
}

#[test]
fn inputs_keep_their_values_and_are_undef_before() {
    let passes = "check isUndef(push); set push := true; set key := false; step
        check mode = OPEN and push; step check mode = CLOSED;";
    assert_eq!(verdict(passes), "pass");
    assert_eq!(verdict("step"), "fault");
}

#[test]
fn a_check_is_evaluated_where_it_stands() {
    let commands = "set push := true; set key := false; step check push; set push := false; step";
    assert_eq!(verdict(commands), "pass");
    assert_eq!(verdict_as(commands, &["--compat", "asmeta"]), "fail");
}

#[test]
fn step_until_ends_or_is_bounded() {
    let setting = "set push := true; set key := false;";
    assert_eq!(
        verdict(&format!(
            "{setting} step until count = 2; check mode = OPEN;"
        )),
        "pass"
    );
    let endless = format!("{setting} set push := false; step until mode = OPEN;");
    assert_eq!(verdict_as(&endless, &["--max-steps", "5"]), "fail");
}

#[test]
fn exec_writes_what_rules_and_the_environment_own() {
    let commands = "exec par mode := OPEN push := true endpar; check mode = OPEN; step
        check mode = CLOSED and push;";
    assert_eq!(verdict(commands), "pass");
}

#[test]
fn a_pick_decides_one_step_and_must_be_a_candidate() {
    let setting = "set push := true; set key := false;";
    assert_eq!(
        verdict(&format!("{setting} pick $g := 8; step check guest = 8;")),
        "pass"
    );
    assert_eq!(
        verdict(&format!(
            "{setting} pick $g in r_admit := 4; step check guest = 4;"
        )),
        "pass"
    );
    assert_eq!(verdict(&format!("{setting} pick $g := 3; step")), "fail");
    assert_eq!(verdict(&format!("{setting} pick $g := 12; step")), "fail");
}

#[test]
fn what_is_not_picked_is_decided_by_the_seed() {
    let commands = about("set push := true; set key := false; step check guest = 0;");
    let guest = |seed: &str| {
        let (_, _, error) = test(&[("s.avalla", &commands)], &["--seed", seed]);
        let line = error
            .lines()
            .find(|line| line.contains("guest := "))
            .unwrap_or("");
        line.split_once("guest := ")
            .map(|(_, rest)| rest[..1].to_owned())
    };
    assert_eq!(guest("3"), guest("3"));
    let drawn: std::collections::BTreeSet<_> =
        ["1", "2", "3", "4", "5", "6", "7", "8"].map(guest).into();
    assert!(drawn.len() > 1, "{drawn:?}");
}

#[test]
fn invariants_of_both_count() {
    let wide = "invariant low: count < 1;\nset push := true; set key := false; step";
    assert_eq!(verdict(wide), "invariant");
    let broken = "exec count := 2; set push := true; set key := true; step";
    assert_eq!(verdict(broken), "invariant");
    let behind = "set push := false; step exec par count := 2 mode := LOCKED endpar;";
    assert_eq!(verdict(behind), "invariant");
}

#[test]
fn blocks_of_this_and_other_scenarios_are_run() {
    let library = about("begin open set push := true; set key := false; step end");
    let user = about(
        "execblock library:open; check mode = OPEN; begin twice step step end
        check count = 2; set push := false; execblock twice; check count = 2;",
    );
    let files = [
        ("library.avalla", library.as_str()),
        ("user.avalla", user.as_str()),
    ];
    let (code, out, error) = test(&files, &[]);
    assert_eq!(code, 0, "{out}{error}");
}

#[test]
fn clocks_move_on_from_step_to_step() {
    let clock = "asm clock
import StandardLibrary
import TimeLibrary
signature:
  controlled seen: Integer
definitions:
  main rule r_Main = seen := mCurrTimeSecs
";
    let scenario = "scenario s load clock.asm check mCurrTimeSecs = 1; step
        check seen = 1 and mCurrTimeSecs = 2; step check seen = 2; set mCurrTimeSecs := 9; step
        check seen = 9;";
    let (code, out, error) = test(&[("clock.asm", clock), ("s.avalla", scenario)], &[]);
    assert_eq!(code, 0, "{out}{error}");
}

#[test]
fn a_failing_check_shows_the_values_it_read_and_what_was_written() {
    insta::assert_snapshot!(said(
        "set push := true; set key := false; pick $g := 2; step
check mode = OPEN;
check count + 1 > 4 and (mode = CLOSED or push);
check guest = 3;"
    ));
}

#[test]
fn what_goes_wrong_in_a_step_is_told_with_its_place_in_the_scenario() {
    insta::assert_snapshot!(said("set push := true; step"));
}

#[test]
fn a_scenario_that_does_not_fit_its_specification_is_told_why() {
    let commands = "set pusch := true;
set mode := 3;
check count;
pick $h := 1;
pick $g in r_addmit := 1;
pick $g := undef;
execblock nowhere;
execblock elsewhere:nowhere;
begin circle execblock circle; end";
    insta::assert_snapshot!(said(commands));
}

#[test]
fn the_specification_must_be_there_and_run() {
    let missing = "scenario s\nload window.asm\nstep\n";
    let module = "module part\nimport StandardLibrary\nsignature:\ndefinitions:\n";
    let files = [
        ("missing.avalla", missing),
        ("module.avalla", "scenario s\nload part.asm\nstep\n"),
        ("part.asm", module),
    ];
    let (code, out, error) = test(&files, &[]);
    assert_eq!(code, 2);
    insta::assert_snapshot!(format!("{out}{}", uncounted(&error)));
}

#[test]
fn the_exit_code_tells_failing_from_broken() {
    let good = about("set push := false; step");
    let unexpected = about("check mode = OPEN;");
    let (code, ..) = test(&[("good.avalla", &good)], &[]);
    assert_eq!(code, 0);
    let (code, ..) = test(&[("good.avalla", &good), ("bad.avalla", &unexpected)], &[]);
    assert_eq!(code, 1);
    let (code, ..) = test(&[("bad.avalla", &unexpected), ("none.avalla", "")], &[]);
    assert_eq!(code, 2);
    let (code, ..) = test(&[], &[]);
    assert_eq!(code, 2, "there is no scenario");
    let files = [
        ("good.avalla", good.as_str()),
        ("bad.avalla", unexpected.as_str()),
    ];
    let (code, ..) = test(&files, &["--filter", "good"]);
    assert_eq!(code, 0);
}

#[test]
fn results_are_given_to_programs_too() {
    let files = [
        (
            "a.avalla",
            &*about("set push := false; step check count = 0;"),
        ),
        ("b.avalla", &*about("check mode = OPEN;")),
    ];
    let folder = folder(&files);
    let (_, out, _) = run(
        folder.path(),
        &[".", "--json", "--junit", "out.xml"],
        "",
        true,
    );
    insta::assert_snapshot!("results_in_json", out);
    let junit = std::fs::read_to_string(folder.path().join("out.xml")).unwrap();
    assert!(
        junit.contains(r#"tests="2" skipped="0" errors="0" failures="1""#),
        "{junit}"
    );
    assert!(junit.contains("V020"), "{junit}");
}

#[test]
fn what_ran_is_shown_by_rule_and_in_the_margin() {
    let scenario = about("set push := true; set key := false; pick $g := 2; step step");
    let folder = folder(&[("s.avalla", &scenario)]);
    let arguments = [".", "--coverage=lines", "--coverage-out", "out.info"];
    let (_, out, _) = run(folder.path(), &arguments, "", true);
    insta::assert_snapshot!("coverage", out);
    let lcov = std::fs::read_to_string(folder.path().join("out.info")).unwrap();
    insta::assert_snapshot!("coverage_lcov", lcov);
}

#[test]
fn rounds_of_forall_are_told_apart() {
    let spec = "asm rounds
import StandardLibrary
signature:
  monitored upTo: Integer
  controlled f: Integer -> Integer
definitions:
  main rule r_Main = forall $i in {1 : 9} with $i <= upTo do f($i) := upTo
";
    let scenario =
        "scenario s load rounds.asm set upTo := 0; step set upTo := 1; step set upTo := 7; step";
    let files = [("rounds.asm", spec), ("s.avalla", scenario)];
    let (_, out, _) = test(&files, &["--coverage"]);
    assert!(out.contains("1 1 1 of 1"), "{out}");
}

const SCRIPT: &str = "[default]\npush = true\nkey = false\n[[step]]\n[[step]]\n";

#[test]
fn a_snapshot_is_accepted_once_and_holds_from_then_on() {
    let folder = folder(&[("door.twice.env.toml", SCRIPT)]);
    let at = |arguments: &[&str], input: &str| run(folder.path(), arguments, input, false);
    let (code, _, error) = at(&[], "");
    assert_eq!(code, 1, "there is none yet");
    insta::assert_snapshot!("without_a_snapshot", uncounted(&error));
    assert_eq!(at(&["--accept"], "").0, 0);
    assert_eq!(at(&[], "").0, 0);
    let snapshot = folder.path().join("door.twice.snap");
    insta::assert_snapshot!("accepted", std::fs::read_to_string(&snapshot).unwrap());

    std::fs::write(
        folder.path().join("door.asm"),
        DOOR.replace("count + 1", "count + 2"),
    )
    .unwrap();
    let (code, _, error) = at(&[], "");
    assert_eq!(code, 1);
    insta::assert_snapshot!("another_snapshot", uncounted(&error));
    assert_eq!(at(&["--review"], "n\n").0, 1);
    assert_eq!(
        at(&["--review"], "").0,
        1,
        "who says nothing does not accept"
    );
    assert_eq!(at(&["--review"], "y\n").0, 0);
    assert_eq!(at(&[], "").0, 0);
}

#[test]
fn a_build_server_accepts_nothing() {
    let folder = folder(&[("door.twice.env.toml", SCRIPT)]);
    for way in ["--accept", "--review"] {
        let (code, ..) = run(folder.path(), &[".", way], "y\n", true);
        assert_eq!(code, 2);
    }
    assert_eq!(run(folder.path(), &[], "", true).0, 1);
    assert!(!folder.path().join("door.twice.snap").exists());
}

/// Orders are added by `extend`; the third one does not fit.
const ORDERS: &str = "asm orders
import StandardLibrary
signature:
  abstract domain Order
  domain Size subsetof Integer
  monitored wish: Integer
  controlled size: Order -> Size
  controlled next: Order
definitions:
  domain Size = {0 : 9}
  rule r_serve = choose $o in Order with isUndef(size($o)) do par size($o) := wish next := $o endpar
  main rule r_Main = par extend Order with $o do skip r_serve[] endpar
default init s0:
";

#[test]
fn what_extend_added_is_named_as_runs_name_it() {
    let scenario = "scenario s\nload orders.asm\ncheck isUndef(order!1);\nset wish := 3; step step
        check next = order!1 and size(order!1) = 3; check isDef(order!2); check isUndef(order!3);
        set size(order!2) := 7; check size(Order!2) = 7; check (exists $o in Order with $o = order!2);
        exec size(order!1) := 1; step pick $o := order!3; step check next = order!3;";
    let files = [("orders.asm", ORDERS), ("s.avalla", scenario)];
    let (code, out, error) = test(&files, &["s.avalla"]);
    assert_eq!(code, 0, "{out}{error}");
}

#[test]
fn a_fault_after_a_pick_shows_its_values() {
    let two = ORDERS.replace("extend Order with $o do", "extend Order with $o, $p do");
    let scenario = "scenario s\nload orders.asm\nset wish := 3; step step
        set wish := 12; pick $o := order!4; step";
    let files = [("orders.asm", &*two), ("s.avalla", scenario)];
    let (code, out, error) = test(&files, &["s.avalla"]);
    assert_eq!(code, 1, "{out}{error}");
    assert!(error.contains("12 is not an element of `Size`"), "{error}");
    let values = "at this point, `$o` = order!4, `wish` = 12";
    assert!(error.contains(values), "{error}");
}

#[test]
fn snapshot_scenarios_count_in_the_coverage() {
    let script = "[default]\nkey = true\npush = true\n[[step]]\n[[step]]\n";
    let files = [("door.lock.env.toml", script)];
    let (_, out, error) = test(&files, &["--coverage"]);
    let line = out.lines().find(|line| line.contains("r_Main"));
    assert!(
        line.is_some_and(|line| line.contains(" 2 ")),
        "{out}{error}"
    );
}
