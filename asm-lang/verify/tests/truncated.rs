//! Explorations that end early, at any limit, in every engine and storage, with reductions and threads: what they say is what a whole
//! exploration says, and they never say that something holds in all states.

use crate::naive::Random;
use crate::naive_fairness::ways;
use crate::naive_linear::renamed;
use crate::symbolic::formula;
use crate::{independent, open, verified};
use asmotion_verify::{
    CheckedProperty, Engine, FairName, Limits, Options, PropertyKind, Verdict, Verification, verify,
};

/// Specifications with a property of each class.
fn specification(random: &mut Random, round: u32) -> (String, Options) {
    let libraries = "import StandardLibrary\nimport CTLLibrary\nimport LTLLibrary\n";
    let (text, properties, possible) = if round.is_multiple_of(3) {
        let text = renamed(&independent::specification(random));
        let properties = [
            "ag(common < 2)",
            "ef(place(ONE) = 2 and place(THREE) = 1)",
            "ag(ef(common = 0))",
            "g(f(common != 1))",
            "g(place(TWO) = 2 implies o(place(TWO) = 1))",
            "eg(common = 0)",
        ];
        (
            text,
            properties.map(ToOwned::to_owned).to_vec(),
            "common = 2",
        )
    } else {
        let text = random.specification();
        let mut properties = vec![
            format!("ag({})", random.condition(1)),
            format!("ef({})", random.condition(1)),
            "ag(left implies ex(p or q))".to_owned(),
            "g(right implies o(n = 1))".to_owned(),
        ];
        for at in 0..4 {
            properties.push(formula(random, 2, at % 2 == 0));
        }
        (text, properties, "q and n = 2")
    };
    let justice = match round % 4 {
        0 if round.is_multiple_of(3) => "  JUSTICE common = 0\n",
        0 => "  JUSTICE left or p\n",
        _ => "",
    };
    let text = text
        .replace("import StandardLibrary\n", libraries)
        .replace("  main rule", &format!("{justice}  main rule"));
    let fairness = (round % 6 == 3).then(|| FairName {
        name: "Agents".to_owned(),
        is_strong: round % 12 == 3,
    });
    let options = Options {
        properties,
        possible: vec![possible.to_owned()],
        fairness: fairness.into_iter().collect(),
        ..Options::default()
    };
    (text, options)
}

/// A limit that the exploration may or may not reach.
fn limits(random: &mut Random, whole: &Verification) -> Limits {
    let mut limits = Limits::default();
    match random.below(4) {
        0 => limits.states = Some(1 + random.below(whole.states + 1)),
        1 => limits.depth = Some(random.below(u64::from(whole.depth) + 2) as u32),
        2 => limits.memory = Some(1 + random.below(whole.memory + 100)),
        _ => {}
    }
    limits
}

/// Returns `true` if a property holds because of a run, or of rules that were executed.
fn is_shown(property: &CheckedProperty) -> bool {
    property.kind == PropertyKind::RulesRun || property.verdict.run().is_some()
}

fn compare(found: &Verification, whole: &Verification, shown: &str) -> (u32, u32) {
    let (mut unknown, mut violated) = (0, 0);
    for property in &found.properties {
        let same = |it: &&CheckedProperty| {
            (&it.kind, &it.text, it.place) == (&property.kind, &property.text, property.place)
        };
        let expected = whole.properties.iter().find(same).unwrap();
        let shown = format!("{} {:?}\n{shown}", property.text, found.incomplete);
        match &property.verdict {
            Verdict::Unknown => unknown += 1,
            Verdict::Violated(_) => {
                assert!(expected.verdict.is_violated(), "{shown}");
                violated += 1;
            }
            Verdict::Holds(_) => {
                assert!(expected.verdict.holds(), "{shown}");
                if found.incomplete.is_some() {
                    assert!(is_shown(property), "{shown}");
                }
            }
        }
    }
    (unknown, violated)
}

#[test]
fn an_exploration_that_ends_early_says_nothing_else_than_a_whole_one() {
    let seed = std::env::var("ASMOTION_NAIVE_SEED").ok();
    let seed = seed.and_then(|it| it.parse().ok());
    let mut random = Random(seed.unwrap_or(0x7a11_c47e_d000_0007));
    let (mut unknown, mut violated, mut ended, mut symbolic) = (0, 0, 0, 0);
    for round in 0..150 {
        let (text, plain) = specification(&mut random, round);
        let whole = verified(&text, &plain);
        let mut all = ways(&mut random, &plain).to_vec();
        if plain.fairness.is_empty() {
            all.push(Options {
                engine: Engine::Symbolic,
                ..plain.clone()
            });
        }
        for way in all {
            let options = Options {
                limits: limits(&mut random, &whole),
                ..way
            };
            let mut left = match random.below(3) {
                0 => random.below(12),
                _ => u64::MAX,
            };
            let found = verify(open(&text), &options, &mut |_| {
                left = left.saturating_sub(1);
                left > 0
            });
            let found = found.unwrap_or_else(|it| panic!("{}{text}", crate::refused(&it)));
            let shown = format!("{left} {options:?}\n{text}");
            let (some, wrong) = compare(&found, &whole, &shown);
            unknown += some;
            violated += wrong;
            ended += u32::from(found.incomplete.is_some());
            symbolic += u32::from(found.incomplete.is_some() && options.engine == Engine::Symbolic);
        }
    }
    assert!(
        unknown > 500 && violated > 300 && ended > 150 && symbolic > 30,
        "{unknown} {violated} {ended} {symbolic}"
    );
}
