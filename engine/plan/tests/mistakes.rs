//! Each file of `tests/composites` contains a mistake, marked with its code after `#~`. The rendered diagnostics are
//! reviewed snapshots.

use std::collections::BTreeSet;

use asmotion_plan::Opened;

/// Expected diagnostics of a file as line and code; line 0 for diagnostics without a location in it.
fn expected(text: &str) -> BTreeSet<(usize, String)> {
    let mut expected = BTreeSet::new();
    for (index, line) in text.lines().enumerate() {
        let Some((before, codes)) = line.split_once("#~") else {
            continue;
        };
        let elsewhere = before.trim().is_empty();
        let number = if elsewhere { 0 } else { index + 1 };
        for code in codes.split_whitespace() {
            expected.insert((number, code.to_owned()));
        }
    }
    expected
}

fn found(file: &str, opened: &Opened) -> BTreeSet<(usize, String)> {
    let findings = opened.report.diagnostics.iter().map(|finding| {
        let place = finding.primary.as_ref().map(|label| label.span);
        let here = place.filter(|span| opened.sources.path(span.file) == file);
        let line = here.map_or(0, |span| opened.sources.position(span.file, span.start).0);
        (line, finding.code.to_string())
    });
    findings.collect()
}

/// Drops the warnings about programs outside, which most files use where the implementation of a component does not matter.
fn without_programs(mut opened: Opened) -> Opened {
    opened.report.diagnostics.retain(|finding| {
        let kinds = ["program ", "ROS node ", "Orocos component "];
        finding.code != "C025" || !kinds.iter().any(|kind| finding.message.starts_with(kind))
    });
    opened
}

fn files() -> Vec<String> {
    let folder = std::fs::read_dir("tests/composites").expect("the folder of composites");
    let names = folder.map(|entry| {
        entry
            .expect("an entry")
            .file_name()
            .into_string()
            .expect("a name")
    });
    let mut files: Vec<String> = names.filter(|name| name.ends_with(".toml")).collect();
    files.sort();
    files
}

#[test]
fn it_finds_every_planted_mistake_and_nothing_else() {
    let mut wrong = Vec::new();
    for file in files() {
        let text = std::fs::read_to_string(format!("tests/composites/{file}")).expect("a file");
        let mut opened = crate::support::open("tests/composites", &file);
        if !file.starts_with("c025_") {
            opened = without_programs(opened);
        }
        let (expected, found) = (expected(&text), found(&file, &opened));
        let rendered = crate::support::render::report(&opened.sources, &opened.report);
        if expected != found {
            wrong.push(format!(
                "{file}: expected {expected:?}, found {found:?}\n{rendered}\n"
            ));
        }
        let name = file.trim_end_matches(".toml");
        insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(name, rendered);
        });
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn it_has_a_planted_mistake_for_every_code() {
    let mut planted = BTreeSet::new();
    for file in files() {
        let text = std::fs::read_to_string(format!("tests/composites/{file}")).expect("a file");
        planted.extend(expected(&text).into_iter().map(|(_, code)| code));
    }
    // covered by `tests/hostile.rs`, since no small file triggers them
    let elsewhere = ["C081", "C082", "C116"];
    let codes = [asmotion_composite::CODES, asmotion_plan::CODES].concat();
    let codes: BTreeSet<&str> = codes.iter().map(|code| code.name).collect();
    let missing: Vec<&&str> = codes
        .iter()
        .filter(|code| !planted.contains(**code) && !elsewhere.contains(code))
        .collect();
    assert!(missing.is_empty(), "no composite shows {missing:?}");
    for code in planted {
        assert!(codes.contains(&*code), "{code} is not listed");
    }
}

#[test]
fn c10_annotations_and_composite_that_disagree_are_an_error() {
    for (file, code) in [
        ("c102_not_listed.toml", "C102"),
        ("c103_other_interface.toml", "C103"),
        ("c104_not_annotated.toml", "C104"),
    ] {
        let opened = crate::support::open("tests/composites", file);
        assert!(opened.report.has_errors(), "{file}");
        let mut findings = opened.report.diagnostics.iter();
        assert!(findings.any(|finding| finding.code == code), "{file}");
    }
}
