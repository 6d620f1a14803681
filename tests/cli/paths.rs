//! Files and folders as arguments: `check`, `fmt`, `sim` and `test` understand them in the same way.

use super::{PATROL, run};

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
