//! The specifications of the repository: their properties hold, and notice changes.

use asmotion_lang::{MemoryFiles, Specification};
use asmotion_verify::{Options, Verification, mutants, verify};
use std::collections::BTreeSet;
use std::path::Path;

/// Specifications that are verified alone, by folder and file.
const SPECS: &[(&str, &str)] = &[
    ("allocation", "allocation.asm"),
    ("estop", "estop.asm"),
    ("navigation", "navigate.asm"),
    ("patrol", "patrol.asm"),
    ("recovery", "recovery.asm"),
    ("youbot", "youbot.asm"),
];

/// Opens a specification from a folder, with another text for its file if one is given.
fn open(folder: &Path, file: &str, text: Option<String>) -> Option<Specification> {
    let mut files = MemoryFiles::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|it| it == "asm") {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.add(&name, std::fs::read_to_string(&path).unwrap());
        }
    }
    if let Some(text) = text {
        files.add(file, text);
    }
    asmotion_lang::open(file, &files).ok()
}

/// Names of the properties that hold, without those that every specification should have.
fn holding(verification: &Verification) -> BTreeSet<String> {
    let own = verification
        .properties
        .iter()
        .filter(|it| it.place.is_some());
    let own = own.filter(|it| it.verdict.holds());
    own.map(|it| it.text.clone()).collect()
}

#[test]
fn properties_of_every_specification_kill_a_mutant() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../specs");
    for (folder, file) in SPECS {
        let folder = root.join(folder);
        let original = open(&folder, file, None).unwrap();
        let mutants = mutants(&original);
        assert!(mutants.len() > 3, "{file}");
        let verification = verify(original, &Options::default(), &mut |_| true).unwrap();
        let holds = holding(&verification);
        if holds.is_empty() {
            // nothing but what every specification should have
            continue;
        }
        let limited = Options {
            limits: asmotion_verify::Limits {
                states: Some(100_000),
                ..Default::default()
            },
            ..Options::default()
        };
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let is_killed = |mutant: &asmotion_verify::Mutant| {
            let mutated = open(&folder, file, mutant.applied_to(&text))?;
            let verification = verify(mutated, &limited, &mut |_| true).ok()?;
            let violated = verification.properties.iter();
            let mut violated = violated.filter(|it| it.verdict.is_violated());
            violated.any(|it| holds.contains(&it.text)).then_some(())
        };
        assert!(
            mutants.iter().any(|mutant| is_killed(mutant).is_some()),
            "no property of {file} notices a change"
        );
    }
}
