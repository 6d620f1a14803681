//! Composites on the command line: expanded, drawn, converted to SCDL, described by a schema.

use std::path::Path;
use std::process::Command;

/// Exit code and standard output.
fn run(arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.args(arguments).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    (output.status.code().unwrap(), text)
}

/// A copy of a folder of `specs`.
fn copy(folder: &str) -> tempfile::TempDir {
    let copy = tempfile::tempdir().unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("specs")
        .join(folder);
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, copy.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    copy
}

#[test]
fn c11_every_composite_is_opened_up_to_one_that_checks_and_opens_up_to_itself() {
    for (folder, file) in [
        ("navigation", "navigation.composite.toml"),
        ("youbot", "youbot.composite.toml"),
        ("youbot", "youbot_driver.composite.toml"),
        ("courier", "courier.composite.toml"),
    ] {
        let folder = copy(folder);
        let path = |name: &str| folder.path().join(name).display().to_string();
        let (code, expanded) = run(&["expand", &path(file)]);
        assert_eq!(code, 0, "{file}");
        std::fs::write(path("expanded.toml"), &expanded).unwrap();
        assert_eq!(
            run(&["check", &path("expanded.toml")]).0,
            0,
            "{file}\n{expanded}"
        );
        assert_eq!(
            run(&["expand", &path("expanded.toml")]),
            (0, expanded),
            "{file}"
        );
    }
}

#[test]
fn c14_nested_scdl_is_imported_into_files_that_check() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().display().to_string();
    let (code, _) = run(&[
        "scdl",
        "import",
        "engine/scdl/tests/scdl/outer.composite",
        "-o",
        &path,
    ]);
    assert_eq!(code, 0);
    let outer = folder
        .path()
        .join("OuterComposite.composite.toml")
        .display()
        .to_string();
    // its script is not beside it
    assert_eq!(run(&["check", "--no-programs", &outer]).0, 0);
    let (code, xml) = run(&["scdl", "export", &outer]);
    assert_eq!(code, 0);
    assert!(
        xml.contains("<implementation.composite name=\"own:InnerComposite\"/>"),
        "{xml}"
    );
    let (code, _) = run(&[
        "scdl",
        "import",
        "specs/navigation/navigation.composite.toml",
    ]);
    assert_eq!(code, 1, "TOML is no SCDL");
}

#[test]
fn c15_the_pictures_of_the_documentation_are_drawn_from_the_composites() {
    for (name, file) in [
        (
            "navigation.svg",
            "specs/navigation/navigation.composite.toml",
        ),
        ("youbot.svg", "specs/youbot/youbot.composite.toml"),
    ] {
        let (code, drawn) = run(&["graph", file]);
        assert_eq!(code, 0, "{file}");
        super::pictures::picture(name, &drawn);
    }
    for format in ["dot", "mermaid"] {
        let (code, drawn) = run(&[
            "graph",
            "specs/courier/courier.composite.toml",
            "--format",
            format,
        ]);
        assert!(code == 0 && drawn.contains("Dispatcher"), "{drawn}");
    }
}

#[test]
fn schemas_are_json() {
    for arguments in [&["schema"][..], &["schema", "--types"]] {
        let (code, schema) = run(arguments);
        assert_eq!(code, 0);
        let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
        assert_eq!(schema["additionalProperties"], false);
    }
}

/// A copy of the navigation composite with one line changed.
fn changed(line: &str, other: &str) -> tempfile::TempDir {
    let folder = copy("navigation");
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    let maps = std::fs::create_dir(folder.path().join("maps"));
    maps.unwrap();
    for entry in std::fs::read_dir(specs.join("maps")).unwrap() {
        let path = entry.unwrap().path();
        let to = folder.path().join("maps").join(path.file_name().unwrap());
        std::fs::copy(&path, to).unwrap();
    }
    let file = folder.path().join("navigation.composite.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    assert_eq!(text.matches(line).count(), 1, "{line}");
    std::fs::write(&file, text.replace(line, other)).unwrap();
    folder
}

/// Exit code and standard error of a command applied to a composite.
fn on(folder: &tempfile::TempDir, command: &str, arguments: &[&str]) -> (i32, String) {
    let file = folder.path().join("navigation.composite.toml");
    let mut asmotion = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    asmotion.arg(command).arg(file).args(arguments);
    let output = asmotion.output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.code().unwrap(), said)
}

/// Another implementation of `nav/PlanService`, which keeps a larger distance from walls.
const CAREFUL: &str = r#"
schema = "composite/1"
[composite]
name = "careful"
[components.Planner]
implementation = { rust = "nav::TrajectoryPlanner" }
task       = { period_ms = 100 }
services   = { planning = "nav/PlanService" }
ports.in   = { obstacles = "nav/Obstacles" }
properties = { comfort_m = 1.2 }
[[promote]]
service = "Planner.planning"
as      = "planning"
[[promote]]
port = "Planner.obstacles"
as   = "obstacles"
"#;

/// The lines of a story without the first one, which names the file.
fn story(said: &str) -> Vec<&str> {
    said.lines().skip(1).collect()
}

#[test]
fn c1_the_planner_is_another_by_one_line() {
    let written = "implementation = { rust = \"nav::TrajectoryPlanner\" }\ntask       = { id = \"planner\", period_ms = 100, \
                   delay_ms = 0, run_on_startup = true, may_interrupt_if_running = false }\n\
                   services   = { planning = \"nav/PlanService\" }\nports.in   = { obstacles = \"nav/Obstacles\" }\n";
    let ours = changed(
        written,
        "implementation = { rust = \"nav::TrajectoryPlanner\" }\n",
    );
    let other = changed(
        written,
        "implementation = { composite = \"careful.toml\" }\n",
    );
    std::fs::write(other.path().join("careful.toml"), CAREFUL).unwrap();
    let [ours, other] = [ours, other].map(|folder| on(&folder, "run", &["--goal", "26.4,4.2"]));
    assert_eq!((ours.0, other.0), (0, 0), "{}\n{}", ours.1, other.1);
    // both arrive, on different paths
    assert_ne!(story(&ours.1), story(&other.1));
}

#[test]
fn c2_an_argument_of_another_type_is_found_before_anything_runs() {
    let with = "with = { name = \"${properties.place}\" }";
    let (code, said) = on(&changed(with, "with = { name = 7 }"), "check", &[]);
    assert!(code == 1 && said.contains("C100"), "{said}");
    let (code, said) = on(&changed(with, "with = { nam = \"office\" }"), "check", &[]);
    assert!(code == 1 && said.contains("`nam`"), "{said}");
}

#[test]
fn c3_a_reference_that_leads_nowhere_is_refused() {
    let wire = "[[wires]]\nreference  = \"ASMCoordinator.maps\"\nservice    = \"MapServer.maps\"\n";
    let folder = changed(
        wire,
        "[[wires]]\nreference = \"Nobody.x\"\nservice = \"MapServer.maps\"\n",
    );
    let (code, said) = on(&folder, "check", &[]);
    assert!(
        code == 1 && said.contains("C031") && said.contains("ASMCoordinator.maps"),
        "{said}"
    );
    assert_eq!(on(&folder, "run", &["--for", "1"]).0, 1);
}

#[test]
fn c16_one_command_runs_both_case_studies() {
    let missions = [
        (
            "specs/navigation/navigation.composite.toml",
            &["--goal", "3.4,4.7"][..],
        ),
        (
            "specs/youbot/youbot.composite.toml",
            &["--until", "mode=IDLE"],
        ),
    ];
    for (composite, arguments) in missions {
        let mut all = vec!["run", composite];
        all.extend(arguments);
        assert_eq!(run(&all).0, 0, "{composite}");
    }
}

/// A map server for each of two profiles, and its client.
const LINE: &str = r#"
schema = "composite/1"
[composite]
name = "line"
[components.Toy]
implementation = { rust = "nav::MapServer" }
profile = "sim"
[components.Archive]
implementation = { rust = "nav::MapServer" }
profile = "real"
[components.Planner]
implementation = { ros = "planner" }
references = { maps = "nav/MapService" }
[[wires]]
profile = "sim"
reference = "Planner.maps"
service = "Toy.maps"
timeout_ms = 100
[[wires]]
profile = "real"
reference = "Planner.maps"
service = "Archive.maps"
timeout_ms = 100
"#;

#[test]
fn c20_every_profile_is_checked_whichever_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("navigation.composite.toml");
    let check = |text: &str, command: &str, arguments: &[&str]| {
        std::fs::write(&file, text).unwrap();
        on(&folder, command, arguments)
    };
    let (code, said) = check(LINE, "check", &[]);
    assert_eq!(code, 0, "{said}");
    let wrong = LINE.replace("Archive.maps", "Archive.map");
    let forgotten = LINE.replace(
        "profile = \"real\"\nreference",
        "profile = \"sim\"\nreference",
    );
    for (text, finding) in [(wrong, "C021"), (forgotten, "C031")] {
        let (code, said) = check(&text, "check", &[]);
        assert!(code == 1 && said.contains(finding), "{said}");
        let (code, said) = check(&text, "run", &["--profile", "sim", "--for", "1"]);
        assert!(code == 1 && said.contains(finding), "{said}");
    }
    let (code, said) = check(LINE, "run", &["--profile", "rael"]);
    assert!(code == 2 && said.contains("did you mean `real`"), "{said}");
}
