//! The youBot's driver as a program in Python: the arm passes through the same control states, in equal runs.

use std::path::Path;
use std::process::Command;

fn is_python_there() -> bool {
    let found = Command::new("python3").arg("--version").output();
    let found = found.is_ok_and(|it| it.status.success());
    if !found {
        asmotion_skip::PYTHON.skip();
    }
    found
}

/// A copy of the case study with the driver of `examples/youbot-python`.
fn with_program(folder: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for entry in std::fs::read_dir(root.join("specs/youbot")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
    }
    let driver = folder.join("youbot_driver.composite.toml");
    let composite = std::fs::read_to_string(&driver).unwrap();
    let built_in = r#"{ rust = "youbot::DummyDriver" }"#;
    assert!(composite.contains(built_in), "{composite}");
    let program = root.join("examples/youbot-python/driver.py");
    let program = format!(r#"{{ process = ["python3", {program:?}] }}"#);
    std::fs::write(driver, composite.replace(built_in, &program)).unwrap();
}

/// Everything that a successful command prints.
fn asmotion(folder: &Path, arguments: &[&str]) -> String {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(folder).env("PYTHONPATH", package);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    let output = command.args(arguments).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let printed = [output.stderr, output.stdout].concat();
    String::from_utf8(printed).unwrap()
}

/// Output and trace of ten seconds in virtual time.
fn run(folder: &Path) -> (String, String) {
    let composite = "youbot.composite.toml";
    let out = asmotion(
        folder,
        &["run", composite, "--for", "10", "--trace", "run.trace"],
    );
    (
        out,
        std::fs::read_to_string(folder.join("run.trace")).unwrap(),
    )
}

fn control_states(output: &str) -> Vec<&str> {
    output.lines().filter(|line| line.contains('→')).collect()
}

#[test]
fn the_driver_may_be_a_program_in_python() {
    if !is_python_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    with_program(folder.path());
    let (out, trace) = run(folder.path());
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/youbot");
    let composite = "youbot.composite.toml";
    let built_in = asmotion(&specs, &["run", composite, "--for", "10"]);
    let expected = control_states(&built_in);
    assert!(expected.len() >= 4, "{built_in}");
    assert_eq!(control_states(&out), expected);
    let (again, same_trace) = run(folder.path());
    assert_eq!(control_states(&again), expected);
    assert!(
        trace.len() > 10_000 && trace == same_trace,
        "two runs differ"
    );
}

#[test]
fn its_missions_succeed() {
    if !is_python_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    with_program(folder.path());
    let out = asmotion(folder.path(), &["test", "."]);
    for mission in ["motion", "link_lost"] {
        assert!(
            out.contains(&format!("pass {mission}.mission.toml")),
            "{out}"
        );
    }
}
