//! Projects created by `asmotion new`, outside the workspace: their checks, tests and missions pass.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

fn asmotion(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_asmotion"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

/// Runs `asmotion`, which succeeds.
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let (code, text) = asmotion(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}: {text}");
    text
}

/// The text of all files, with their paths.
fn contents(folder: &Path) -> String {
    let mut all = String::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                all += &format!("{}\n", path.display());
                all += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    all
}

#[test]
fn a_project_with_a_specification_only() {
    let home = tempfile::tempdir().unwrap();
    let text = succeeds(home.path(), &["new", "left-arm", "--spec-only"]);
    assert!(
        text.contains("cd left-arm && asmotion test specs"),
        "{text}"
    );
    let project = home.path().join("left-arm");
    assert!(!contents(&project).to_lowercase().contains("gripper"));
    let text = succeeds(&project, &["check", "specs"]);
    assert!(text.contains("no findings"), "{text}");
    let text = succeeds(&project, &["test", "specs"]);
    assert!(text.contains("3 passed"), "{text}");
    let text = succeeds(&project, &["verify", "specs"]);
    assert_eq!(
        text.matches("4 hold, 0 violated, 0 not known").count(),
        2,
        "{text}"
    );
    assert!(text.contains("invariant inv_done"), "{text}");
    let mission = [
        "run",
        "specs/left_arm.composite.toml",
        "--until",
        "mode=DONE",
    ];
    let text = succeeds(&project, &mission);
    assert!(text.contains("OPENING → DONE"), "{text}");
}

/// The files of a new project, by their paths.
fn new_project(name: &str, kind: &str) -> BTreeMap<String, String> {
    let home = tempfile::tempdir().unwrap();
    succeeds(home.path(), &["new", name, kind]);
    let mut files = BTreeMap::new();
    let mut folders = vec![home.path().to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let text = std::fs::read_to_string(&path).unwrap();
                let path = path.strip_prefix(home.path()).unwrap();
                files.insert(path.display().to_string(), text);
            }
        }
    }
    files
}

#[test]
fn a_name_may_contain_the_word_of_the_templates() {
    for (name, other) in [
        ("gripper", "xyz"),
        ("gripper2", "xyz2"),
        ("mygripper", "myxyz"),
        ("my-gripper", "my-xyz"),
        ("parallel-gripper", "parallel-xyz"),
        ("gripper-gripper", "xyz-xyz"),
    ] {
        for kind in ["--rust", "--python", "--spec-only"] {
            let renamed = |text: String| text.replace("xyz", "gripper").replace("Xyz", "Gripper");
            let expected: BTreeMap<_, _> = new_project(other, kind)
                .into_iter()
                .map(|(path, text)| (renamed(path), renamed(text)))
                .collect();
            assert_eq!(new_project(name, kind), expected, "{name} {kind}");
        }
    }
    let lib = &new_project("gripper2", "--rust")["gripper2/src/lib.rs"];
    assert!(
        lib.contains(".component(\"gripper2::Gripper2\", Gripper2::new)"),
        "{lib}"
    );
}

#[test]
fn a_program_has_the_features_of_asmotion() {
    let manifest = |text: &str| text.parse::<toml::Table>().unwrap();
    let project = manifest(&new_project("left-arm", "--rust")["left-arm/Cargo.toml"]);
    let own = manifest(include_str!("../Cargo.toml"));
    let defaults = own["features"]["default"].as_array().unwrap();
    let left_out = own["features"].as_table().unwrap().keys();
    let left_out = left_out
        .filter(|name| *name != "default" && !defaults.iter().any(|it| it.as_str() == Some(name)));
    let expected: toml::Table = left_out
        .map(|name| (name.clone(), vec![format!("asmotion/{name}")].into()))
        .collect();
    assert_eq!(project["features"].as_table(), Some(&expected));
}

#[test]
fn a_project_in_python_passes_its_tests_and_missions() {
    let home = tempfile::tempdir().unwrap();
    let text = succeeds(home.path(), &["new", "left-arm", "--python"]);
    let environment = "python3 -m venv .venv && . .venv/bin/activate && pip install ";
    assert!(
        text.contains("not on PyPI yet") && text.contains(&format!("{environment}FOLDER/python")),
        "{text}"
    );
    let source = env!("CARGO_MANIFEST_DIR");
    let other = ["new", "right-arm", "--python", "--source", source];
    let text = succeeds(home.path(), &other);
    let next = format!("cd right-arm && {environment}{source}/python && python3 -m unittest");
    assert!(text.contains(&next), "{text}");
    let project = home.path().join("left-arm");
    succeeds(&project, &["new", "component", "wrist"]);
    assert!(!contents(&project).to_lowercase().contains("gripper"));
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("python");
    let run = |program: &str, arguments: &[&str]| {
        let output = Command::new(program)
            .args(arguments)
            .env("PYTHONPATH", &package)
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .current_dir(&project)
            .output()
            .unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(output.status.success(), "{program} {arguments:?}: {text}");
        text
    };
    let text = run("python3", &["-m", "unittest"]);
    assert!(text.contains("Ran 2 tests"), "{text}");
    let asmotion = env!("CARGO_BIN_EXE_asmotion");
    let text = run(asmotion, &["check", "specs"]);
    assert!(text.contains("no findings"), "{text}");
    let text = run(asmotion, &["test", "specs"]);
    assert!(text.contains("3 passed"), "{text}");
    let text = run(asmotion, &["verify", "specs"]);
    assert!(text.contains("4 hold, 0 violated, 0 not known"), "{text}");
    let mission = [
        "run",
        "specs/left_arm.composite.toml",
        "--until",
        "mode=DONE",
    ];
    let text = run(asmotion, &mission);
    assert!(text.contains("OPENING → DONE"), "{text}");
}

/// Compiles asmotion a second time, because a project outside the workspace shares none of its artifacts.
#[test]
#[ignore = "compiles asmotion a second time, which takes minutes: CI runs it with `--ignored`"]
fn a_project_in_rust_has_every_command_with_its_component() {
    let (home, source) = (tempfile::tempdir().unwrap(), env!("CARGO_MANIFEST_DIR"));
    let text = succeeds(home.path(), &["new", "left-arm", "--source", source]);
    assert!(!text.contains("not on crates.io"), "{text}");
    let project = home.path().join("left-arm");
    let text = succeeds(&project, &["new", "component", "wrist"]);
    assert!(
        text.contains("Created src/wrist.rs") && text.contains("Changed src/lib.rs"),
        "{text}"
    );
    assert!(!contents(&project).to_lowercase().contains("gripper"));
    let lib = std::fs::read_to_string(project.join("src/lib.rs")).unwrap();
    assert!(
        lib.contains(".component(\"left_arm::Wrist\", Wrist::new)"),
        "{lib}"
    );
    // the versions that this workspace was tested with
    std::fs::copy(
        Path::new(source).join("Cargo.lock"),
        project.join("Cargo.lock"),
    )
    .unwrap();
    let target = Path::new(env!("CARGO_BIN_EXE_asmotion"))
        .ancestors()
        .nth(2)
        .unwrap();
    let output = Command::new(env!("CARGO"))
        .args(["test", "--offline"])
        .env("CARGO_TARGET_DIR", target.join("project"))
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
        .env("CARGO_PROFILE_DEV_DEBUG", "none")
        .current_dir(&project)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&text);
    assert!(output.status.success(), "{text}");
    for passed in [
        "gripper",
        "scenarios_and_missions_pass ... ok",
        "left_arm::tests::it_moves_at_its_speed ... ok",
        "wrist::tests::it_keeps_the_contract_of_components ... ok",
    ] {
        assert!(
            text.contains(passed) != (passed == "gripper"),
            "{passed}: {text}"
        );
    }
}

#[test]
fn a_name_is_checked_and_nothing_is_overwritten() {
    let home = tempfile::tempdir().unwrap();
    for (arguments, problem) in [
        (&["new", "Arm"][..], "`Arm` is not a name"),
        (&["new", "2arms"], "beginning with a letter"),
        (&["new", "arm", "leg"], "`leg` is one name too many"),
        (&["new", "component", "arm"], "this folder is no project"),
        (
            &["new", "arm", "--source", "/"],
            "is not the source code of asmotion",
        ),
        (&["new", "arm", "--rust", "--python"], "cannot be used with"),
        (
            &["new", "arm", "--spec-only", "--source", "."],
            "cannot be used with",
        ),
        (
            &["new", "component", "arm", "--python"],
            "the language of its project",
        ),
    ] {
        let (code, text) = asmotion(home.path(), arguments);
        assert!(
            code == Some(2) && text.contains(problem),
            "{arguments:?}: {text}"
        );
    }
    assert!(std::fs::read_dir(home.path()).unwrap().next().is_none());
    succeeds(home.path(), &["new", "arm", "--python"]);
    let (code, text) = asmotion(home.path(), &["new", "arm"]);
    assert!(code == Some(2) && text.contains("`arm` exists"), "{text}");
    let project = home.path().join("arm");
    succeeds(&project, &["new", "component", "wrist"]);
    let (code, text) = asmotion(&project, &["new", "component", "wrist"]);
    assert!(
        code == Some(2) && text.contains("wrist.py` exists"),
        "{text}"
    );
    assert!(project.join("test_wrist.py").is_file());
}

#[test]
fn without_its_own_program_a_project_in_rust_says_how_to_run_it() {
    let (home, source) = (tempfile::tempdir().unwrap(), env!("CARGO_MANIFEST_DIR"));
    succeeds(home.path(), &["new", "left-arm", "--source", source]);
    let project = home.path().join("left-arm");
    let (code, text) = asmotion(&project, &["test", "specs"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("1 passed, 2 cannot be run"), "{text}");
    let command = "`cargo run -- test specs/left_arm.mission.toml`";
    assert!(text.contains(command), "{text}");
    let (code, text) = asmotion(&project, &["run", "specs/left_arm.composite.toml"]);
    assert_eq!(code, Some(2), "{text}");
    let command = "`cargo run -- run specs/left_arm.composite.toml`";
    assert!(text.contains(command), "{text}");
    // from elsewhere
    let (_, text) = asmotion(home.path(), &["test", "left-arm/specs/stop.mission.toml"]);
    let manifest = project.canonicalize().unwrap().join("Cargo.toml");
    let command = format!(
        "`cargo run --manifest-path {} -- test left-arm/specs/stop.mission.toml`",
        manifest.display()
    );
    assert!(text.contains(&command), "{text}");
    // no command where there is no such project
    std::fs::remove_file(project.join("Cargo.toml")).unwrap();
    let (_, text) = asmotion(&project, &["test", "specs"]);
    assert!(text.contains("is not in this build"), "{text}");
    assert!(!text.contains("cargo run"), "{text}");
}
