//! Components in C++: the example, from the command line.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const FOLDER: &str = "examples/gripper-cpp";

/// A folder with the example and its compiled program; `None` without a compiler.
struct Workshop {
    folder: tempfile::TempDir,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

impl Workshop {
    fn new() -> Option<Self> {
        let program = asmotion_skip::compile("examples/gripper-cpp/gripper.cpp")?;
        let folder = tempfile::tempdir().unwrap();
        for source in ["examples/gripper", FOLDER] {
            let here = folder.path().join(source.rsplit('/').next().unwrap());
            std::fs::create_dir(&here).unwrap();
            for entry in std::fs::read_dir(root().join(source)).unwrap() {
                let entry = entry.unwrap();
                if entry.file_type().unwrap().is_file() {
                    std::fs::copy(entry.path(), here.join(entry.file_name())).unwrap();
                }
            }
        }
        std::fs::copy(program, folder.path().join("gripper-cpp/gripper")).unwrap();
        Some(Self { folder })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a command that must succeed; returns standard output and standard error.
    fn run(&self, folder: &str, arguments: &[&str]) -> (String, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(arguments).current_dir(self.path(folder));
        let output = command.stdin(Stdio::null()).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success(), "{arguments:?}: {out}{err}");
        (out, err)
    }
}

const FILE: &str = "gripper.composite.toml";

#[test]
fn a_component_in_cpp_runs_in_both_clocks_and_two_traces_are_equal() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let run = |folder: &str, trace: &str| {
        let path = workshop.path(trace);
        let path = path.to_str().unwrap();
        let until = ["--until", "mode=CLOSED", "--for", "10", "--trace", path];
        workshop.run(folder, &[&["run", FILE][..], &until].concat());
        std::fs::read(path).unwrap()
    };
    let first = run("gripper-cpp", "first");
    assert!(!first.is_empty());
    assert!(first == run("gripper-cpp", "second"), "two runs differ");
    assert!(first == run("gripper", "python"), "Python differs");
    let live = [
        "run",
        FILE,
        "--until",
        "mode=CLOSED",
        "--for",
        "10",
        "--clock",
        "wall",
    ];
    let (_, err) = workshop.run("gripper-cpp", &live);
    assert!(err.contains("CLOSING → CLOSED"), "{err}");
    workshop.run("gripper-cpp", &["test", "gripper.mission.toml"]);
}

#[test]
fn a_component_in_cpp_is_described_as_one_in_python() {
    let Some(workshop) = Workshop::new() else {
        return;
    };
    let described = |folder: &str| workshop.run(folder, &["describe", FILE, "--asyncapi"]).0;
    assert_eq!(described("gripper-cpp"), described("gripper"));
    let (_, err) = workshop.run("gripper-cpp", &["check", FILE]);
    assert!(err.contains("no findings"), "{err}");
}

#[test]
fn the_messages_of_the_example_are_those_that_describe_prints() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(root().join("examples/gripper"));
    let output = command.args(["describe", FILE, "--cpp"]).output().unwrap();
    if !output.status.success() {
        asmotion_skip::PYTHON.skip();
        return;
    }
    let path = root().join(FOLDER).join("messages.hpp");
    let expected = String::from_utf8(output.stdout).unwrap();
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    assert!(
        std::fs::read_to_string(&path).unwrap_or_default() == expected,
        "out of date: UPDATE_REFERENCE=1 cargo test -p asmotion --test main programs_cpp::"
    );
}

/// The blocks of a page in a language, of complete programs.
fn programs(page: &str, language: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(page)).unwrap();
    let opening = format!("```{language}\n");
    let blocks = text.split(&opening).skip(1);
    let blocks = blocks.filter_map(|block| block.split("```").next());
    let blocks = blocks.filter(|block| block.contains("int main("));
    blocks.map(str::to_owned).collect()
}

#[test]
fn the_programs_of_the_pages_compile() {
    if !asmotion_skip::has_compiler() {
        return;
    }
    let compile = |page: &str, language: &str, compiler: &str, standard: &str| {
        let programs = programs(page, language);
        assert_eq!(programs.len(), 1, "{page}");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(format!("page.{language}"));
        std::fs::write(&file, &programs[0]).unwrap();
        let mut command = Command::new(compiler);
        command.args([standard, "-fsyntax-only", "-Wall", "-Wextra", "-Werror"]);
        for include in ["cpp", FOLDER] {
            command.arg("-I").arg(root().join(include));
        }
        let output = command.arg(&file).stdin(Stdio::null()).output().unwrap();
        assert!(output.status.success(), "{page}: {output:?}");
    };
    compile("cpp/README.md", "cpp", "c++", "-std=c++17");
    compile("cpp/README.md", "c", "cc", "-std=gnu99");
    compile("docs/programs.md", "cpp", "c++", "-std=c++17");
}
