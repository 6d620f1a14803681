//! Parsing any text ends soon, with bounded memory and with a report.

#![allow(clippy::disallowed_methods, reason = "how long it takes is the matter")]

use asmotion_diagnostics::{FileId, Report};
use asmotion_syntax::{parse, parse_term};
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Parses a file with this main rule, within a time limit.
fn read(rule: &str) -> Report {
    let begin = Instant::now();
    let text = format!("asm a\nsignature:\ndefinitions:\n  main rule r_Main = {rule}\n");
    let report = parse(FileId(0), &text).report;
    assert!(
        begin.elapsed() < Duration::from_secs(10),
        "took {:?}",
        begin.elapsed()
    );
    report
}

#[test]
fn nesting_is_bounded() {
    let nests = [
        ("a := ", "(", "1", ")"),
        ("a := ", "not ", "b", ""),
        ("a := ", "- ", "b", ""),
        ("a := ", "[", "", "]"),
        ("a := ", "{", "", "}"),
        ("a := ", "<", "", ">"),
        ("a := ", "<1, ", "2", ">"),
        ("a := ", "<$x in s | $x > 1 : ", "1", ">"),
        ("a := ", "<<r_x>> = (", "1", ")"),
        ("a := ", "f(", "1", ")"),
        ("a := ", "if b then ", "1", " endif"),
        ("a := ", "let ($x = 1) in ", "1", " endlet"),
        ("a := ", "(forall $x in s with ", "b", ")"),
        ("", "par ", "skip", " endpar"),
        ("", "if a then ", "skip", " endif"),
        ("", "if a then skip else ", "skip", " endif"),
        ("", "switch a case 1: ", "skip", " endswitch"),
        ("", "while a do ", "skip", ""),
        ("", "choose $x in s do ", "skip", ""),
        ("", "choose $x in s do skip ifnone ", "skip", ""),
        ("", "choose $x in s do ", "skip", " ifnone skip"),
        ("", "local f: D [skip] ", "skip", ""),
        ("", "local f: Seq(Integer) [", "skip", "] skip"),
        ("", "iterate ", "skip", " enditerate"),
    ];
    for (before, open, inside, close) in nests {
        for depth in [1_000, 100_000] {
            let (opened, closed) = (open.repeat(depth), close.repeat(depth));
            let report = read(&format!("{before}{opened}{inside}{closed}"));
            let refused = report
                .diagnostics
                .iter()
                .any(|finding| finding.code == "L039");
            assert!(refused, "`{open}` {depth} times: {report:?}");
            assert!(read(&format!("{before}{opened}")).has_errors());
        }
        let rule = format!("{before}{}{inside}{}", open.repeat(100), close.repeat(100));
        let report = read(&rule);
        assert!(!report.has_errors(), "`{open}` 100 times: {report:?}");
    }
}

#[test]
fn long_is_not_deep() {
    for part in [
        "a := 1 ",
        "forall $x in s do skip ",
        "choose $x in s do skip ifnone skip ",
        "r_x[] ",
    ] {
        let report = read(&format!("par {} endpar", part.repeat(50_000)));
        assert!(
            report.diagnostics.is_empty(),
            "{part}: {:?}",
            report.diagnostics.first()
        );
    }
    for (before, item, last) in [
        ("s := {", "1, ", "1}"),
        ("a := ", "1 + ", "1"),
        ("a := ", "1 * 2 - ", "1"),
        ("a := (", "b and ", "b) or b"),
        ("a := ", "b implies ", "b"),
    ] {
        let report = read(&format!("{before}{}{last}", item.repeat(100_000)));
        assert!(
            report.diagnostics.is_empty(),
            "{item}: {:?}",
            report.diagnostics.first()
        );
    }
}

/// Generates a pseudo-random sequence of words, the same in every run.
fn soup(bytes: usize, words: &[&str]) -> String {
    let mut seed = 1_u64;
    let mut text = String::with_capacity(bytes + 16);
    while text.len() < bytes {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        text.push_str(words[(seed >> 33) as usize % words.len()]);
    }
    text
}

const WORDS: &[&str] = &[
    "asm ",
    "signature",
    "definitions",
    ":",
    "rule ",
    "main ",
    "r_x",
    "controlled ",
    "f ",
    "$x ",
    "Integer ",
    "if ",
    "then ",
    "else ",
    "endif ",
    "par ",
    "endpar ",
    "seq ",
    "endseq ",
    "choose ",
    "in ",
    "with ",
    "do ",
    "ifnone ",
    "forall ",
    "let ",
    "endlet ",
    "switch ",
    "case ",
    "endswitch ",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "<",
    ">",
    "<<",
    ">>",
    ",",
    ":=",
    "=",
    "+",
    "-",
    "not ",
    "and ",
    "1 ",
    "2.5 ",
    "'c'",
    "\"text\"",
    "->",
    "|",
    "..",
    ".",
    "skip ",
    "function ",
    "domain ",
    "init ",
    "invariant ",
    "over ",
    "\n",
    "// a\n",
    ";",
    "#",
    "exists ",
    "unique ",
    "while ",
    "local ",
];

#[test]
fn noise_ends_soon() {
    let rules = &WORDS[11..];
    let begin = Instant::now();
    for before in ["", "asm a signature: definitions: main rule r_a = par "] {
        for words in [WORDS, rules] {
            noise(before, &soup(10_000_000, words));
        }
        for word in [
            "a := 1 ) ",
            "( a ",
            ") ",
            "; ",
            "é ",
            "# ",
            "\" ",
            "if ",
            "par skip endpar ",
        ] {
            noise(before, &word.repeat(1_000_000 / word.len()));
        }
    }
    // 10 s on idle cores; quadratic effort would take hours
    assert!(
        begin.elapsed() < Duration::from_secs(600),
        "took {:?}",
        begin.elapsed()
    );
}

fn noise(before: &str, after: &str) {
    let report = parse(FileId(0), &format!("{before}{after}")).report;
    assert!(report.has_errors());
    assert!(
        report.diagnostics.len() < 200,
        "{}",
        report.diagnostics.len()
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn never_panics_on_words(words in prop::collection::vec(prop::sample::select(WORDS), 0..200)) {
        let text = words.concat();
        let parsed = parse(FileId(0), &text);
        prop_assert!(parsed.report.diagnostics.iter().all(|finding| finding.primary.is_some()));
        let _ = parse_term(FileId(0), &text);
    }

    #[test]
    fn never_panics_on_characters(text in "\\PC{0,200}") {
        let _ = parse(FileId(0), &text);
        let _ = parse_term(FileId(0), &text);
    }
}
