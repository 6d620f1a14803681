//! Files and folders as arguments: `check`, `fmt`, `sim` and `test` understand them in the same way.

use super::{PATROL, asmotion, run};

const COMMANDS: [&[&str]; 4] = [&["check"], &["fmt", "--check"], &["sim"], &["test"]];

#[test]
fn every_command_takes_files_and_folders_in_any_number() {
    for paths in [
        &["specs/patrol"][..],
        &[PATROL],
        &[PATROL, "specs/estop/estop.asm"],
        &["specs/patrol", "specs/estop/estop.asm"],
        &["specs"],
    ] {
        for command in COMMANDS {
            let (code, out, err) = run(&[command, paths].concat());
            assert_eq!(code, 0, "{command:?} {paths:?}: {out}{err}");
        }
    }
}

#[test]
fn a_folder_without_files_is_a_wrong_usage_of_every_command() {
    let empty = tempfile::tempdir().unwrap();
    let path = empty.path().display().to_string();
    for command in COMMANDS {
        let (code, _, err) = run(&[command, &[&path]].concat());
        assert_eq!(code, 2, "{command:?}: {err}");
        assert!(
            err.contains("it contains no file for this command"),
            "{err}"
        );
    }
}

#[test]
fn a_missing_path_is_a_wrong_usage_of_every_command() {
    for command in COMMANDS {
        let (code, out, err) = run(&[command, &["specs/nowhere.asm"]].concat());
        assert_eq!(code, 2, "{command:?}: {out}{err}");
        assert!(err.contains("file not found"), "{command:?}: {err}");
    }
}

/// Runs a command with a text on standard input. Returns the exit code and both outputs.
fn piped(arguments: &[&str], text: &str) -> (i32, String) {
    let output = asmotion().args(arguments).write_stdin(text).output();
    let output = output.unwrap();
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).unwrap();
    (output.status.code().unwrap(), said)
}

#[test]
fn a_missing_path_among_others_is_a_wrong_usage_of_every_command() {
    for command in COMMANDS {
        let (code, out, err) = run(&[command, &[PATROL, "specs/nowhere.asm"]].concat());
        assert_eq!(code, 2, "{command:?}: {out}{err}");
    }
}

#[test]
fn every_command_reads_standard_input() {
    let specification = std::fs::read_to_string(PATROL).unwrap();
    for command in [&["check"][..], &["fmt"], &["fmt", "--check"], &["sim"]] {
        let (code, said) = piped(&[command, &["-"]].concat(), &specification);
        assert_eq!(code, 0, "{command:?}: {said}");
    }
    let scenario = std::fs::read_to_string("specs/estop/estop.avalla").unwrap();
    let scenario = scenario.replace("load estop.asm", "load specs/estop/estop.asm");
    for command in COMMANDS.iter().filter(|it| **it != ["sim"]) {
        let (code, said) = piped(&[command, &["-"][..]].concat(), &scenario);
        assert_eq!(code, 0, "{command:?}: {said}");
    }
    // beside files, too
    let (code, said) = piped(&["check", "-", PATROL], &specification);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("2 files"), "{said}");
}

#[test]
fn errors_on_standard_input_have_the_exit_codes_of_those_in_files() {
    let wrong = "asm wrong\nsignature:\ndefinitions:\n\tmain rule r_Main = x := 1\n";
    for (command, code) in [("check", 1), ("sim", 1)] {
        let (found, said) = piped(&[command, "-"], wrong);
        assert_eq!(found, code, "{command}: {said}");
        assert!(said.contains("<stdin>:4:"), "{command}: {said}");
    }
    let (code, said) = piped(&["test", "-"], "scenario s\nload specs/nowhere.asm\n");
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("<stdin>:2:"), "{said}");
}

#[test]
fn a_text_on_standard_input_for_another_command_names_that_command() {
    let specification = std::fs::read_to_string(PATROL).unwrap();
    let composite = "schema = \"composite/1\"\n[composite]\nname = \"c\"\n";
    let mission = "# tests c\nschema = \"mission/1\"\ncomposite = \"c.composite.toml\"\n";
    let scenario = "scenario s\nload specs/estop/estop.asm\nstep\n";
    for (arguments, text, hint) in [
        (&["sim", "-"][..], composite, "`asmotion run FILE` runs it"),
        (&["sim", "-"], scenario, "`asmotion test -` runs it"),
        (&["test", "-"], &*specification, "`asmotion sim -`"),
        (&["test", "-"], mission, "`asmotion test FILE` runs it"),
        (&["test", "-"], composite, "the missions beside it"),
        (&["fmt", "-"], composite, "`fmt` formats specifications"),
        (&["check", "--fix", "-"], &specification, "`--fix --diff`"),
        (&["run", "-"], composite, "a composite is a file"),
    ] {
        let (code, said) = piped(arguments, text);
        assert_eq!(code, 2, "{arguments:?}: {said}");
        assert!(said.contains(hint), "{arguments:?}: {said}");
    }
    let (code, said) = piped(&["check", "-"], "schema = \"composite/9\"");
    assert_eq!(code, 1, "{said}");
}

#[test]
fn a_file_for_another_command_names_that_command() {
    let composite = "specs/courier/courier.composite.toml";
    let scenario = "specs/estop/estop.avalla";
    for (arguments, hint) in [
        (["sim", composite], "asmotion run specs/courier"),
        (["sim", scenario], "asmotion test specs/estop"),
        (["test", composite], "asmotion run specs/courier"),
        (["fmt", composite], "`fmt` formats specifications"),
    ] {
        let (code, _, err) = run(&arguments);
        assert_eq!(code, 2, "{arguments:?}: {err}");
        assert!(err.contains(hint), "{arguments:?}: {err}");
    }
}

#[test]
fn check_reads_all_kinds_of_files_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("inner")).unwrap();
    for (name, text) in [
        ("a.asm", "asm a main"),
        ("inner/b.avalla", "scenario b"),
        ("c.composite.toml", "schema = \"composite/9\""),
        ("a.d.env.toml", "[[step]]"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().display().to_string();
    let (code, out, err) = run(&["check", &path, "--format", "concise"]);
    assert_eq!(code, 1, "{out}{err}");
    for name in ["a.asm:", "b.avalla:", "c.composite.toml:"] {
        assert!(out.contains(name), "{name}: {out}");
    }
    assert!(err.contains("in 4 files"), "{err}");
}

#[test]
fn test_of_a_specification_runs_its_own_scenarios() {
    let (code, out, err) = run(&["test", "specs/navigation/navigate.asm"]);
    assert_eq!(code, 0, "{out}{err}");
    assert!(
        out.contains("arrives.avalla") && out.contains("navigate.goal.env.toml"),
        "{out}"
    );
    assert_eq!(out.lines().count(), 2, "{out}");
    let (code, _, err) = run(&["test", "specs/courier/dispatcher.asm"]);
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("no scenario beside"), "{err}");
}
