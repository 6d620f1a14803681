//! Compares with the reference implementation: its traces of small programs and of its whole corpus.
//!
//! The traces are in `../shared/conformance`, the corpus (a checkout of asmeta/asmeta) at the path in the environment
//! variable `ASMETA_CORPUS`. Without them, the tests print a notice and pass.

mod compare;
mod reference;

use asmotion::DiskLoader;
use asmotion_lang::ReadOptions;
use compare::agree;
use reference::ours;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Programs for which the reference behaves differently, with the reason that our behaviour is right. All of them agree
/// with `--compat asmeta`.
const DIFFERENT: &[(&str, &str)] = &[
    ("se07_lazy_init", INITIAL),
    ("sf01_lazy_init", INITIAL),
    ("sf02_lazy_init_seq", INITIAL),
    ("se20_overflow", "a number beyond 64 bits is a fault"),
    (
        "se28_dyn_concrete",
        "the initial elements of a dynamic domain count",
    ),
    ("se51_difference", "`difference` is that of sets"),
    ("se63_tostring", "a set is written as a set"),
    ("se70_self_after", "`self` is restored after a program"),
    ("sf36_self_nested", "`self` is restored after a program"),
    ("sf37_self_par", "`self` is restored after a program"),
    ("sf08_nat_minus", "a Natural is not negative"),
    ("sf76_result_in_par", "`result` is local to its call"),
    (
        "se27_arg_domain",
        "a location outside the domain cannot be written",
    ),
];

/// Programs for which the reference behaves differently in any mode.
const ALWAYS_DIFFERENT: &[(&str, &str)] = &[
    ("se36_choose_enum", "the first candidate is the least one"),
    ("se89_tuple_arg", "a tuple stands for all arguments"),
    ("sf13_mon_par_seq", "an input is read once a step"),
    // rejected on purpose
    ("lx71_main_params", "an error, not a remark"),
    ("se21_bigint", "a number beyond 64 bits is an error"),
    ("sf73_two_mains", "a name for two rules is an error"),
];

const INITIAL: &str = "initial values speak of the initial state";

#[test]
fn agrees_on_small_programs() {
    let all: Vec<_> = DIFFERENT.iter().chain(ALWAYS_DIFFERENT).collect();
    for (compatible, explained) in [(false, all), (true, ALWAYS_DIFFERENT.iter().collect())] {
        let Some((count, different)) = small_programs(compatible) else {
            return;
        };
        let explained: BTreeSet<String> = explained
            .into_iter()
            .map(|(name, _)| (*name).to_owned())
            .collect();
        println!("{count} small programs, {} different", different.len());
        assert_eq!(different, explained, "compatible: {compatible}");
    }
}

/// The number of small programs, and the names of those with differences.
fn small_programs(compatible: bool) -> Option<(usize, BTreeSet<String>)> {
    let folder = unpacked("micro.tar.xz")?;
    let options = ReadOptions {
        compatible,
        initial: None,
    };
    let mut different = BTreeSet::new();
    let mut count = 0;
    for traces in ["traces", "traces_seed7"] {
        for file in files(&folder.path().join("micro").join(traces)) {
            let name = file.file_stem().unwrap().to_string_lossy().into_owned();
            let path = folder.path().join("micro").join(format!("{name}.asm"));
            let reference = std::fs::read_to_string(&file).unwrap();
            count += 1;
            let ours = ours(&path, &reference, &DiskLoader, &options);
            if !ours.is_some_and(|ours| agree(&reference, &ours)) {
                different.insert(name);
            }
        }
    }
    Some((count, different))
}

/// Number of files in the corpus that the reference accepts, which is all of them.
const ACCEPTED: usize = 1663;

/// Numbers of runs without choices: those that the reference completes without inputs, and those with the inputs of two
/// seeds.
const RUNS: [(&str, usize); 3] = [("none", 452), ("seed1", 519), ("seed2", 520)];

/// Runs with differences: reason, run, file. `docs/conformance.md` explains the reasons.
const EXCEPTIONS: &str = include_str!("conformance/exceptions.tsv");

/// Runs with differences with `--compat asmeta`: run, file.
const COMPATIBLE_EXCEPTIONS: &str = include_str!("conformance/compatible.tsv");

#[test]
fn agrees_on_the_corpus() {
    let Some(corpus) = asmotion_skip::corpus() else {
        return;
    };
    let Some(folder) = unpacked("traces.tar.xz") else {
        return;
    };
    let Some(index) = shared("corpus.tsv") else {
        return;
    };
    let index = std::fs::read_to_string(index).unwrap();
    let mut accepted = 0;
    let mut counts = [0; RUNS.len()];
    let mut different = BTreeSet::new();
    let mut compatible = BTreeSet::new();
    for line in index.lines().skip(1) {
        let columns: Vec<&str> = line.split('\t').collect();
        let (path, parsed, choices, outcome) = (columns[0], columns[16], columns[7], columns[20]);
        if parsed != "OK" {
            continue;
        }
        let file = corpus.join(path);
        accepted += usize::from(asmotion_lang::open(&file.to_string_lossy(), &DiskLoader).is_ok());
        for ((run, _), count) in RUNS.iter().zip(&mut counts) {
            let trace = folder
                .path()
                .join("traces")
                .join(run)
                .join(path)
                .with_extension("trace");
            let Ok(reference) = std::fs::read_to_string(trace) else {
                continue;
            };
            if choices == "0" && (*run != "none" || outcome == "OK") {
                *count += 1;
                let key = format!("{run}\t{path}");
                for (mode, different) in [(false, &mut different), (true, &mut compatible)] {
                    let options = ReadOptions {
                        compatible: mode,
                        initial: None,
                    };
                    let ours = ours(&file, &reference, &DiskLoader, &options);
                    if !ours.is_some_and(|ours| agree(&reference, &ours)) {
                        different.insert(key.clone());
                    }
                }
            }
        }
    }
    println!(
        "{accepted} files accepted, {counts:?} runs, {} differ",
        different.len()
    );
    assert_eq!(accepted, ACCEPTED);
    assert_eq!(counts, RUNS.map(|(_, count)| count));
    let explained: BTreeSet<String> = EXCEPTIONS
        .lines()
        .filter_map(|line| Some(line.split_once('\t')?.1.to_owned()))
        .collect();
    assert_eq!(different, explained);
    let explained: BTreeSet<String> = COMPATIBLE_EXCEPTIONS.lines().map(str::to_owned).collect();
    assert_eq!(compatible, explained);
}

/// The documentation lists the differences that the test allows, with all reasons.
#[test]
fn explains_every_exception() {
    let page =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/conformance.md"))
            .unwrap();
    for line in EXCEPTIONS.lines() {
        let columns: Vec<&str> = line.split('\t').collect();
        let [reason, run, path] = columns.as_slice() else {
            panic!("not an exception: {line}");
        };
        assert!(
            page.contains(&format!("### {reason}")),
            "no reason {reason}"
        );
        let row = format!("| `{path}` | {run} |");
        assert!(page.contains(&row), "missing: {row}");
    }
    let rows = page.lines().filter(|line| {
        line.starts_with("| `") && line.ends_with("| none |")
            || line.ends_with("| seed1 |")
            || line.ends_with("| seed2 |")
    });
    assert_eq!(rows.count(), EXCEPTIONS.lines().count());
}

/// A file of the reference results; `None` if it is missing.
fn shared(file: &str) -> Option<PathBuf> {
    asmotion_skip::shared(&format!("conformance/{file}"))
}

/// Unpacks an archive of the shared folder. Returns `None` if it is missing.
fn unpacked(archive: &str) -> Option<tempfile::TempDir> {
    let archive = shared(archive)?;
    let folder = tempfile::tempdir().unwrap();
    let tar = std::process::Command::new("tar")
        .arg("-xJf")
        .arg(&archive)
        .arg("-C")
        .arg(folder.path())
        .status();
    assert!(
        tar.unwrap().success(),
        "cannot unpack {}",
        archive.display()
    );
    Some(folder)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    files
}
