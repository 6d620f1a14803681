//! Wrong usage and files with errors.

use super::{NAVIGATION, PATROL, file, run};

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
        (
            run_with("--speed", "NaN"),
            "expected a number of at least 0",
        ),
    ] {
        let (code, out, err) = run(&arguments);
        assert_eq!(code, 2, "{arguments:?}: {out}{err}");
        assert!(err.contains(said), "{arguments:?}: {out}{err}");
    }
    let (code, _, err) = run(&["run", NAVIGATION, "--clock", "wall", "--speed", "2"]);
    assert_eq!(code, 2);
    assert!(err.contains("`--speed` needs the virtual clock"), "{err}");
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

/// A copy of the navigation with one text replaced, in its folder with the specification and the maps.
fn navigation_with(text: &str, replacement: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let from = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    for name in ["navigate.asm", "maps/office.geojson"] {
        std::fs::copy(from.join(name), folder.path().join(name)).unwrap();
    }
    let composite = std::fs::read_to_string(from.join("navigation.composite.toml")).unwrap();
    assert!(composite.contains(text), "{text}");
    let path = folder.path().join("navigation.composite.toml");
    std::fs::write(&path, composite.replacen(text, replacement, 1)).unwrap();
    let path = path.display().to_string();
    (folder, path)
}

#[test]
fn check_finds_a_wrong_line_in_the_script_of_the_operator() {
    let (_folder, path) = navigation_with("1.0 goal 26.4", "1.0 gaol 26.4");
    let (code, out, err) = run(&["check", &path]);
    assert_eq!(code, 1, "{out}{err}");
    assert!(
        err.contains("`1.0 gaol 26.4 4.2 0.0`: unknown command"),
        "{err}"
    );
    assert!(err.contains("as in `1.0 goal 26.4 4.2`"), "{err}");
    assert!(err.contains("navigation.composite.toml:"), "{err}");
}

#[test]
fn a_fraction_of_a_millisecond_is_told_the_unit() {
    let (_folder, path) = navigation_with("{ period_ms = 100 }", "{ period_ms = 0.05 }");
    let (code, out, err) = run(&["check", &path]);
    assert_eq!(code, 1, "{out}{err}");
    let said = "expected an integer for `period_ms`, found a floating-point number";
    assert!(err.contains(said), "{err}");
    assert!(
        err.contains("write a whole number of milliseconds as in `period_ms = 1`"),
        "{err}"
    );
}

#[test]
fn a_folder_of_maps_that_is_not_there_is_no_place() {
    let (code, out, err) = run(&["run", NAVIGATION, "--for", "5", "--set", "maps=/nowhere"]);
    assert_ne!(code, 0, "{out}{err}");
    assert!(
        err.contains("/nowhere") && err.contains("file not found"),
        "{out}{err}"
    );
    assert!(!err.contains("known are nowhere"), "{err}");
}

#[test]
fn an_input_without_a_value_names_the_key_that_gives_it_one() {
    let (_folder, path) =
        navigation_with(r#", field = "data", none = false"#, r#", field = "data""#);
    let (code, out, err) = run(&["run", &path]);
    assert_eq!(code, 3, "{out}{err}");
    assert!(
        err.contains("`none` in the binding of `estop` in the composite"),
        "{err}"
    );
}

#[test]
fn a_composite_that_is_not_there_is_answered_with_those_that_are() {
    for (path, what) in [
        ("specs/navigation", "it is a folder"),
        ("specs/navigation/navigate.composite.toml", "file not found"),
    ] {
        let (code, out, err) = run(&["run", path]);
        assert_eq!(code, 2, "{out}{err}");
        assert!(err.contains(what), "{err}");
        assert!(
            err.contains("`specs/navigation/navigation.composite.toml`"),
            "{err}"
        );
        assert!(!err.contains("Running"), "nothing runs: {err}");
    }
}

const LISTENER: &str = r#"asm listener
import StandardLibrary
signature:
  monitored go: Boolean
  monitored distance: Real
  monitored farthest: Real
  monitored listed: Real
  controlled near: Boolean
definitions:
  main rule r_Main = if go and distance < 1.0 and listed < farthest then near := true endif
"#;

const LISTENING: &str = r#"schema = "composite/1"
[composite]
name = "listening"
types = "types.toml"
[components.Listener]
implementation = { asm = "listener.asm" }
task = { period_ms = 50 }
subscribe = { go = "std_msgs/Bool", scan = "sensor_msgs/LaserScan", list = "acme/List" }
[components.Listener.bind.monitored]
go = { topic = "go", field = "data", none = false }
distance = { topic = "scan", field = "range_min", none = 9.0 }
farthest = { topic = "scan", field = "range_max", none = 9.0 }
listed = { topic = "list", field = "data.0", none = 0.0 }
[[promote]]
topic = "go"
as = "go"
[[promote]]
topic = "scan"
as = "scan"
[[promote]]
topic = "list"
as = "list"
"#;

const TYPES: &str = r#"schema = "composite-types/1"
[type."acme/List"]
fields = { data = "f64[]" }
"#;

/// Checks the composite with a change; returns the output.
fn listening(change: (&str, &str), types: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    assert!(LISTENING.contains(change.0), "{}", change.0);
    let composite = LISTENING.replacen(change.0, change.1, 1);
    let files = [
        ("listener.asm", LISTENER),
        ("types.toml", types),
        ("c.composite.toml", &composite),
    ];
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().join("c.composite.toml").display().to_string();
    let (_, out, err) = run(&["check", &path]);
    out + &err
}

#[test]
fn a_composite_without_mistakes_has_no_findings() {
    let said = listening(("\"listening\"", "\"listening\""), TYPES);
    assert!(said.contains("no findings"), "{said}");
}

/// What the way out says is what makes the composite right.
#[test]
fn a_mistake_in_a_composite_is_answered_with_what_to_write() {
    let mistakes = [
        (
            ("[[promote]]\ntopic = \"go\"\nas = \"go\"\n", ""),
            "add `[[promote]]` with `topic = \"go\"` and `as = \"go\"`",
        ),
        (
            ("go = \"std_msgs/Bool\"", "go = \"Bool\""),
            "did you mean `std_msgs/Bool`?",
        ),
        (
            ("field = \"range_min\"", "field = \"ranges[3]\""),
            "did you mean `ranges.3`?",
        ),
        (
            ("field = \"range_min\"", "field = \"ranges\""),
            "the path to an element of a list ends with its number, as in `ranges.0`",
        ),
        (
            (
                "[[promote]]\ntopic = \"go\"\nas = \"go\"\n[[promote]]\ntopic = \"scan\"\nas = \"scan\"\n\
                 [[promote]]\ntopic = \"list\"\nas = \"list\"\n",
                "[promote]\ngo = \"go\"\n",
            ),
            "begin each table of the list with `[[promote]]`",
        ),
    ];
    for (change, help) in mistakes {
        let said = listening(change, TYPES);
        assert!(said.contains(help), "{change:?}: {said}");
    }
    assert!(!listening(("field = \"range_min\"", "field = \"ranges.3\""), TYPES).contains("help"));
}

#[test]
fn a_field_with_a_wrong_type_is_one_finding_and_its_uses_none() {
    let types = TYPES.replace("f64[]", "[f64]");
    let use_it = (
        "topic = \"scan\", field = \"range_min\"",
        "topic = \"list\", field = \"data.0\"",
    );
    let said = listening(use_it, &types);
    assert!(said.contains("`[f64]` is not valid as a type"), "{said}");
    assert!(said.contains("a list `name[]`"), "{said}");
    assert!(said.contains("error: 1 error in 1 file"), "{said}");
}
