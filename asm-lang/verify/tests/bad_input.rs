//! Specifications and properties that cannot be verified.

use crate::models::LAMP;
use crate::open;
use asmotion_verify::{CODES, Engine, Options, verify};

/// The codes of the findings that refuse a specification.
fn refused(text: &str, options: &Options) -> Vec<&'static str> {
    match verify(open(text), options, &mut |_| true) {
        Ok(_) => Vec::new(),
        Err(refusal) => {
            let findings = refusal.report.diagnostics.iter();
            findings.map(|it| it.code.name).collect()
        }
    }
}

/// Compares the rendered findings with a snapshot.
fn snapshot(name: &str, text: &str, options: &Options) {
    let Err(refusal) = verify(open(text), options, &mut |_| true) else {
        panic!("{name} is verified");
    };
    let sources = &refusal.specification.sources;
    let rendered = asmotion_lang::render_all(&refusal.report, sources, asmotion_lang::Style::Plain);
    insta::assert_snapshot!(name, rendered);
}

#[test]
fn codes_have_examples_that_are_true() {
    for code in CODES {
        let (wrong, corrected) = (code.example("asm wrong"), code.example("asm corrected"));
        let (Some(wrong), Some(corrected)) = (wrong, corrected) else {
            // about large formulas, several files, or options
            let others = [
                "M004", "M007", "M008", "M009", "M010", "M011", "M012", "M013",
            ];
            assert!(others.contains(&code.name), "{} has no example", code.name);
            continue;
        };
        let engine = match code.name {
            "M030" => Engine::Symbolic,
            _ => Engine::Explicit,
        };
        let options = Options {
            engine,
            ..Options::default()
        };
        assert_eq!(refused(wrong, &options), [code.name]);
        snapshot(code.name, wrong, &options);
        assert_eq!(refused(corrected, &options), [""; 0], "{}", code.name);
    }
}

#[test]
fn a_property_with_an_unknown_name_is_refused() {
    let property = |text: &str| Options {
        properties: vec![text.to_owned()],
        ..Options::default()
    };
    assert_eq!(refused(LAMP, &property("ag(leevl = 0)")).len(), 1);
    assert_eq!(refused(LAMP, &property("level + 1")).len(), 1);
    assert_eq!(refused(LAMP, &property("ag(")).len(), 1);
    assert_eq!(refused(LAMP, &property("not ag(f(isOn))")), ["M003"]);
    assert_eq!(
        refused(
            LAMP,
            &property("(exist $i in {0 : 3} with ag(level != $i))")
        ),
        ["M003"]
    );
}

/// A temporal operator has no value in a single state. Nothing that is about single states may contain one: a fairness constraint
/// would never be true, so that every property holds.
#[test]
fn conditions_about_one_state_have_no_temporal_operators() {
    let lamp = |line: &str| {
        let text = LAMP.replace("main rule", &format!("{line}\n  main rule"));
        refused(&text, &Options::default())
    };
    for line in [
        "JUSTICE ef(isOn)",
        "COMPASSION(isOn, af(isOn))",
        "INVAR ag(isOn)",
        "invariant bright over isOn: ag(isOn)",
    ] {
        assert_eq!(lamp(line), ["M003"], "{line}");
    }
    let all = ["ef(isOn)".to_owned()];
    for options in [
        Options {
            assumptions: all.to_vec(),
            ..Options::default()
        },
        Options {
            possible: all.to_vec(),
            ..Options::default()
        },
        Options {
            ends: Some("ef(isOn)".to_owned()),
            ..Options::default()
        },
    ] {
        assert_eq!(refused(LAMP, &options), ["M003"]);
    }
    let text = LAMP.replace("main rule", "JUSTICE ef(isOn)\n  main rule");
    snapshot("fairness_of_a_formula", &text, &Options::default());
}

#[test]
fn wrong_properties_are_explained() {
    for (name, text) in [
        ("property_unknown_name", "ag(leevl = 0)"),
        ("property_unknown_literal", "ag(level = HIGH)"),
        ("property_unknown_operator", "agg(isOn)"),
        ("property_not_a_truth_value", "level + 1"),
        ("property_ill_typed", "ag(isOn implies level)"),
        ("property_incomplete", "ag("),
        ("property_of_two_logics", "not ag(f(isOn))"),
        ("property_in_capitals", "AG(isOn implies AX(isOn))"),
        ("property_in_words", "always isOn"),
        ("property_with_a_misspelt_name", "inv_of"),
    ] {
        let options = Options {
            properties: vec![text.to_owned()],
            ..Options::default()
        };
        snapshot(name, LAMP, &options);
    }
}

#[test]
fn formulas_that_are_too_large_are_refused() {
    let property = "exN(isOn, 4000000000n)".to_owned();
    let options = Options {
        properties: vec![property.clone()],
        only: vec![property],
        ..Options::default()
    };
    assert_eq!(refused(LAMP, &options), ["M004"]);
    snapshot("M004", LAMP, &options);
}
