//! The command line: arguments, output and exit codes.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

fn asmotion() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
        .env_remove("NO_COLOR")
        .env_remove("FORCE_COLOR")
        .env_remove("CLICOLOR_FORCE");
    command
}

/// Exit code, standard output, standard error.
fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = asmotion().args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

/// Writes a file into a new folder. Returns the folder and the path.
fn file(name: &str, text: impl AsRef<[u8]>) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let path = path.display().to_string();
    (folder, path)
}

const NAVIGATION: &str = "specs/navigation/navigation.composite.toml";

#[test]
fn the_demo_reaches_its_goal_and_says_so() {
    let (code, out, err) = run(&["demo", "--speed", "0"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.starts_with("reached in ARRIVED"), "{out}");
    assert!(err.contains("FOLLOWING → ARRIVED"), "{err}");
    assert!(err.contains("BLOCKED"), "the demo shows a replan: {err}");
}

#[test]
fn the_demo_goes_where_it_is_told() {
    let (code, out, _) = run(&[
        "demo", "--speed", "0", "--goal", "4.2,15.6", "--world", "plain", "--quiet",
    ]);
    assert_eq!(code, 0, "{out}");
    let (code, out, _) = run(&["demo", "--speed", "0", "--goal", "21.1,17.2", "--quiet"]);
    assert_eq!(
        code, 1,
        "the table of the meeting room cannot be reached: {out}"
    );
}

#[test]
fn a_goal_that_is_none_is_a_wrong_usage() {
    let (code, _, err) = run(&["demo", "--goal", "kitchen"]);
    assert_eq!(code, 2);
    assert!(err.contains("two numbers are wanted"), "{err}");
    let (code, _, _) = run(&["fly"]);
    assert_eq!(code, 2);
}

#[test]
fn a_composite_runs_from_any_folder_in_virtual_time() {
    let composite = Path::new(env!("CARGO_MANIFEST_DIR")).join(NAVIGATION);
    let elsewhere = tempfile::tempdir().unwrap();
    let mut command = asmotion();
    command
        .current_dir(elsewhere.path())
        .args(["run", "--quiet"])
        .arg(composite);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}

#[test]
fn a_composite_runs_in_wall_time() {
    let (code, out, err) = run(&["run", NAVIGATION, "--clock", "wall", "--for", "3"]);
    assert_eq!(code, 1, "three seconds are not enough: {out}{err}");
    assert!(out.starts_with("time up in FOLLOWING"), "{out}{err}");
    assert!(err.contains("WAIT_PATH → FOLLOWING"), "{err}");
}

#[test]
fn results_as_json_stand_alone_on_standard_output() {
    for arguments in [
        &["run", NAVIGATION, "--json"][..],
        &["sim", "specs/patrol/patrol.asm", "--json"],
        &["check", NAVIGATION, "specs/patrol/patrol.asm", "--json"],
    ] {
        let (code, out, _) = run(arguments);
        assert_eq!(code, 0, "{arguments:?}");
        for line in out.lines() {
            let object: Value = serde_json::from_str(line).unwrap();
            assert_eq!(object["v"], 1, "{line}");
            assert!(object["type"].is_string(), "{line}");
        }
    }
}

#[test]
fn what_ships_has_no_findings() {
    let files: Vec<String> = [
        "navigation",
        "allocation",
        "patrol",
        "recovery",
        "estop",
        "youbot",
    ]
    .iter()
    .flat_map(|folder| std::fs::read_dir(format!("specs/{folder}")).unwrap())
    .map(|entry| entry.unwrap().path().display().to_string())
    .filter(|path| path.ends_with(".asm") || path.ends_with(".composite.toml"))
    .collect();
    assert!(files.len() >= 9, "{files:?}");
    let mut arguments = vec!["check", "--format", "concise"];
    arguments.extend(files.iter().map(String::as_str));
    let (code, out, err) = run(&arguments);
    assert_eq!(code, 0, "{out}{err}");
    assert!(!out.contains("error["), "{out}");
}

/// Two outdated spellings, a foreign symbol, and a name that cannot be fixed automatically.
const OLD: &str = "asm old\nimport StandardLibrary\nsignature:\n  controlled ok: Boolean\ndefinitions:\n  \
                   main rule r_Main = par ok := (exist $x in {1..3} with $x == 2) oc := true endpar\n";

#[test]
fn check_mends_what_is_sure_and_says_what_is_left() {
    let (folder, path) = file("old.asm", OLD);
    let (code, out, err) = run(&["check", "--fix", &path]);
    assert_eq!(code, 1, "`oc` is left: {out}{err}");
    assert!(err.contains("[L070]") && err.contains("[A001]"), "{err}");
    let text = std::fs::read_to_string(&path).unwrap();
    let mended = OLD
        .replace("exist ", "exists ")
        .replace("1..3", "1 : 3")
        .replace("==", "=");
    assert_eq!(text, mended);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn check_shows_what_it_would_mend_and_leaves_the_file() {
    let (_folder, path) = file("old.asm", OLD);
    let (_, out, err) = run(&["check", "--fix", "--diff", &path]);
    assert!(out.contains("\n-  main rule"), "{out}");
    assert!(
        out.contains("\n+  main rule") && out.contains("{1 : 3}"),
        "{out}"
    );
    assert!(err.contains("Would fix"), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), OLD);
}

#[test]
fn a_file_that_cannot_be_rewritten_is_left_as_it_is() {
    let mut bytes = OLD.as_bytes().to_vec();
    bytes.extend(b"// \xff\n");
    let (_folder, path) = file("old.asm", &bytes);
    let (code, out, err) = run(&["check", "--fix", &path]);
    assert_eq!(code, 2, "{out}{err}");
    assert!(err.contains("cannot rewrite"), "{err}");
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
}

#[test]
fn a_script_that_is_missing_is_named() {
    let (code, _, err) = run(&["sim", "specs/patrol/patrol.asm", "--env", "nowhere.toml"]);
    assert_eq!(code, 2);
    insta::assert_snapshot!("a_missing_script", err);
    let (code, _, err) = run(&["check", "nowhere.avalla"]);
    assert_eq!(code, 2);
    insta::assert_snapshot!("a_missing_scenario", err);
}

#[test]
fn check_explains_its_codes() {
    let (code, out, _) = run(&["check", "--explain", "r001"]);
    assert_eq!(code, 0);
    assert!(
        out.starts_with("# R001: ") && out.contains("Mended:"),
        "{out}"
    );
    let (code, out, _) = run(&["check", "--explain"]);
    assert_eq!(code, 0);
    assert!(out.contains("\nC001  Invalid TOML"), "{out}");
    assert!(out.lines().count() > 150, "{out}");
    let (code, _, err) = run(&["check", "--explain", "A1"]);
    assert_eq!(code, 2);
    assert!(err.contains("did you mean `A001`?"), "{err}");
}

#[test]
fn the_page_of_diagnostics_lists_all_codes() {
    let page = std::fs::read_to_string("docs/diagnostics.md").unwrap();
    let listed: Vec<&str> = page
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect();
    let (_, out, _) = run(&["check", "--explain"]);
    let known = out.lines().map(|line| {
        let (code, meaning) = line.split_once("  ").unwrap();
        format!("| `{code}` | {meaning} |")
    });
    assert_eq!(listed, known.collect::<Vec<_>>(), "bring the page along");
}

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
fn bad_input_gets_a_diagnostic_and_no_panic() {
    let nested = format!(
        "asm deep\nsignature:\ndefinitions:\n  main rule r_Main = x := {}1{}\n",
        "(".repeat(10_000),
        ")".repeat(10_000)
    );
    let noise: Vec<u8> = (0..10_000_000u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let self_include = "schema = \"composite/1\"\n[composite]\nname = \"loop\"\n\
                        [components.Again]\nimplementation = { composite = \"loop.composite.toml\" }\n";
    for (name, text) in [
        ("noise.asm", noise.clone()),
        ("deep.asm", nested.into_bytes()),
        (
            "again.asm",
            b"asm again\nimport again\nsignature:\ndefinitions:\n".to_vec(),
        ),
        ("empty.composite.toml", Vec::new()),
        ("noise.composite.toml", noise),
        ("loop.composite.toml", self_include.as_bytes().to_vec()),
    ] {
        let (_folder, path) = file(name, text);
        let (code, out, err) = run(&["check", "--format", "concise", &path]);
        assert_eq!(code, 1, "{name}: {out}{err}");
        assert!(out.contains("error["), "{name}: {out}{err}");
        assert!(!err.contains("panicked"), "{name}: {err}");
        assert!(
            out.len() < 200_000,
            "{name} has {} bytes of findings",
            out.len()
        );
    }
}

const PATROL: &str = "specs/patrol/patrol.asm";

/// The table in `docs/diagnostics.md`, row by row: an unknown name in an argument is a usage error.
#[test]
fn an_argument_that_names_what_is_not_there_is_a_wrong_usage() {
    let run_with = |option: &'static str, value: &'static str| {
        vec!["run", NAVIGATION, "--quiet", option, value]
    };
    for (arguments, said) in [
        (vec!["check", "nowhere.asm"], "file not found"),
        (vec!["check", "nowhere.toml"], "file not found"),
        (vec!["check", "nowhere.avalla"], "file not found"),
        (vec!["sim", "nowhere.asm"], "file not found"),
        (vec!["repl", "nowhere.asm"], "file not found"),
        (vec!["fmt", "nowhere.asm"], "file not found"),
        (vec!["test", "nowhere.avalla"], "file not found"),
        (vec!["run", "nowhere.composite.toml"], "file not found"),
        (
            vec!["sim", PATROL, "--init", "s9"],
            "the initial states are `s0`",
        ),
        (run_with("--set", "sed=2"), "did you mean `seed`?"),
        (
            run_with("--set", "seed=many"),
            "expected an integer for `seed`",
        ),
        (run_with("--set", "Wrld.slip=1"), "did you mean `World`?"),
        (run_with("--set", "World.slp=1"), "did you mean `slip`?"),
        (run_with("--set", "World.slip=\"a\""), "`slip` of `World`"),
        (run_with("--profile", "sim"), "has no profiles"),
        (
            run_with("--until", "mode"),
            "not of the form LOCATION=VALUE",
        ),
        (run_with("--until", "mod=FAILED"), "did you mean `mode`?"),
        (run_with("--unless", "mode=FALED"), "did you mean `FAILED`?"),
        (
            run_with("--until", "mode(1)=FAILED"),
            "takes 0 arguments, not 1",
        ),
        (run_with("--until", "estop=true"), "it is monitored"),
        (run_with("--speed", "NaN"), "a number from 0 is wanted"),
    ] {
        let (code, out, err) = run(&arguments);
        assert_eq!(code, 2, "{arguments:?}: {out}{err}");
        assert!(err.contains(said), "{arguments:?}: {out}{err}");
    }
    let (code, _, err) = run(&["run", NAVIGATION, "--clock", "wall", "--speed", "2"]);
    assert_eq!(code, 2);
    assert!(err.contains("`--speed` is of the virtual clock"), "{err}");
}

#[test]
fn an_error_in_a_file_is_a_finding() {
    let wrong = "asm wrong\nsignature:\ndefinitions:\n  main rule r_Main = x := 1\n";
    let (_folder, specification) = file("wrong.asm", wrong);
    let composite = "schema = \"composite/1\"\n[composite]\n";
    let (_folder2, composite) = file("wrong.composite.toml", composite);
    for arguments in [
        ["check", &specification],
        ["sim", &specification],
        ["repl", &specification],
        ["check", &composite],
        ["run", &composite],
    ] {
        let (code, out, err) = run(&arguments);
        assert_eq!(code, 1, "{arguments:?}: {out}{err}");
    }
}

#[test]
fn a_run_ends_with_what_it_is_told() {
    let until = ["--until", "mode=WAIT_PATH", "--unless", "command=HALT"];
    let (code, out, err) = run(&[&["run", NAVIGATION, "--quiet"], &until[..]].concat());
    assert_eq!(code, 0, "{out}{err}");
    assert!(out.contains("reached in WAIT_PATH"), "{out}");
}

#[test]
fn properties_are_set_as_toml_writes_them() {
    let start = |setting: &str| {
        let limit = ["--for", "2", "--until", "mode=ARRIVED", "--json"];
        let (code, out, err) = run(&[&["run", NAVIGATION, "--set", setting], &limit[..]].concat());
        assert_eq!(code, 1, "two seconds are not enough: {out}{err}");
        out.lines()
            .filter(|line| line.contains("\"to_goal_m\""))
            .count()
    };
    for setting in [
        "start=[1.4, 4.7, 0]",
        "start=1.4,4.7,0",
        "World.start=[1.4, 4.7, 0.0]",
        "World.obstacles=[{ at_s = 0.0, disc = [14.5, 7.3, 0.25] }]",
        "place=office",
    ] {
        assert_eq!(start(setting), 1, "{setting}");
    }
}

#[test]
fn a_seed_needs_no_property_of_the_composite() {
    let (_, _, err) = run(&["run", "specs/youbot/youbot.composite.toml", "--seed", "3"]);
    assert!(!err.contains("C013"), "{err}");
}

#[test]
fn check_knows_every_kind_of_file() {
    let files = [
        "specs/patrol/patrol.avalla",
        "specs/estop/estop.trip.env.toml",
        NAVIGATION,
        PATROL,
    ];
    let (code, out, err) = run(&[&["check"], &files[..]].concat());
    assert_eq!(code, 0, "{out}{err}");
    let types = "schema = \"composite-types/1\"\n[type.\"t/A\"]\nfields = { x = \"f64\" }\n";
    let (_folder, path) = file("types.toml", types);
    assert_eq!(run(&["check", &path]).0, 0);
    let (_folder, types) = file("types.toml", types.replace("f64", "f65"));
    let (code, out, _) = run(&["check", "--format", "concise", &types]);
    assert_eq!(code, 1);
    assert!(out.contains("error[C110]"), "{out}");
    let (folder, scenario) = file("s.avalla", "scenario s\nload s.asm\ncheck n = 1;\n");
    let asm =
        "asm s\nsignature:\n  controlled m: Integer\ndefinitions:\n  main rule r_Main = m := 1\n";
    std::fs::write(folder.path().join("s.asm"), asm).unwrap();
    let (code, out, _) = run(&["check", "--format", "concise", &scenario]);
    assert_eq!(code, 1);
    assert!(out.contains("s.avalla:3:7: error[A001]"), "{out}");
}

#[test]
fn colour_follows_the_flag_and_the_variables() {
    let coloured = |arguments: &[&str]| {
        let (_, out, err) = run(arguments);
        (out + &err).contains('\u{1b}')
    };
    let demo = ["demo", "--speed", "0", "--quiet"];
    assert!(!coloured(&demo), "a pipe gets no colour");
    assert!(coloured(&[&demo[..], &["--color", "always"]].concat()));
    let output = asmotion()
        .args(demo)
        .args(["--color", "auto"])
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    assert!(!String::from_utf8_lossy(&output.stdout).contains('\u{1b}'));
}

#[test]
fn an_empty_specification_is_no_error() {
    let (_folder, path) = file("empty.asm", "");
    let (code, out, _) = run(&["check", "--format", "concise", &path]);
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("warning[L020]"), "{out}");
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
            "4 specifications, 4 steps: 1 ran, 1 stopped by a fault, 1 rejected, 1 modules"
        ),
        "{err}"
    );
    let trace = std::fs::read_to_string(traces.path().join("clash.trace")).unwrap();
    assert!(
        trace.ends_with("@error CLASH\n@end CLASH\nI n = undef\n"),
        "{trace}"
    );
}

const UNTIDY: &str = "asm untidy\nsignature:\n  controlled n:Integer // how many\ndefinitions:\n main rule r_Main=n:=(1)";
const TIDY: &str = "asm untidy\n\nsignature:\n\tcontrolled n: Integer // how many\n\ndefinitions:\n\tmain rule r_Main = n := 1\n";

#[test]
fn fmt_rewrites_files_and_says_which() {
    let (folder, path) = file("untidy.asm", UNTIDY);
    let (code, out, err) = run(&["fmt", &folder.path().display().to_string()]);
    assert_eq!((code, &*out), (0, ""), "{err}");
    assert!(err.contains(&format!("Formatted {path}")), "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), TIDY);
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 0);
    assert!(
        err.contains("0 files formatted, 1 left as they are"),
        "{err}"
    );
}

#[test]
fn fmt_can_leave_files_alone() {
    let (_folder, path) = file("untidy.asm", UNTIDY);
    let (code, out, _) = run(&["fmt", "--check", &path]);
    assert_eq!((code, out), (1, format!("{path}\n")));
    let (code, out, _) = run(&["fmt", "--diff", &path]);
    assert_eq!(code, 0);
    assert!(
        out.contains("-  controlled n:Integer // how many\n"),
        "{out}"
    );
    assert!(
        out.contains("+\tcontrolled n: Integer // how many\n"),
        "{out}"
    );
    let (code, _, _) = run(&["fmt", "--check", "--diff", &path]);
    assert_eq!(code, 1);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), UNTIDY);
}

#[test]
fn fmt_shows_errors_and_leaves_their_file_alone() {
    let (_folder, path) = file("wrong.asm", "asm wrong signature: definitions: rule");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 1);
    assert!(err.contains("error["), "{err}");
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        "asm wrong signature: definitions: rule"
    );
    let (_folder, path) = file(
        "bytes.asm",
        b"asm bytes // \xff\nsignature:\ndefinitions:\n",
    );
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 2);
    assert!(err.contains("not UTF-8"), "{err}");
}

#[test]
fn fmt_reads_standard_input() {
    let output = asmotion()
        .args(["fmt", "-"])
        .write_stdin(UNTIDY)
        .output()
        .unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), TIDY);
}

#[test]
fn fmt_takes_scenarios_too() {
    let untidy = "scenario s load s.asm ;\nset  x:=1\nstep; check x = (1) ;\n";
    let tidy = "scenario s\nload s.asm\nset x := 1;\nstep\ncheck x = 1;\n";
    let (folder, path) = file("s.avalla", untidy);
    let (code, out, err) = run(&["fmt", "--check", &folder.path().display().to_string()]);
    assert_eq!((code, out), (1, format!("{path}\n")), "{err}");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 0, "{err}");
    assert_eq!(std::fs::read_to_string(&path).unwrap(), tidy);
    let output = asmotion().args(["fmt", "-"]).write_stdin(untidy).output();
    assert_eq!(String::from_utf8(output.unwrap().stdout).unwrap(), tidy);
    let (_folder, path) = file("wrong.avalla", "scenario s load s.asm chek x;");
    let (code, _, err) = run(&["fmt", &path]);
    assert_eq!(code, 1);
    assert!(err.contains("did you mean `check`?"), "{err}");
}

/// The specifications in this repository are formatted.
#[test]
fn our_specifications_are_formatted() {
    let (code, out, err) = run(&["fmt", "--check", "specs", "benches", "asm-lang/stdlib/asm"]);
    assert_eq!(
        code, 0,
        "run `asmotion fmt specs benches asm-lang/stdlib/asm`: {out}{err}"
    );
}

#[test]
fn two_specifications_talk_in_a_composite() {
    let courier = "specs/courier/courier.composite.toml";
    let (code, out, err) = run(&["run", courier, "--until", "jobs=3", "--for", "20"]);
    assert_eq!(code, 0, "{err}");
    assert!(
        out.contains("dispatcher.job ×3, dispatcher.done ×3"),
        "{out}"
    );
    assert!(out.contains("; 0 failed"), "{out}");
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
