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
