//! `asmotion describe --python`, `--typescript`, `--cpp`: message types as source text of other languages.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const YOUBOT: &str = "specs/youbot/youbot.composite.toml";

/// Composites whose types are compiled; the last argument stands for all messages of the build.
const SUBJECTS: &[&str] = &[
    "specs/navigation/navigation.composite.toml",
    "specs/courier/courier.composite.toml",
    YOUBOT,
    "--messages",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn describe(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(root());
    command.arg("describe").args(arguments).output().unwrap()
}

fn source(subject: &str, language: &str) -> String {
    let output = describe(&[subject, language]);
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// A file with the types of each subject.
fn files(folder: &Path, language: &str, extension: &str) -> Vec<PathBuf> {
    let file = |(index, subject): (usize, &&str)| {
        let path = folder.join(format!("types{index}.{extension}"));
        std::fs::write(&path, source(subject, language)).unwrap();
        path
    };
    SUBJECTS.iter().enumerate().map(file).collect()
}

fn is_installed(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version").stdin(Stdio::null());
    command.output().is_ok_and(|it| it.status.success())
}

/// Runs a compiler, which must accept or refuse the source.
fn compile(command: &mut Command, accepts: bool) {
    let output = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(output.status.success(), accepts, "{command:?}: {output:?}");
}

#[test]
fn types_of_a_composite_are_translated() {
    insta::assert_snapshot!("message_types_python", source(YOUBOT, "--python"));
    insta::assert_snapshot!("message_types_typescript", source(YOUBOT, "--typescript"));
    insta::assert_snapshot!("message_types_cpp", source(YOUBOT, "--cpp"));
}

#[test]
fn the_python_package_has_the_messages_of_this_build() {
    let path = root().join("python/asmotion/messages.py");
    let expected = source("--messages", "--python");
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    assert!(
        std::fs::read_to_string(&path).unwrap_or_default() == expected,
        "out of date: UPDATE_REFERENCE=1 cargo test -p asmotion --test main message_types::"
    );
}

#[test]
fn python_runs_them() {
    if !is_installed("python3") {
        asmotion_skip::PYTHON.skip();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let run = |file: &Path, check: &str| {
        let mut command = Command::new("python3");
        command.env("PYTHONPATH", root().join("python"));
        command.env("PYTHONDONTWRITEBYTECODE", "1");
        command.current_dir(folder.path());
        let module = file.file_stem().unwrap().to_str().unwrap();
        let resolve = "[form_of(getattr(types, name)).zero() for name in types.__all__ \
                       if not issubclass(getattr(types, name), asmotion.Interface)]";
        command.arg("-c").arg(format!(
            "import asmotion, {module} as types; from asmotion.types import form_of; {resolve}; {check}"
        ));
        command
    };
    let files = files(folder.path(), "--python", "py");
    for file in &files {
        compile(&mut run(file, ""), true);
    }
    let messages = files.last().unwrap();
    compile(&mut run(messages, "assert types.Quaternion().w == 1"), true);
    compile(
        &mut run(messages, "assert types.Quaternion().w == 0"),
        false,
    );
}

#[test]
fn a_cpp_compiler_accepts_them() {
    if !asmotion_skip::has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let files = files(folder.path(), "--cpp", "hpp");
    let main = folder.path().join("main.cpp");
    let compiler = |text: &str| {
        std::fs::write(&main, text).unwrap();
        let mut command = Command::new("c++");
        command.args(["-std=c++17", "-Wall", "-Wextra", "-pedantic", "-Werror"]);
        command.arg("-fsyntax-only").arg(&main);
        command
    };
    for file in &files {
        compile(&mut compiler(&format!("#include {file:?}\n")), true);
    }
    let check = |value: &str| {
        format!(
            "#include {:?}\nconstexpr geometry_msgs::Quaternion q;\nstatic_assert(q.w == {value});\n",
            files.last().unwrap()
        )
    };
    compile(&mut compiler(&check("1.0")), true);
    compile(&mut compiler(&check("0.0")), false);
}

/// A component with an input of every message, and a reference to a service of every interface, of `types.hpp`.
fn everything(types: &str) -> String {
    let mut text = "#include \"asmotion.hpp\"\n#include \"types.hpp\"\n\
                    struct All : asmotion::Component {\n"
        .to_owned();
    let mut package = "";
    let mut count = 0;
    for line in types.lines() {
        if let Some(name) = line.strip_prefix("namespace ") {
            package = name.trim_end_matches(" {");
        }
        let Some(class) = line.strip_prefix("struct ") else {
            continue;
        };
        let class = class.trim_end_matches(" {");
        let is_message = types.contains(&format!("message_name = \"{package}/{class}\""));
        let part = if is_message { "In" } else { "Reference" };
        text +=
            &format!("    asmotion::{part}<{package}::{class}> p{count}{{this, \"p{count}\"}};\n");
        count += 1;
    }
    assert!(count > 40, "{text}");
    text + "};\nint main() { return asmotion::run<All>(); }\n"
}

#[test]
fn a_component_in_cpp_declares_them_as_the_engine_knows_them() {
    if !asmotion_skip::has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("all.cpp");
    let types = source("--messages", "--cpp");
    std::fs::write(&main, everything(&types)).unwrap();
    std::fs::write(folder.path().join("types.hpp"), types).unwrap();
    let mut command = Command::new("c++");
    command.args([
        "-std=c++17",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-I",
    ]);
    command.arg(root().join("cpp")).arg(&main).arg("-o");
    compile(command.arg(folder.path().join("all")), true);
    let composite = folder.path().join("all.composite.toml");
    let all = "schema = \"composite/1\"\n[composite]\nname = \"all\"\n[components.All]\n\
               implementation = { process = \"./all\" }\nactivity = { period_ms = 100 }\n";
    std::fs::write(&composite, all).unwrap();
    let mut check = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    check.args(["check", "--format", "concise"]).arg(&composite);
    let output = check.output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("input `p0`"), "{said}");
    let mut errors = said.lines().filter(|line| line.contains("error["));
    // of the references, which have no wires
    assert!(errors.all(|line| line.contains("C031")), "{said}");
}

#[test]
fn a_typescript_compiler_accepts_them() {
    if !is_installed("tsc") {
        asmotion_skip::TYPESCRIPT.skip();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let files = files(folder.path(), "--typescript", "ts");
    let mut command = Command::new("tsc");
    compile(command.args(["--strict", "--noEmit"]).args(&files), true);
    let text = std::fs::read_to_string(&files[0]).unwrap();
    std::fs::write(&files[0], format!("{text}const wrong: Float = true;\n")).unwrap();
    let mut command = Command::new("tsc");
    compile(command.args(["--strict", "--noEmit"]).arg(&files[0]), false);
}

#[test]
fn it_needs_a_composite_or_messages_and_one_language() {
    for (arguments, words) in [
        (&["--messages"][..], "--python"),
        (&["--python"], "<COMPOSITE>"),
        (&[YOUBOT, "--messages", "--python"], "cannot be used with"),
        (&[YOUBOT, "--cpp", "--python"], "cannot be used with"),
        (&[YOUBOT, "--cpp", "--asyncapi"], "cannot be used with"),
    ] {
        let output = describe(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
}
