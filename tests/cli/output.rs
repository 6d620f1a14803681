//! JSON and colours.

use super::{NAVIGATION, asmotion, run};
use serde_json::Value;

#[test]
fn results_as_json_stand_alone_on_standard_output() {
    for arguments in [
        &["run", NAVIGATION, "--json"][..],
        &["sim", "specs/patrol/patrol.asm", "--json"],
        &["check", NAVIGATION, "specs/patrol/patrol.asm", "--json"],
    ] {
        let (code, out, _) = run(arguments);
        assert_eq!(code, 0, "{arguments:?}");
        for line in out.lines() {
            let object: Value = serde_json::from_str(line).unwrap();
            assert_eq!(object["v"], 1, "{line}");
            assert!(object["type"].is_string(), "{line}");
        }
    }
}

#[test]
fn colour_follows_the_flag_and_the_variables() {
    let coloured = |arguments: &[&str]| {
        let (_, out, err) = run(arguments);
        (out + &err).contains('\u{1b}')
    };
    let demo = ["demo", "--speed", "0", "--quiet"];
    assert!(!coloured(&demo), "a pipe gets no colour");
    assert!(coloured(&[&demo[..], &["--color", "always"]].concat()));
    let output = asmotion()
        .args(demo)
        .args(["--color", "auto"])
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    assert!(!String::from_utf8_lossy(&output.stdout).contains('\u{1b}'));
}
