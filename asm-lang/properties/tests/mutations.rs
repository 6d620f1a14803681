//! The properties for small mutations of existing programs: a bounded, deterministic version of
//! what the fuzzers do.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "helpers of tests")]
#![allow(clippy::disallowed_methods, reason = "the programs are on the disk")]

use asmotion_properties::{check, fmt, parse};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Folders with programs, relative to the root of the repository.
const SEEDS: &[&str] = &[
    "tests/language/semantics",
    "tests/language/messages",
    "asm-lang/syntax/tests/errors",
    "asm-lang/syntax/tests/layout",
    "asm-lang/syntax/tests/scenarios",
    "specs/navigation",
    "specs/allocation",
];

/// Pairs of brackets and keywords, nested many times around a part of a program.
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

/// Returns the positions between words, numbers, runs of blanks and signs.
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

/// Returns the range between two borders, at most a few lines long.
fn part(text: &[u8], random: &mut impl Rng) -> std::ops::Range<usize> {
    let borders = borders(text);
    let first = random.random_range(0..borders.len());
    let last = (first + random.random_range(0..8)).min(borders.len() - 1);
    borders[first]..borders[last]
}

/// Applies a random small change.
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

/// Checks a property for all seeds and for `count` mutations of them.
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

/// Prints the text for which a property panicked.
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
