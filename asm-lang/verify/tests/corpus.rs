//! Verdicts on the examples of AsmetaSMV, which their authors state in the tests of that tool.
//!
//! The repository of ASMETA is not part of the project: `ASMETA_CORPUS` names its folder. Without it, the tests print a notice and pass.

use asmotion_lang::MemoryFiles;
use asmotion_verify::{Engine, Limits, Options, PropertyKind, Verdict, verify};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

/// Folder of the corpus with the tests of AsmetaSMV and their specifications.
const PROJECT: &str = "code/extensions/asmetasmv/asmeta.smv.test";

/// The files with its statements about all properties of a specification.
const TESTS: [&str; 2] = [
    "test_src/org/asmeta/nusmv/main/AsmetaSMVnoFlattenerTest.java",
    "test_src/org/asmeta/nusmv/main/AsmetaSMVwithFlattenerTest.java",
];

/// Limit for the states of a specification.
const MAX_STATES: u64 = 50_000;

/// Limit for the states of a specification that both engines verify.
const MAX_BOTH: u64 = 1000;

/// Limit for the time of a verification.
const MAX_TIME: Duration = Duration::from_secs(20);

/// Verdicts that its tests list one by one, in the order of the specification: `t` holds, `f` is violated.
const LISTED: [(&str, &str); 5] = [
    ("examples/agentsChoose.asm", "fftttttt"),
    ("examples/agentsChoose2.asm", "tf"),
    ("examples/agentsChoose4.asm", "tft"),
    ("examples/philosophersPhdThesis.asm", "tftt"),
    ("examples/taxi.asm", "tttttttttft"),
];

/// Specifications with other verdicts here, as in the order of the specification, and the reason.
///
/// The method of the tests that asserts one verdict for all properties leaves out the properties of CTL, so a wrong statement fails none of
/// them.
const DIFFERENT: [(&str, &str, &str); 7] = [
    (
        "examples/derivedCtlCheck.asm",
        "tttttttttftttt",
        "compares an integer with the number that stands for undef in the translation",
    ),
    (
        "examples/derivedLet.asm",
        "ffff",
        "an equivalence with an undefined operand is undef, and a Boolean is never undef in the translation",
    ),
    (
        "examples/derivedLocArgs.asm",
        "ffff",
        "an equivalence with an undefined operand is undef, and a Boolean is never undef in the translation",
    ),
    (
        "examples/seq4.asm",
        "fftt",
        "the new value of an input is independent of the one that the step read",
    ),
    (
        "examples/taxi/main.asm",
        "ttttfffffftt",
        "two rules update a location to different values, and the step fails",
    ),
    (
        "examples/ticTacToe/ticTacToe_simulator.asm",
        "ftttttt",
        "the opponent is free to let the player win, as the run shows that `sim` repeats",
    ),
    (
        "examples/sultanSuccessors/sultan.asm",
        "tftf",
        "states the same verdict for a property and its negation",
    ),
];

/// Returns what the tests state: a specification, and whether all its properties hold, or all are violated.
fn statements(project: &Path) -> BTreeMap<String, bool> {
    let mut all = BTreeMap::new();
    for file in TESTS {
        let text = std::fs::read_to_string(project.join(file)).unwrap();
        let code = text.lines().map(|line| line.split("//").next().unwrap());
        for line in code {
            for (method, holds) in [
                ("testAllCtlPropsAreTrue(\"", true),
                ("testAllCtlPropsAreFalse(\"", false),
            ] {
                let argument = line.split(method).nth(1);
                let path = argument.and_then(|it| it.split('"').next());
                all.extend(path.map(|path| (path.to_owned(), holds)));
            }
        }
    }
    all
}

/// Adds the specifications of a folder, and of the folders in it.
fn add_folder(project: &Path, folder: &str, files: &mut MemoryFiles) {
    for entry in std::fs::read_dir(project.join(folder)).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            add_folder(project, &name, files);
        } else if name.ends_with(".asm") {
            let bytes = std::fs::read(entry.path()).unwrap();
            files.add(&name, String::from_utf8_lossy(&bytes));
        }
    }
}

/// Verdicts of the properties of CTL within a number of states; `None` if a specification is refused or too large.
fn verdicts(path: &str, files: &MemoryFiles, engine: Engine, states: u64) -> Option<String> {
    let specification = asmotion_lang::open(path, files).ok()?;
    let options = Options {
        engine,
        limits: Limits {
            states: Some(states),
            ..Limits::default()
        },
        ..Options::default()
    };
    // a step with many inputs and choices takes long even if there are few states
    let begun = Instant::now();
    let verification = verify(specification, &options, &mut |_| begun.elapsed() < MAX_TIME).ok()?;
    let properties = verification.properties.iter();
    let of_ctl = properties.filter(|it| it.kind == PropertyKind::Ctl);
    of_ctl
        .map(|property| match property.verdict {
            Verdict::Holds(_) => Some('t'),
            Verdict::Violated(_) => Some('f'),
            Verdict::Unknown => None,
        })
        .collect()
}

#[test]
fn examples_of_asmeta_smv_have_the_verdicts_that_its_tests_state() {
    let Some(corpus) = asmotion_skip::corpus() else {
        return;
    };
    let project = corpus.join(PROJECT);
    let mut files = MemoryFiles::new();
    add_folder(&project, "examples", &mut files);
    let stated = statements(&project);
    let (mut same, mut both, mut unknown, mut wrong) = (0, 0, Vec::new(), Vec::new());
    let listed = LISTED.iter().map(|(path, _)| (*path).to_owned());
    let different = DIFFERENT.iter().map(|(path, ..)| (*path).to_owned());
    let paths = stated.keys().cloned().chain(listed).chain(different);
    let paths: BTreeSet<String> = paths.collect();
    for path in &paths {
        if !project.join(path).exists() {
            continue;
        }
        let Some(found) = verdicts(path, &files, Engine::Explicit, MAX_STATES) else {
            unknown.push(path.as_str());
            continue;
        };
        if let Some(symbolic) = verdicts(path, &files, Engine::Symbolic, MAX_BOTH) {
            assert_eq!(symbolic, found, "{path}");
            both += 1;
        }
        let here = DIFFERENT.iter().map(|(path, found, _)| (*path, *found));
        let expected = here.chain(LISTED).find(|(of, _)| of == path);
        let is_same = match (expected, stated.get(path)) {
            (Some((_, expected)), _) => found == expected,
            (None, Some(true)) => !found.contains('f'),
            (None, Some(false)) => !found.contains('t'),
            (None, None) => false,
        };
        if is_same {
            same += 1;
        } else {
            wrong.push(format!("{path}: {found}"));
        }
    }
    println!("{same} as stated, {both} in both engines; too large: {unknown:?}");
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(same > 95 && both > 60, "{same} {both} {unknown:?}");
}
