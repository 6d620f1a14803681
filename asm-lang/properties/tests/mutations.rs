//! The properties on programs of the language with something changed in them: a bounded run of what
//! the fuzzers do without end, the same every time.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::disallowed_methods, reason = "the programs are on the disk")]

use asmotion_properties::{check, fmt, parse};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Folders with programs, seen from the root.
const SEEDS: &[&str] = &[
    "tests/language/semantics",
    "tests/language/messages",
    "asm-lang/syntax/tests/errors",
    "asm-lang/syntax/tests/layout",
    "asm-lang/syntax/tests/scenarios",
    "specs/navigation",
    "specs/allocation",
];

/// What is put around a part, again and again.
const NESTS: &[(&str, &str)] = &[
    ("(", ")"),
    ("{", "}"),
    ("[", "]"),
    ("<", ">"),
    ("f(", ")"),
    ("not ", ""),
    ("- ", ""),
    ("1 + ", ""),
    ("if true then ", " endif"),
    ("let ($x = 1) in ", " endlet"),
    ("par skip ", " endpar"),
    ("forall $x in {1} do ", ""),
    ("/* ", " */"),
    ("// ", "\n"),
];

fn seeds() -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut paths: Vec<_> = SEEDS
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let extension = path.extension().unwrap_or_default();
            extension == "asm" || extension == "avalla"
        })
        .collect();
    paths.sort();
    paths
        .iter()
        .map(|path| std::fs::read(path).unwrap())
        .collect()
}

/// Where a word, a number, a run of blanks or a sign begins or ends.
fn borders(text: &[u8]) -> Vec<usize> {
    let kind = |byte: u8| match byte {
        b'_' | b'$' => 0,
        byte if byte.is_ascii_alphanumeric() => 0,
        byte if byte.is_ascii_whitespace() => 1,
        byte => byte,
    };
    let differ = |&at: &usize| match (at.checked_sub(1), text.get(at)) {
        (Some(before), Some(&after)) => kind(text[before]) != kind(after),
        _ => true,
    };
    (0..=text.len()).filter(differ).collect()
}

/// A part between two borders, no longer than a line or two.
fn part(text: &[u8], random: &mut impl Rng) -> std::ops::Range<usize> {
    let borders = borders(text);
    let first = random.random_range(0..borders.len());
    let last = (first + random.random_range(0..8)).min(borders.len() - 1);
    borders[first]..borders[last]
}

/// One small change.
fn mutate(text: &mut Vec<u8>, other: &[u8], random: &mut impl Rng) {
    let here = part(text, random);
    let inside = text[here.clone()].to_vec();
    match random.random_range(0..7) {
        0 => drop(text.drain(here)),
        1 => drop(text.splice(here, other[part(other, random)].iter().copied())),
        2 => {
            let there = part(text, random).start;
            text.splice(there..there, inside);
        }
        3 => {
            let times = random.random_range(1..20);
            text.splice(here, inside.repeat(times));
        }
        4 => {
            let (open, close) = NESTS[random.random_range(0..NESTS.len())];
            let times = random.random_range(1..500);
            let (open, close) = (open.repeat(times), close.repeat(times));
            let nested = [open.as_bytes(), &inside, close.as_bytes()].concat();
            text.splice(here, nested);
        }
        5 if !text.is_empty() => {
            let at = random.random_range(0..text.len());
            text[at] = random.random();
        }
        _ => {
            let number = random.random::<i64>() >> random.random_range(0..64);
            text.splice(here, number.to_string().into_bytes());
        }
    }
}

/// Feeds a property with so many changed programs.
fn holds(property: fn(&[u8]), count: usize) {
    let seeds = seeds();
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for seed in &seeds {
        property(seed);
    }
    for _ in 0..count {
        let mut text = seeds[random.random_range(0..seeds.len())].clone();
        for _ in 0..random.random_range(1..4) {
            let other = &seeds[random.random_range(0..seeds.len())];
            mutate(&mut text, other, &mut random);
        }
        let told = Told(&text);
        property(&text);
        drop(told);
    }
}

/// Shows the text a property panicked on.
struct Told<'text>(&'text [u8]);

impl Drop for Told<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("--- this text:\n{}\n---", String::from_utf8_lossy(self.0));
        }
    }
}

#[test]
fn every_text_is_read() {
    holds(parse, 3_000);
}

#[test]
fn every_text_is_checked_and_run() {
    holds(check, 2_000);
}

#[test]
fn every_text_is_formatted() {
    holds(fmt, 3_000);
}
