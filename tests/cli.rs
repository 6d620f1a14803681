//! The command line: arguments, output and exit codes.

mod check;
mod clocks;
mod constraint;
mod failure;
mod fleet;
mod fmt;
mod mistakes;
mod output;
mod paths;
mod replay;
mod run;
mod run_files;
mod sim;
mod verify;
mod verify_inputs;
mod verify_itf;
mod verify_storage;
mod verify_symbolic;
mod verify_systems;
mod verify_watch;

use assert_cmd::Command;

fn asmotion() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
        .env_remove("NO_COLOR")
        .env_remove("FORCE_COLOR")
        .env_remove("CLICOLOR_FORCE");
    command
}

/// Exit code, standard output, standard error.
fn run(arguments: &[&str]) -> (i32, String, String) {
    let output = asmotion().args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}

/// Writes a file into a new folder. Returns the folder and the path.
fn file(name: &str, text: impl AsRef<[u8]>) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    let path = path.display().to_string();
    (folder, path)
}

const NAVIGATION: &str = "specs/navigation/navigation.composite.toml";

const PATROL: &str = "specs/patrol/patrol.asm";
