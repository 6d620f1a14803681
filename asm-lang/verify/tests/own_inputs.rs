//! A verdict depends on the inputs that a property mentions, and not on those that other properties mention.

use crate::naive::Random;
use crate::{open, verdict_of, verified, verified_system};
use asmotion_verify::{
    EnvironmentModel, KeptExploration, Options, SystemSpecification, verify, verify_again,
};

/// Copies an input, and raises a flag; with these properties.
fn copying(properties: &[&str]) -> String {
    let lines: Vec<String> = properties
        .iter()
        .enumerate()
        .map(|(index, it)| format!("  CTLSPEC c{index}: {it}\n"))
        .collect();
    format!(
        "asm copying
import StandardLibrary
import CTLLibrary
signature:
  monitored left: Boolean
  controlled p: Boolean
  controlled late: Boolean
definitions:
{}  main rule r_Main = par p := left late := true endpar
default init s0:
  function p = false
  function late = false
",
        lines.concat()
    )
}

fn engines() -> Vec<Options> {
    vec![
        Options::default(),
        Options {
            without_grounding: true,
            ..Options::default()
        },
        #[cfg(feature = "symbolic")]
        Options {
            engine: asmotion_verify::Engine::Symbolic,
            ..Options::default()
        },
    ]
}

#[test]
fn other_properties_do_not_change_a_verdict() {
    for options in engines() {
        for (property, expected) in [
            ("ex(p)", "holds"),
            ("ag(ex(p))", "holds"),
            ("ax(p) or ax(not p)", "violated"),
            ("ag(not left or ax(p))", "holds"),
            ("ag(ef(p))", "holds"),
            ("ef(p)", "holds"),
        ] {
            let alone = verified(&copying(&[property]), &options);
            assert_eq!(verdict_of(&alone, "c0"), expected, "{property}");
            let other = copying(&[property, "ag(left implies ax(p))"]);
            let together = verified(&other, &options);
            assert_eq!(verdict_of(&together, "c0"), expected, "{property}");
            assert_eq!(verdict_of(&together, "c1"), "holds");
            let only = Options {
                only: vec!["c0".to_owned()],
                ..options.clone()
            };
            assert_eq!(verdict_of(&verified(&other, &only), "c0"), expected);
        }
    }
}

/// The states are the same; only what follows from their inputs differs.
#[test]
fn properties_without_inputs_need_no_exploration_of_their_own() {
    let text = copying(&["ex(p)", "ag(left implies ax(p))"]);
    for without_grounding in [false, true] {
        let options = Options {
            without_grounding,
            ..Options::default()
        };
        let mut begun = 0;
        let verification = verify(open(&text), &options, &mut |progress| {
            begun += u32::from(progress.states == 1 && progress.explored == 0);
            true
        });
        let verification = verification.unwrap();
        assert_eq!(verdict_of(&verification, "c0"), "holds");
        assert_eq!(verdict_of(&verification, "c1"), "holds");
        assert_eq!(begun, 1, "without grounding: {without_grounding}");
    }
}

/// Each value of a mentioned input is considered, also where the value of the condition does not depend on it.
#[test]
fn a_state_is_considered_with_all_inputs_that_a_property_mentions() {
    for options in engines() {
        for (condition, expected) in [
            ("(not late or left)", "holds"),
            ("(if late then left else true endif)", "holds"),
            ("(if late then true else true endif)", "violated"),
            ("(exists $b in Boolean with $b = false or left)", "holds"),
        ] {
            let property = format!("ag({condition} implies (ax(p) or ax(not p)))");
            let text = copying(&[&property]);
            let found = verified(&text, &options);
            assert_eq!(verdict_of(&found, "c0"), expected, "{property} {options:?}");
            // the input has two values, and `p` follows from it
            let text = text
                .replace("left: Boolean", "side: Side")
                .replace(
                    "signature:",
                    "signature:\n  enum domain Side = {LEFT | RIGHT}",
                )
                .replace("p := left", "p := side = LEFT")
                .replace("or left)", "or side = LEFT)")
                .replace("then left", "then side = LEFT");
            let found = verified(&text, &options);
            assert_eq!(verdict_of(&found, "c0"), expected, "{property} {options:?}");
        }
    }
}

/// A formula holds if it is true in all initial states, with each value of the inputs that it mentions.
#[test]
fn what_is_possible_has_to_be_possible_from_every_start() {
    for options in engines() {
        let text = copying(&["ef(left and not late)", "not ag(not (left and not late))"]);
        let possible = Options {
            possible: vec!["left and not late".to_owned()],
            ..options
        };
        let found = verified(&text, &possible);
        assert_eq!(verdict_of(&found, "c0"), "violated");
        assert_eq!(verdict_of(&found, "c1"), "violated");
        assert_eq!(verdict_of(&found, "left and not late"), "holds");
    }
}

/// The environment decides once, before the first step.
#[test]
fn what_is_possible_has_to_be_possible_in_every_environment() {
    let environment = open(
        "asm decides
import StandardLibrary
signature:
  controlled decided: Boolean
  out left: Boolean
definitions:
  main rule r_Main = if not decided then par decided := true choose $b in Boolean with true do left := $b endpar endif
default init s0:
  function decided = false
",
    );
    let text = copying(&["ef(p)", "ef(late)", "ag(ef(late))"]);
    let environment = EnvironmentModel::Specification(Box::new(environment));
    let system = SystemSpecification::of(open(&text)).with_environment(environment);
    let found = verified_system(system, &Options::default());
    let verdicts = ["c0", "c1", "c2"].map(|it| verdict_of(&found, it));
    assert_eq!(verdicts, ["violated", "holds", "holds"]);
}

/// States that are kept with more inputs than the next properties mention make no difference.
#[test]
fn states_of_the_last_verification_do_not_change_a_verdict() {
    let mut kept = KeptExploration::default();
    let mut again = |properties: &[&str]| {
        let system = SystemSpecification::of(open(&copying(properties)));
        let found = verify_again(system, &Options::default(), &mut kept, &mut |_| true);
        let found = found.unwrap_or_else(|it| panic!("{}", crate::refused(&it)));
        verdict_of(&found, "c0")
    };
    assert_eq!(again(&["ag(left implies ax(p))"]), "holds");
    assert_eq!(again(&["ag(ex(p))"]), "holds");
    assert_eq!(again(&["ax(p) or ax(not p)"]), "violated");
}

#[test]
fn random_properties_have_the_verdicts_that_they_have_alone() {
    let mut random = Random(0x0a1b_2c3d_4e5f_6071);
    let (mut held, mut violated) = (0, 0);
    for _ in 0..150 {
        let text = random.specification().replace(
            "import StandardLibrary\n",
            "import StandardLibrary\nimport CTLLibrary\n",
        );
        let mut properties = Vec::new();
        for _ in 0..3 {
            let operator = random.one_of(&["ex", "ef", "eg", "ag(ex", "ax", "af(ag", "not eg"]);
            let closing = if operator.contains('(') { "))" } else { ")" };
            let of = |random: &mut Random| random.condition(1);
            let first = format!("{operator}({}{closing}", of(&mut random));
            properties.push(match random.below(3) {
                0 => format!("{first} or ax({})", of(&mut random)),
                1 => format!("ag({} implies {first})", of(&mut random)),
                _ => first,
            });
        }
        let with = |properties: &[String], options: &Options| {
            let options = Options {
                properties: properties.to_vec(),
                ..options.clone()
            };
            verified(&text, &options)
        };
        let options = random.below(engines().len() as u64) as usize;
        let options = engines().swap_remove(options);
        let together = with(&properties, &options);
        for property in &properties {
            let alone = with(std::slice::from_ref(property), &Options::default());
            let expected = verdict_of(&alone, property);
            let found = verdict_of(&together, property);
            assert_eq!(found, expected, "{property}\n{properties:?}\n{text}");
            held += u32::from(expected == "holds");
            violated += u32::from(expected == "violated");
        }
    }
    assert!(held > 100 && violated > 100, "{held} {violated}");
}
