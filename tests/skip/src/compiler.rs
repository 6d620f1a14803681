//! Compiles programs in C and C++ for tests, with the headers of `cpp/` and with sanitizers.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};

/// Options of every compilation.
const OPTIONS: &[&str] = &[
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Werror",
    "-O0",
    "-g1",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
];

/// Returns whether there are compilers for C and for C++.
pub(crate) fn is_installed() -> bool {
    ["cc", "c++"].into_iter().all(|program| {
        let mut command = Command::new(program);
        command.arg("--version").stdin(Stdio::null());
        command.output().is_ok_and(|it| it.status.success())
    })
}

/// Compiles a program once for all tests of a build.
#[expect(
    clippy::panic,
    reason = "a program that does not compile is a failed test"
)]
pub(crate) fn compile(source: &str) -> PathBuf {
    static COMPILING: Mutex<()> = Mutex::new(());
    let _one_at_a_time = COMPILING.lock().unwrap_or_else(PoisonError::into_inner);
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source = repository.join(source);
    let folder = source.parent().unwrap_or(&repository);
    let program = target(&source, &[&repository.join("cpp"), folder]);
    if program.exists() {
        return program;
    }
    let is_c = source.extension().is_some_and(|it| it == "c");
    let (compiler, standard) = if is_c {
        ("cc", "-std=gnu99")
    } else {
        ("c++", "-std=c++17")
    };
    let unfinished = program.with_extension(std::process::id().to_string());
    let mut command = Command::new(compiler);
    command.arg(standard).args(OPTIONS).arg("-I");
    command.arg(repository.join("cpp")).arg("-o");
    command.arg(&unfinished).arg(&source).stdin(Stdio::null());
    match command.output() {
        Ok(output) if output.status.success() => {}
        other => panic!("{command:?}: {other:?}"),
    }
    std::fs::rename(&unfinished, &program)
        .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    program
}

/// The path of the compiled program, whose name depends on the sources: another build finds it.
fn target(source: &Path, folders: &[&Path]) -> PathBuf {
    let mut hasher = DefaultHasher::new();
    OPTIONS.hash(&mut hasher);
    let mut files = BTreeSet::from([source.to_owned()]);
    for entry in folders.iter().flat_map(std::fs::read_dir).flatten() {
        files.extend(entry.map(|it| it.path()));
    }
    let is_header = |it: &PathBuf| it.extension().is_some_and(|it| it == "h" || it == "hpp");
    for file in files.iter().filter(|it| is_header(it) || *it == source) {
        std::fs::read(file).unwrap_or_default().hash(&mut hasher);
    }
    let tests = std::env::current_exe().unwrap_or_default();
    let folder = tests.ancestors().nth(2).unwrap_or(Path::new("."));
    let folder = folder.join("cpp");
    // compilation reports a folder that cannot be created
    let _ = std::fs::create_dir_all(&folder);
    let name = source.file_stem().unwrap_or_default().to_string_lossy();
    folder.join(format!("{name}-{:016x}", hasher.finish()))
}
