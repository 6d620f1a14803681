//! Steps that do not influence each other in one order, compared with the exploration of all orders.

use crate::naive::Random;
use crate::verified;
use asmotion_verify::{Options, Verdict, Verification};

/// A step of an agent from one of its places: a guard and an update that concern the agent, another one, or what all share.
fn step(random: &mut Random, from: usize) -> String {
    let other = random.one_of(&["ONE", "TWO", "THREE"]);
    let number = random.below(3);
    let guard = match random.below(6) {
        0 => format!("x($a) = {number}"),
        1 => format!("common = {number}"),
        2 => format!("x({other}) != {number}"),
        3 => format!("place({other}) < 2"),
        _ => "true".to_owned(),
    };
    let update = match random.below(9) {
        0 => format!("common := {number}"),
        1 => format!("x({other}) := {number}"),
        2 => "common := (common + 1) mod 3".to_owned(),
        // outside of its domain at last
        3 if random.below(4) == 0 => "x($a) := x($a) + 1".to_owned(),
        3 | 4 => "skip".to_owned(),
        _ => "x($a) := (x($a) + 1) mod 3".to_owned(),
    };
    let to = match random.below(4) {
        0 => random.below(4) as usize,
        _ => (from + 1) % 4,
    };
    format!("if {guard} then par place($a) := {to} {update} endpar endif")
}

pub fn specification(random: &mut Random) -> String {
    let steps: Vec<String> = (0..3).map(|from| step(random, from)).collect();
    let last = match random.below(3) {
        0 => "place($a) := 0".to_owned(),
        _ => "skip".to_owned(),
    };
    let property = random.one_of(&[
        "common: common < 2",
        "place: not (place(ONE) = 2 and place(TWO) = 2)",
        "x: x(THREE) < 2",
        "x, common: x(ONE) = 2 implies common < 2",
        "common: common >= 0",
    ]);
    format!(
        "asm model
import StandardLibrary
signature:
  enum domain Agents = {{ONE | TWO | THREE}}
  domain Place subsetof Integer
  domain Number subsetof Integer
  controlled place: Agents -> Place
  controlled x: Agents -> Number
  controlled common: Number
definitions:
  domain Place = {{0 : 3}}
  domain Number = {{0 : 2}}
  invariant inv over {property}
  main rule r_Main = choose $a in Agents with true do
    switch place($a) case 0 : {} case 1 : {} case 2 : {} otherwise {last} endswitch
default init s0:
  function place($a in Agents) = 0
  function x($a in Agents) = 0
  function common = 0
",
        steps[0], steps[1], steps[2]
    )
}

/// Checks all properties, or only the invariant `inv`.
fn explored(text: &str, independent: bool, is_alone: bool) -> Verification {
    let options = Options {
        independent,
        only: is_alone.then(|| "inv".to_owned()).into_iter().collect(),
        ..Options::default()
    };
    verified(text, &options)
}

fn verdicts(verification: &Verification) -> Vec<(String, bool, bool)> {
    let properties = verification.properties.iter();
    let verdict = |it: &Verdict| (it.holds(), it.is_violated());
    properties
        .map(|it| {
            let (holds, violated) = verdict(&it.verdict);
            (it.text.clone(), holds, violated)
        })
        .collect()
}

/// The verdicts are equal, also those about failing steps, stuck states and rules that never run, and so are the runs.
#[test]
fn random_specifications_have_equal_verdicts() {
    let mut random = Random(0x1de0_ede2_0a6e_2715);
    let (mut fewer, mut held, mut violated) = (0, 0, 0);
    for index in 0..600 {
        let (text, is_alone) = (specification(&mut random), index % 2 == 0);
        let all = explored(&text, false, is_alone);
        let some = explored(&text, true, is_alone);
        assert!(!all.has_left_out_steps);
        assert_eq!(verdicts(&all), verdicts(&some), "{text}");
        assert!(some.states <= all.states, "{text}");
        if some.has_left_out_steps {
            fewer += u32::from(some.states < all.states);
            held += 1;
        } else {
            // runs are those of the exploration of all steps
            assert_eq!(all.states, some.states, "{text}");
            violated += u32::from(all.properties.iter().any(|it| it.verdict.is_violated()));
        }
    }
    assert!(
        fewer > 20 && held > 40 && violated > 80,
        "{fewer} {held} {violated}"
    );
}

const COUNTERS: &str = "asm counters
import StandardLibrary
signature:
  enum domain Agents = {A1 | A2 | A3 | A4 | A5}
  domain Number subsetof Integer
  controlled n: Agents -> Number
  controlled rang: Boolean
definitions:
  domain Number = {0 : 4}
  invariant inv over rang: rang or not rang
  main rule r_Main = choose $a in Agents with n($a) < 4 do
    par
      n($a) := n($a) + 1
      if $a = A5 and n($a) = 3 then rang := true endif
    endpar
default init s0:
  function n($a in Agents) = 0
  function rang = false
";

/// Agents that only count for themselves: one order of their steps.
#[test]
fn agents_that_do_not_influence_each_other_are_explored_one_after_the_other() {
    let all = explored(COUNTERS, false, true);
    let some = explored(COUNTERS, true, true);
    assert_eq!(verdicts(&all), verdicts(&some));
    assert_eq!(all.states, 3125);
    assert!(some.has_left_out_steps);
    assert!(some.states < 60, "{}", some.states);
    // all but the last one are stuck only after the last step, which is found
    let stuck = explored(COUNTERS, true, false);
    assert_eq!(
        verdicts(&stuck),
        verdicts(&explored(COUNTERS, false, false))
    );
}

/// A step that a condition sees is not put off.
#[test]
fn a_property_sees_states_between_independent_steps() {
    let seen = COUNTERS.replace(
        "invariant inv over rang: rang or not rang",
        "invariant inv over n: not (n(A1) = 4 and n(A2) = 0) or n(A3) = 0",
    );
    for text in [seen.clone(), seen.replace("or n(A3) = 0", "or n(A3) < 5")] {
        let (all, some) = (explored(&text, false, true), explored(&text, true, true));
        assert_eq!(verdicts(&all), verdicts(&some));
    }
}

/// With a temporal property, all transitions matter.
#[test]
fn nothing_is_left_out_for_properties_about_paths() {
    let text = COUNTERS
        .replace("  main rule", "  CTLSPEC ag(ef(n(A1) = 4))\n  main rule")
        .replace(
            "import StandardLibrary\n",
            "import StandardLibrary\nimport CTLLibrary\n",
        );
    let found = explored(&text, true, false);
    assert!(!found.has_left_out_steps);
    assert_eq!(found.states, 3125);
}
