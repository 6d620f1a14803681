//! Rules outside a file.

use asmotion_diagnostics::FileId;
use asmotion_syntax::{parse_assignment, parse_rule, parse_term_in};

#[test]
fn they_stand_alone() {
    assert!(parse_rule(FileId(0), "par skip x := 1 endpar").is_ok());
    let report = parse_rule(FileId(0), "skip skip").unwrap_err();
    assert_eq!(report.diagnostics[0].code, "L058", "{report:#?}");
}

#[test]
fn an_assignment_has_two_sides() {
    assert!(parse_assignment(FileId(0), "f(1) := 2").is_ok());
    let report = parse_assignment(FileId(0), "skip").unwrap_err();
    assert_eq!(report.diagnostics[0].code, "L063", "{report:#?}");
}

#[test]
fn a_part_of_a_text_keeps_its_place() {
    let text = "check \"a\" and\n  b + ; step";
    let report = parse_term_in(FileId(0), text, 16..20).unwrap_err();
    let at = report.diagnostics[0].primary.as_ref().unwrap().span;
    assert_eq!(
        (report.diagnostics[0].code.name, at.start),
        ("L030", 19),
        "{report:#?}"
    );
    let term = parse_term_in(FileId(0), text, 16..18).unwrap();
    assert_eq!(term.span.range(), 16..17);
}
