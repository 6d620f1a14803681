//! The pages of the SCDL codes: the wrong example produces the code, the corrected one does not.
#![allow(missing_docs, clippy::expect_used, reason = "tests")]

mod support;

use asmotion_composite::Tables;
use asmotion_diagnostics::{Code, Diagnostic, Report, Severity};
use asmotion_scdl::CODES;

/// The findings about an example: SCDL to import, or a composite file to export.
fn found(code: &Code, which: &str) -> Report {
    if let Some(text) = code.example(&format!("xml {which}")) {
        let files = [("example.composite".to_owned(), text.to_owned())];
        return asmotion_scdl::import(&files, &Tables::EMPTY).report;
    }
    let text = code.example(&format!("toml {which}")).expect("an example");
    let opened = support::open(&[("example.toml".to_owned(), text.to_owned())]);
    let composite = opened.composite.expect("a composite");
    asmotion_scdl::export(&composite).expect("no fault").report
}

#[test]
fn pages_have_examples_that_are_true() {
    for code in CODES {
        let wrong = found(code, "wrong").diagnostics;
        let codes: Vec<_> = wrong.iter().map(|it| it.code.name).collect();
        assert!(
            codes.contains(&code.name),
            "{}: the wrong example earns {codes:?}",
            code.name
        );
        let corrected = found(code, "corrected").diagnostics;
        let is_left = |it: &&Diagnostic| it.severity == Severity::Error || it.code == *code;
        let left: Vec<_> = corrected
            .iter()
            .filter(is_left)
            .map(|it| &it.message)
            .collect();
        assert!(
            left.is_empty(),
            "{}: the corrected example earns {left:?}",
            code.name
        );
    }
}

/// Snapshot of the rendered findings of all wrong examples.
#[test]
fn findings_are_what_a_person_has_read() {
    let shown: Vec<String> = CODES
        .iter()
        .map(|code| {
            let findings = found(code, "wrong").diagnostics;
            let of_code = findings.iter().filter(|it| it.code == *code);
            let messages: Vec<String> = of_code
                .map(|it| {
                    let labels = it.primary.iter().chain(&it.secondary);
                    let labels: Vec<&str> = labels.map(|label| &*label.text).collect();
                    format!(
                        "{}: {}\n  {labels:?}\n  {:?}",
                        code.name, it.message, it.helps
                    )
                })
                .collect();
            messages.join("\n")
        })
        .collect();
    insta::assert_snapshot!(shown.join("\n"));
}

#[test]
fn codes_have_a_file_each() {
    let files = std::fs::read_dir("src/codes").expect("the codes");
    let files = files.map(|file| file.expect("a file").file_name());
    let mut files: Vec<_> = files.map(|name| name.into_string()).collect();
    files.sort();
    let listed = CODES.iter();
    let listed: Vec<_> = listed
        .map(|code| Ok(format!("{}.rs", code.name.to_lowercase())))
        .collect();
    assert_eq!(files, listed);
}
