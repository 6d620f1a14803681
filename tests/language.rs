//! Programs of the language: their behaviour, the diagnostics of their errors, and the robustness of the pipeline.

#[cfg(feature = "native")]
mod back_ends;
mod builtins;
mod codes;
mod conformance;
mod differences;
mod exits;
mod limits;
mod messages;
mod replay;
mod semantics;
mod specifications;

use asmotion_lang::{MemoryFiles, OpenFailure, Specification};
use std::path::{Path, PathBuf};

/// The folder of these tests.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/language")
}

/// The `.asm` files of a folder, sorted: stem and text.
fn programs(folder: &Path) -> Vec<(String, String)> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    let programs = files
        .into_iter()
        .filter(|file| file.extension().is_some_and(|end| end == "asm"));
    programs
        .map(|file| {
            let stem = file.file_stem().unwrap().to_string_lossy().into_owned();
            (stem, std::fs::read_to_string(file).unwrap())
        })
        .collect()
}

/// Opens a specification. A line `//--- name.asm` in the text begins another file.
fn open(name: &str, text: &str) -> Result<Specification, OpenFailure> {
    let mut files = MemoryFiles::new();
    let mut parts = text.split("//--- ");
    let main = format!("{name}.asm");
    files.add(&main, parts.next().unwrap());
    for part in parts {
        let (path, text) = part.split_once('\n').unwrap();
        files.add(path, text);
    }
    asmotion_lang::open(&main, &files)
}

/// Opens a specification without errors.
fn opened(name: &str, text: &str) -> Specification {
    open(name, text).unwrap_or_else(|failure| panic!("{name}.asm:\n{failure}"))
}
