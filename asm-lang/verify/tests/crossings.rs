//! Engines, storages, reductions and threads in random combinations: they give the verdicts of the plain exploration by a machine, with
//! shortest runs that a simulation repeats.

use crate::naive::Random;
use crate::runs::simulated;
use crate::storage::{ENOUGH, Limited};
use crate::{independent, open};
use asmotion_verify::{Engine, Options, PropertyKind, Storage, Verification, verify};

/// Number of specifications.
const ROUNDS: u32 = 400;

/// Properties about single states, and about paths.
const OF_RANDOM: ([&str; 3], [&str; 3]) = (
    ["ag(p or n < 3)", "ef(q and n = 2)", "m(1) < 2 or left"],
    ["ag(ef(m(1) = 2))", "af(q)", "g(p implies f(q or n = 1))"],
);
const OF_AGENTS: ([&str; 3], [&str; 3]) = (
    [
        "ag(common < 2)",
        "ef(place(ONE) = 2 and place(THREE) = 1)",
        "x(TWO) < 2",
    ],
    [
        "ag(ef(common = 0))",
        "af(place(ONE) = 1 or place(TWO) = 1)",
        "g(f(common != 1))",
    ],
);

/// The properties, all of which are selected if only those about single states are to be checked.
fn options(random: &mut Random, (of_states, of_paths): ([&str; 3], [&str; 3])) -> Options {
    let texts = |all: [&str; 3]| all.map(ToOwned::to_owned).to_vec();
    let is_part = random.below(2) == 0;
    let mut properties = texts(of_states);
    if !is_part {
        properties.extend(texts(of_paths));
    }
    Options {
        only: if is_part {
            properties.clone()
        } else {
            Vec::new()
        },
        properties,
        ..Options::default()
    }
}

/// A random combination.
fn combined(random: &mut Random, plain: &Options) -> Options {
    if random.below(4) == 0 {
        return Options {
            engine: Engine::Symbolic,
            ..plain.clone()
        };
    }
    let storage = match random.below(3) {
        0 => Storage::Exact,
        1 => Storage::Compact,
        _ => Limited::of(ENOUGH),
    };
    let mut flag = || random.below(2) == 0;
    let (symmetry, cone) = (flag(), flag());
    Options {
        symmetry,
        cone,
        independent: flag() && !symmetry,
        without_grounding: flag(),
        storage,
        threads: 1 + random.below(3) as usize,
        ..plain.clone()
    }
}

fn explored(text: &str, options: &Options) -> Verification {
    let found = verify(open(text), options, &mut |_| true);
    found.unwrap_or_else(|refusal| panic!("{}{text}", crate::refused(&refusal)))
}

/// Text and verdict of each property, with the length of a run that shows it, which is shortest for single states.
fn outline(found: &Verification) -> Vec<(String, bool, Option<usize>)> {
    let properties = found.properties.iter();
    let outline = properties.map(|property| {
        let is_of_states = !matches!(property.kind, PropertyKind::Ctl | PropertyKind::Ltl);
        let is_violated = property.verdict.is_violated();
        assert!(is_violated || property.verdict.holds(), "{}", property.text);
        let run = property.verdict.run().filter(|_| is_of_states);
        let length = run.map(|run| run.steps.len());
        (property.text.clone(), is_violated, length)
    });
    outline.collect()
}

/// Repeats each run; returns the number of runs. A run that ends with a fault does so in the simulation.
fn repeated(text: &str, found: &Verification) -> u32 {
    let mut count = 0;
    for property in &found.properties {
        let Some(run) = property.verdict.run() else {
            continue;
        };
        let (_, fault) = simulated(text, run);
        let is_of_the_file = property.kind == PropertyKind::Invariant && property.place.is_some();
        let fails = property.kind == PropertyKind::NoFault || is_of_the_file;
        if fails {
            assert!(fault.is_some(), "{}: {text}", property.text);
        }
        count += 1;
    }
    count
}

#[test]
fn random_combinations_have_the_verdicts_of_a_plain_exploration() {
    let mut random = Random(0x0c20_55e5_a11e_0065);
    let (mut runs, mut symbolic, mut reduced, mut compact) = (0, 0, 0, 0);
    for index in 0..ROUNDS {
        let (text, properties) = if index % 2 == 0 {
            (random.specification(), OF_RANDOM)
        } else {
            (independent::specification(&mut random), OF_AGENTS)
        };
        let text = text.replace(
            "import StandardLibrary\n",
            "import StandardLibrary\nimport CTLLibrary\nimport LTLLibrary\n",
        );
        let plain = Options {
            without_grounding: true,
            ..options(&mut random, properties)
        };
        let expected = outline(&explored(&text, &plain));
        for _ in 0..3 {
            let options = combined(&mut random, &plain);
            let found = explored(&text, &options);
            assert_eq!(outline(&found), expected, "{options:?}\n{text}");
            runs += repeated(&text, &found);
            symbolic += u32::from(options.engine == Engine::Symbolic);
            let left_out = !(found.symmetric.is_empty() && found.left_out.is_empty());
            reduced += u32::from(left_out || found.has_left_out_steps);
            compact += u32::from(found.expected_missed.is_some());
        }
    }
    // the combinations are not all plain
    assert!(
        runs > ROUNDS && symbolic > ROUNDS / 2 && reduced > ROUNDS / 20 && compact > ROUNDS / 10,
        "{runs} {symbolic} {reduced} {compact}"
    );
}
