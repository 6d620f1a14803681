//! Verdicts on the specifications of ASMETA's repository that state properties, and what their authors state about them.
//!
//! `corpus.tsv` has a line for each specification: its path, the verdicts of its properties, what the tests of AsmetaSMV state, and the
//! reason for a difference. The repository itself is not part of the project: `ASMETA_CORPUS` names its folder. Without it, the test
//! prints a notice, and only the table is checked.
//!
//! Verdicts are a letter for each kind of properties, with `t` (holds), `f` (violated) or `?` (not known within the limits) for each
//! property in the order of the file: `C` for CTL, `L` for LTL, `I` for invariants. A specification that is refused has the code of the
//! first error, a module without a main rule `module`, and one that takes many seconds is `slow` and left out. Statements are about all properties of CTL if they have one letter, and otherwise about each one.

use asmotion_lang::diagnostics::LoadError;
use asmotion_lang::{Loader, Report};
use asmotion_verify::{Engine, Limits, Options, PropertyKind, Verdict, Verification, verify};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const TABLE: &str = include_str!("corpus.tsv");

/// Limits for the states of a specification: without a statement about it, and with one.
const MAX_STATES: [u64; 2] = [5000, 50_000];

/// Limit for the states of a specification that both engines verify.
const MAX_BOTH: u64 = 1000;

/// Limit for the memory of a verification, in bytes.
const MAX_MEMORY: u64 = 1 << 30;

const THREADS: usize = 2;

/// Specifications with these verdicts are left out.
const SLOW: &str = "slow";

/// Limit for the time of a verification: a specification that takes longer does not belong into the table.
const MAX_TIME: Duration = Duration::from_secs(60);

struct TableRow<'a> {
    path: &'a str,
    verdicts: &'a str,
    stated: &'a str,
    reason: &'a str,
}

fn rows() -> Vec<TableRow<'static>> {
    let rows = TABLE.lines().filter(|line| !line.is_empty());
    let rows = rows.map(|line| {
        let columns: Vec<&str> = line.split('\t').collect();
        let &[path, verdicts, stated, reason] = columns.as_slice() else {
            panic!("four columns: {line}");
        };
        TableRow {
            path,
            verdicts,
            stated,
            reason,
        }
    });
    rows.collect()
}

/// Loads files from the folder of the repository.
struct Repository(PathBuf);

impl Loader for Repository {
    fn read(&self, path: &str) -> Result<Arc<str>, LoadError> {
        let bytes = std::fs::read(self.0.join(path)).map_err(|error| LoadError {
            path: path.to_owned(),
            reason: error.to_string(),
        })?;
        Ok(String::from_utf8_lossy(&bytes).into())
    }

    fn resolve(&self, from: &str, import: &str) -> Option<String> {
        let folder = Path::new(from).parent().unwrap_or(Path::new(""));
        let beside = folder.join(import.replace('\\', "/"));
        let beside = beside.to_str()?.to_owned();
        let candidates = [format!("{beside}.asm"), beside];
        let found = candidates
            .into_iter()
            .find(|it| self.0.join(it).is_file())?;
        // a file that is imported in several ways is one file
        let whole = self.0.join(found).canonicalize().ok()?;
        let root = self.0.canonicalize().ok()?;
        Some(whole.strip_prefix(root).ok()?.to_str()?.to_owned())
    }
}

fn letter(verdict: &Verdict) -> char {
    match verdict {
        Verdict::Holds(_) => 't',
        Verdict::Violated(_) => 'f',
        Verdict::Unknown => '?',
    }
}

/// The verdicts as in the table.
fn outline(found: &Verification) -> String {
    let kinds = [
        ("C", PropertyKind::Ctl),
        ("L", PropertyKind::Ltl),
        ("I", PropertyKind::Invariant),
    ];
    let parts = kinds.into_iter().filter_map(|(name, kind)| {
        let properties = found.properties.iter().filter(|it| it.kind == kind);
        let letters: String = properties.map(|it| letter(&it.verdict)).collect();
        (!letters.is_empty()).then(|| format!("{name}:{letters}"))
    });
    parts.collect::<Vec<_>>().join(" ")
}

fn first_code(report: &Report) -> String {
    let first = report.diagnostics.iter();
    let mut errors = first.filter(|it| it.severity == asmotion_lang::Severity::Error);
    errors
        .next()
        .map_or_else(String::new, |it| it.code.name.to_owned())
}

/// Verifies a specification within a number of states; `Err` has the code of the error.
fn verified(
    files: &Repository,
    path: &str,
    engine: Engine,
    states: u64,
) -> Result<Verification, String> {
    let specification = asmotion_lang::open(path, files);
    let specification = specification.map_err(|failure| first_code(&failure.report))?;
    if specification.model.main.is_none() {
        return Err("module".to_owned());
    }
    let options = Options {
        engine,
        limits: Limits {
            states: Some(states),
            memory: Some(MAX_MEMORY),
            ..Limits::default()
        },
        ..Options::default()
    };
    let time = match engine {
        Engine::Explicit => MAX_TIME,
        Engine::Symbolic => MAX_TIME / 10,
    };
    let begun = Instant::now();
    let found = verify(specification, &options, &mut |_| begun.elapsed() < time);
    if begun.elapsed() >= time {
        return Err(SLOW.to_owned());
    }
    found.map_err(|refusal| first_code(&refusal.report))
}

/// Returns the verdicts, and whether both engines were asked.
fn examined(files: &Repository, row: &TableRow<'_>) -> (String, bool) {
    let (path, states) = (row.path, MAX_STATES[usize::from(!row.stated.is_empty())]);
    let found = match verified(files, path, Engine::Explicit, states) {
        Ok(found) => found,
        Err(code) => return (code, false),
    };
    let verdicts = outline(&found);
    if found.incomplete.is_some() || found.states > MAX_BOTH {
        return (verdicts, false);
    }
    let symbolic = verified(files, path, Engine::Symbolic, MAX_BOTH);
    let Some(symbolic) = symbolic.ok().filter(|it| it.incomplete.is_none()) else {
        return (verdicts, false);
    };
    assert_eq!(outline(&symbolic), verdicts, "{path}");
    (verdicts, true)
}

#[test]
fn specifications_have_the_verdicts_of_the_table() {
    let Some(corpus) = asmotion_skip::corpus() else {
        return;
    };
    let files = Repository(corpus);
    let rows = rows();
    let (next, both) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let found: Mutex<BTreeMap<usize, String>> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                loop {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(row) = rows.get(at) else {
                        break;
                    };
                    let (verdicts, is_both) = match row.verdicts {
                        SLOW => (SLOW.to_owned(), false),
                        _ => examined(&files, row),
                    };
                    both.fetch_add(usize::from(is_both), Ordering::Relaxed);
                    found.lock().unwrap().insert(at, verdicts);
                }
            });
        }
    });
    let found = found.into_inner().unwrap();
    let (mut table, mut different) = (String::new(), Vec::new());
    for (row, verdicts) in rows.iter().zip(found.values()) {
        let TableRow {
            path,
            stated,
            reason,
            ..
        } = row;
        table += &format!("{path}\t{verdicts}\t{stated}\t{reason}\n");
        if verdicts != row.verdicts {
            different.push(format!("{path}: {verdicts} in place of {}", row.verdicts));
        }
    }
    assert_eq!(found.len(), rows.len());
    println!("{} specifications, {both:?} in both engines", rows.len());
    if !different.is_empty() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus.tsv.new");
        std::fs::write(path, table).unwrap();
    }
    assert!(different.is_empty(), "see `corpus.tsv.new`: {different:#?}");
    assert!(both.into_inner() > 60);
}

/// The table explains each verdict that differs from a statement.
#[test]
fn verdicts_are_those_that_authors_state_or_have_a_reason() {
    let (mut same, mut different) = (0, 0);
    for row in rows() {
        let ctl = row.verdicts.split(' ').find_map(|it| it.strip_prefix("C:"));
        let (Some(ctl), false) = (ctl, row.stated.is_empty()) else {
            assert!(
                row.reason.is_empty() || !row.stated.is_empty(),
                "{}",
                row.path
            );
            continue;
        };
        let stated = match row.stated {
            "t" | "f" => row.stated.repeat(ctl.len()),
            each => each.to_owned(),
        };
        assert_eq!(stated.len(), ctl.len(), "{}", row.path);
        let fits = |(ours, theirs): (char, char)| ours == theirs || ours == '?';
        let is_same = ctl.chars().zip(stated.chars()).all(fits);
        assert_eq!(
            is_same,
            row.reason.is_empty(),
            "{}: {}",
            row.path,
            row.reason
        );
        if is_same {
            same += 1;
        } else {
            different += 1;
        }
    }
    println!("{same} as stated, {different} with a reason");
    assert!(same > 85, "{same}");
}
