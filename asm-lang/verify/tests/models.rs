//! Models with known verdicts.

use crate::{verdicts, verified};
use asmotion_verify::{Limits, Options};

pub const PHILOSOPHERS: &str = include_str!("models/philosophers.asm");
pub const LAMP: &str = include_str!("models/lamp.asm");
pub const FAULTY: &str = include_str!("models/faulty.asm");

#[test]
fn philosophers_starve() {
    let verification = verified(PHILOSOPHERS, &Options::default());
    let expected = [
        ("inv_exclusive", "holds"),
        ("inv_wrong", "violated"),
        ("eats", "holds"),
        ("recovers", "violated"),
        ("hungry", "violated"),
        ("ordered", "holds"),
        ("no step fails", "holds"),
        ("no state is stuck", "violated"),
        ("every rule runs", "holds"),
    ];
    let expected = expected.map(|(name, verdict)| (name.to_owned(), verdict));
    assert_eq!(verdicts(&verification), expected);
}

#[test]
fn the_lamp_is_verified_for_the_inputs_that_are_assumed() {
    let verification = verified(LAMP, &Options::default());
    let expected = [
        ("inv_off", "holds"),
        ("obeys", "violated"),
        ("can_be_dark", "holds"),
        ("darkens", "violated"),
        ("darkens_if_pressed", "holds"),
        ("no step fails", "holds"),
        ("no state is stuck", "holds"),
        ("every rule runs", "holds"),
    ];
    let expected = expected.map(|(name, verdict)| (name.to_owned(), verdict));
    assert_eq!(verdicts(&verification), expected);
    assert_eq!(verification.states, 4);
    // of each state with the inputs that the properties mention, one combination of four
    assert_eq!(verification.excluded, 4);
    assert_eq!(verification.assumptions, ["not (isPressed and isLocked)"]);
}

#[test]
fn faults_are_found_with_the_shortest_run() {
    let verification = verified(FAULTY, &Options::default());
    let [faults, stuck, rules] = verification.properties.as_slice() else {
        panic!("{:?}", verdicts(&verification));
    };
    let run = faults.verdict.run().unwrap();
    assert_eq!(run.steps.len(), 1);
    let fault = run.steps[0].fault.as_ref().unwrap();
    assert!(fault.message.contains("`owner`"), "{}", fault.message);
    let [asmotion_verify::Note::Also(others)] = faults.notes.as_slice() else {
        panic!("{:?}", faults.notes);
    };
    assert_eq!(others.len(), 2, "{others:?}");
    assert!(stuck.verdict.holds());
    let [asmotion_verify::Note::Also(rules)] = rules.notes.as_slice() else {
        panic!("{:?}", rules.notes);
    };
    assert_eq!(rules.len(), 1);
    assert!(rules[0].starts_with("r_never "), "{rules:?}");
}

#[test]
fn a_truncated_exploration_never_says_holds_for_all_states() {
    let limits = [
        Limits {
            states: Some(20),
            ..Limits::default()
        },
        Limits {
            depth: Some(2),
            ..Limits::default()
        },
        Limits {
            memory: Some(1),
            ..Limits::default()
        },
    ];
    for limits in limits {
        let options = Options {
            limits,
            ..Options::default()
        };
        let verification = verified(PHILOSOPHERS, &options);
        assert!(verification.incomplete.is_some());
        let all = verdicts(&verification);
        let held: Vec<_> = all
            .iter()
            .filter(|(_, verdict)| *verdict == "holds")
            .collect();
        // rules can be known to run without knowing all states
        assert!(
            held.iter().all(|(name, _)| name == "every rule runs"),
            "{all:?}"
        );
    }
    let stopped =
        asmotion_verify::verify(crate::open(PHILOSOPHERS), &Options::default(), &mut |_| {
            false
        });
    assert!(stopped.unwrap().incomplete.is_some());
}

#[test]
fn properties_assumptions_and_ends_can_be_given() {
    let options = Options {
        properties: vec![
            "ag(level <= 3)".to_owned(),
            "level < 2".to_owned(),
            "f(isOn)".to_owned(),
        ],
        possible: vec!["level = 3".to_owned(), "level = 0 and isOn".to_owned()],
        only: [
            "ag(level <= 3)",
            "level < 2",
            "f(isOn)",
            "level = 3",
            "level = 0 and isOn",
        ]
        .map(str::to_owned)
        .into(),
        assumptions: vec!["not isLocked".to_owned()],
        ..Options::default()
    };
    let verification = verified(LAMP, &options);
    let expected = ["holds", "violated", "violated", "holds", "violated"];
    let found: Vec<&str> = verdicts(&verification)
        .into_iter()
        .map(|(_, verdict)| verdict)
        .collect();
    assert_eq!(found, expected);
    let options = Options {
        ends: Some("(forall $p in Philosopher with phase($p) = HOLDS_LEFT)".to_owned()),
        ..Options::default()
    };
    let verification = verified(PHILOSOPHERS, &options);
    assert!(verdicts(&verification).contains(&("no state is stuck".to_owned(), "holds")));
    let annotated = PHILOSOPHERS.replace("\tmain rule", "\t//@Final HOLDS_LEFT\n\tmain rule");
    let verification = verified(&annotated, &Options::default());
    assert!(verdicts(&verification).contains(&("no state is stuck".to_owned(), "holds")));
}

#[test]
fn fairness_changes_the_verdict_and_nothing_fair_is_said() {
    let fair = LAMP.replace("\tmain rule", "\tJUSTICE isPressed\n\tmain rule");
    let verification = verified(&fair, &Options::default());
    assert!(verdicts(&verification).contains(&("darkens".to_owned(), "holds")));
    let unfair = LAMP.replace(
        "\tmain rule",
        "\tJUSTICE isPressed and isLocked\n\tmain rule",
    );
    let verification = verified(&unfair, &Options::default());
    let darkens = verification
        .properties
        .iter()
        .find(|it| it.name.as_deref() == Some("darkens"));
    let notes = &darkens.unwrap().notes;
    assert!(
        matches!(
            notes.as_slice(),
            [asmotion_verify::Note::Unfair { all: true }]
        ),
        "{notes:?}"
    );
    // infinitely often pressed, though not in states in which the lamp is on: then it is never switched off
    let compassion = LAMP.replace("\tmain rule", "\tCOMPASSION(isOn, isPressed)\n\tmain rule");
    let verification = verified(&compassion, &Options::default());
    assert!(verdicts(&verification).contains(&("darkens".to_owned(), "holds")));
    let restricted = LAMP.replace("\tmain rule", "\tINVAR not isPressed\n\tmain rule");
    let verification = verified(&restricted, &Options::default());
    assert_eq!(verification.states, 1);
}

#[test]
fn vacuous_properties_are_marked() {
    let vacuous = LAMP
        .replace(
            "CTLSPEC obeys: ag(isPressed implies ax(isOn))",
            "CTLSPEC obeys: ag(level = 3 and not isOn implies ax(isOn))",
        )
        .replace(
            "inv_off over isOn, level: isOn or level = 0",
            "inv_off over isOn, level: (level = 1 and not isOn) implies level = 2",
        );
    let verification = verified(&vacuous, &Options::default());
    for name in ["obeys", "inv_off"] {
        let property = verification
            .properties
            .iter()
            .find(|it| it.name.as_deref() == Some(name))
            .unwrap();
        assert!(property.verdict.holds());
        let unmet = property
            .notes
            .iter()
            .any(|note| matches!(note, asmotion_verify::Note::Unmet(unmet) if unmet.len() == 1));
        assert!(unmet, "{:?}", property.notes);
    }
    let others = verification
        .properties
        .iter()
        .filter(|it| it.name.as_deref() == Some("can_be_dark"));
    assert!(others.clone().count() == 1 && others.into_iter().all(|it| it.notes.is_empty()));
}
