//! Composites through the front door: opened up, drawn, as SCDL, as a schema.

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
    assert_eq!(run(&["check", &outer]).0, 0);
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
