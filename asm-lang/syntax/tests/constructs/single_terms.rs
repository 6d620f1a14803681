//! Terms outside a file.

use asmotion_diagnostics::FileId;
use asmotion_syntax::parse_term;

#[track_caller]
fn refused(text: &str, code: &str) {
    let report = parse_term(FileId(0), text).unwrap_err();
    assert_eq!(report.diagnostics[0].code, code, "{report:#?}");
}

#[test]
fn nothing_may_follow() {
    refused("1 2", "L058");
    refused("a)", "L033");
    refused("a :=", "L051");
}

#[test]
fn something_must_stand() {
    refused("", "L030");
    refused("(1 +", "L030");
    refused("f(, 1)", "L058");
}
