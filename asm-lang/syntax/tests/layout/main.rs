//! Canonical layout: it loses nothing, keeps the meaning, and is idempotent.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]
#![allow(clippy::disallowed_methods, reason = "the texts are on the disk")]

#[path = "../shared/faithful.rs"]
mod faithful;

use asmotion_diagnostics::FileId;
use asmotion_syntax::format;
use faithful::{formatted, formatted_scenario, quoted};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn files(folder: &Path, kind: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path, kind));
        } else if path.extension().is_some_and(|extension| extension == kind) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Formats a file according to its extension.
fn formatted_as(kind: &str, text: &str) -> Result<Option<String>, String> {
    match kind {
        "avalla" => formatted_scenario(text),
        _ => formatted(text),
    }
}

/// Formats the files of a folder; returns their number, and the failures.
fn format_all(folder: &Path, kind: &str) -> (usize, Vec<String>) {
    let mut count = 0;
    let mut wrong = Vec::new();
    for path in files(folder, kind) {
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        match formatted_as(kind, &text) {
            Ok(Some(_)) => count += 1,
            Ok(None) => {}
            Err(what) => wrong.push(format!("{} {what}", path.display())),
        }
    }
    (count, wrong)
}

#[test]
fn keeps_what_our_programs_say() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (folder, kind) in [
        ("tests/language", "asm"),
        ("specs", "asm"),
        ("benches", "asm"),
        ("asm-lang", "asm"),
        ("specs", "avalla"),
    ] {
        let (count, wrong) = format_all(&root.join(folder), kind);
        assert!(wrong.is_empty(), "{}", wrong.join("\n===\n"));
        assert!(count > 5, "{count} files in {folder}");
    }
}

/// For development only: the corpus is not part of the project.
#[test]
fn keeps_what_the_corpus_says() {
    let Some(corpus) = asmotion_skip::corpus() else {
        return;
    };
    for kind in ["asm", "avalla"] {
        let (count, wrong) = format_all(Path::new(&corpus), kind);
        assert!(
            wrong.is_empty(),
            "{} of them: {}",
            wrong.len(),
            wrong.join("\n===\n")
        );
        println!("{count} .{kind} files formatted");
    }
}

/// Formats the files of `tests/layout`, which are written in various styles; the snapshots were
/// reviewed.
#[test]
fn lays_out() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/layout");
    for kind in ["asm", "avalla"] {
        for path in files(&folder, kind) {
            let text = std::fs::read_to_string(&path).unwrap();
            let name = path.file_stem().unwrap().to_str().unwrap();
            let laid_out = formatted_as(kind, &text).unwrap().unwrap();
            insta::assert_snapshot!(name, laid_out);
        }
    }
}

#[test]
fn leaves_a_text_with_errors_alone() {
    let report = format(
        FileId(0),
        "asm a\nsignature:\ndefinitions:\n rule r_a = par skip",
    )
    .unwrap_err();
    assert!(report.has_errors());
}

#[test]
fn reads_tabs_and_line_ends_of_every_kind() {
    let unix = "asm a\n\nsignature:\n\tcontrolled f: Integer // one\n\n\t/* two\n\t   three */\n\tout g: Integer\n\ndefinitions:\n";
    for end in ["\n", "\r\n", "\r"] {
        for indent in ["\t", "    "] {
            let text = unix.replace('\n', end).replace('\t', indent);
            assert_eq!(format(FileId(0), &text).unwrap(), unix, "{text:?}");
        }
    }
    assert_eq!(format(FileId(0), &format!("\u{feff}{unix}")).unwrap(), unix);
}

#[test]
fn writes_old_spellings_the_new_way() {
    let text = "asm a\nsignature:\ndefinitions:\nfunction f = (exist $x in {1..3} with $x > 1)";
    let expected =
        "asm a\n\nsignature:\n\ndefinitions:\n\tfunction f = (exists $x in {1 : 3} with $x > 1)\n";
    assert_eq!(format(FileId(0), text).unwrap(), expected);
}

/// Checks the layout of a term on one line.
#[track_caller]
fn term(text: &str, expected: &str) {
    let file = format!("asm a\nsignature:\ndefinitions:\nfunction f = {text}\n");
    let laid_out = formatted(&file).unwrap().unwrap();
    let printed = laid_out.lines().last().unwrap().trim_start();
    assert_eq!(printed, format!("function f = {expected}"), "{text}");
}

#[test]
fn leaves_brackets_out_that_nobody_needs() {
    term("((1))", "1");
    term("(a * b) + c", "a * b + c");
    term("a + (b * c)", "a + b * c");
    term("(a + b) + c", "a + b + c");
    term("((a = b) and (c > (d + 1)))", "a = b and c > d + 1");
    term("(a and b) and c", "a and b and c");
    term("not(a)", "not a");
    term("(not a) and b", "not a and b");
    term("f((a), (b + c))", "f(a, b + c)");
    term("f()", "f");
    term("(((a, b)))", "(a, b)");
    term("((a), (b))", "(a, b)");
    term("((exists $x in D))", "(exists $x in D)");
    term("(if a then b endif)", "if a then b endif");
    term("a * (-b)", "a * -b");
}

#[test]
fn keeps_brackets_that_say_something() {
    term("a + (b + c)", "a + (b + c)");
    term("(a + b) * c", "(a + b) * c");
    term("- (a + b)", "-(a + b)");
    term("not (a = b)", "not (a = b)");
    term("a and (b or c)", "a and (b or c)");
    term("a or (b and c)", "a or (b and c)");
    term("(a or b) implies c", "(a or b) implies c");
    term("(a implies b) implies c", "(a implies b) implies c");
    term("(not a) = b", "(not a) = b");
    term("(a = b) = c", "(a = b) = c");
    term("(-2.0) ^ 2.0", "(-2.0) ^ 2.0");
    term("(a * b) mod c", "(a * b) mod c");
    term("(if a then 1 endif) + 1", "(if a then 1 endif) + 1");
    term("<(a > b), 1>", "<(a > b), 1>");
}

#[test]
fn keeps_numbers_apart_that_would_become_one() {
    term("-(i2)", "- i2");
    term("- 1+i2", "- 1+i2");
    term("5 + (i)", "5 + i");
    term("a -i2", "a - i2");
    term("-(-1)", "- -1");
    term("a<-1", "a < -1");
    term("<<1>, <<<r_a>>>>", "<<1>, <<<r_a>>>>");
    term("2.50", "2.50");
}

#[test]
fn lays_out_what_nests_as_deep_as_it_may() {
    let nests = [
        ("x := ", "f(", "1", ")"),
        ("x := ", "- ", "1", ""),
        ("x := ", "1 + ", "1", ""),
        ("x := ", "(1 + ", "1", ")"),
        ("x := ", "if b then ", "1", " endif"),
        ("", "par ", "skip", " endpar"),
        ("", "if a then skip else ", "skip", " endif"),
        ("", "choose $x in s do ", "skip", ""),
    ];
    for (before, open, inside, close) in nests {
        let rule = format!("{before}{}{inside}{}", open.repeat(190), close.repeat(190));
        let text = format!("asm a\nsignature:\ndefinitions:\nmain rule r_Main = {rule}\n");
        let small = std::thread::Builder::new().stack_size(1 << 20);
        let run = small.spawn(move || formatted(&text).unwrap().is_some());
        assert!(run.unwrap().join().unwrap(), "{open}");
    }
}

const COMMENTS: &[&str] = &[
    "// one\n",
    "\n// one\n",
    "\n\n  // one\n\n",
    "//@Note one\n",
    "/* one */",
    " /* one */\n",
    "\n/* one\n     two */ ",
    "/* one\ntwo */",
    "\n\n",
];

/// Returns the positions that accept a comment: not inside a word, a sign, a string or a comment.
fn borders(text: &str) -> Vec<usize> {
    let is_word = |c: char| c.is_alphanumeric() || "_$.!\\\"'".contains(c);
    let mut borders = Vec::new();
    let mut previous = ' ';
    let mut position = 0;
    while let Some(next) = text[position..].chars().next() {
        let length = if text[position..].starts_with("//") {
            text[position..].find('\n').unwrap_or(text.len() - position)
        } else if next == '"' {
            quoted(&text[position..], next)
        } else {
            next.len_utf8()
        };
        if is_word(previous) != is_word(next) || next.is_whitespace() || "()[]{},".contains(next) {
            borders.push(position);
        }
        previous = next;
        position += length;
    }
    borders
}

#[test]
fn keeps_the_names_of_scenarios_blocks_and_invariants() {
    let text = "scenario  a-b.c\nload x.asm\ninvariant i-1 :true ;\nbegin  b(1)-x step end\n\
                execblock  b(1)-x ; execblock s-1.0 : b/2;execblock s-1.0.b;\n";
    let expected = "scenario a-b.c\nload x.asm\ninvariant i-1: true;\nbegin b(1)-x\n\tstep\nend\n\
                    execblock b(1)-x;\nexecblock s-1.0:b/2;\nexecblock s-1.0.b;\n";
    assert_eq!(formatted_scenario(text), Ok(Some(expected.to_owned())));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn keeps_comments_wherever_they_stand(
        which in any::<prop::sample::Index>(),
        places in prop::collection::vec((any::<prop::sample::Index>(), prop::sample::select(COMMENTS)), 1..6),
    ) {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folders = [root.join("tests/layout"), root.join("../../specs")];
        let kinds = ["asm", "avalla"];
        let paths: Vec<PathBuf> =
            folders.iter().flat_map(|folder| kinds.map(|kind| files(folder, kind))).flatten().collect();
        let path = which.get(&paths);
        let kind = path.extension().unwrap().to_str().unwrap();
        let mut text = std::fs::read_to_string(path).unwrap();
        let mut places: Vec<_> = {
            let borders = borders(&text);
            places.iter().map(|(index, comment)| (*index.get(&borders), *comment)).collect()
        };
        places.sort_by_key(|&(at, _)| std::cmp::Reverse(at));
        for (at, comment) in places {
            text.insert_str(at, comment);
        }
        if let Err(what) = formatted_as(kind, &text) {
            return Err(TestCaseError::fail(format!("{what}\n\n{text}")));
        }
    }
}
