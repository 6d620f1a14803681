//! The cone of influence, compared with the exploration of all locations.

use crate::naive::Random;
use crate::runs::simulated;
use crate::{open, verified};
use asmotion_verify::{Options, Verdict, verify};

/// Options for one property, which is possible or else always true.
fn options(term: &str, is_possible: bool, cone: bool) -> Options {
    let terms = vec![term.to_owned()];
    let (properties, possible) = if is_possible {
        (Vec::new(), terms.clone())
    } else {
        (terms.clone(), Vec::new())
    };
    Options {
        properties,
        possible,
        only: terms,
        cone,
        ..Options::default()
    }
}

#[test]
fn random_specifications_have_equal_verdicts_and_runs_that_replay() {
    let mut random = Random(0xc0de_0f1f_1c0f_feed);
    let (mut left_out, mut fewer, mut violated, mut held) = (0, 0, 0, 0);
    for index in 0..300 {
        // two parts that have little to do with each other
        let (one, other) = (random.specification(), random.specification());
        let parts = |text: &str| {
            let (head, rest) = text.split_once("main rule r_Main = ").unwrap();
            let (rule, init) = rest.split_once("default init").unwrap();
            [head, rule, init].map(ToOwned::to_owned)
        };
        let [head, rule, init] = parts(&one);
        let [_, other, _] = parts(&other);
        let renamed = other
            .replace("p :=", "p2 :=")
            .replace("q :=", "q2 :=")
            .replace("n :=", "n2 :=");
        let text = format!(
            "{head}rule r_Other = {renamed}  rule r_One = {rule}  main rule r_Main = par r_Other[] r_One[] endpar\ndefault init{init}"
        );
        let text = text.replace(
            "definitions:\n",
            "  controlled p2: Boolean\n  controlled q2: Boolean\n  controlled n2: Number\ndefinitions:\n",
        );
        let text =
            format!("{text}  function p2 = false\n  function q2 = false\n  function n2 = 0\n");
        let term = match index % 4 {
            0 => "not (p and q)",
            1 => "n < 3 or left",
            2 => "m(1) < 2",
            _ => "n2 = 0 or p2",
        };
        for is_possible in [false, true] {
            let all = verify(open(&text), &options(term, is_possible, false), &mut |_| {
                true
            });
            let part = verify(open(&text), &options(term, is_possible, true), &mut |_| {
                true
            });
            let (Ok(all), Ok(part)) = (all, part) else {
                panic!("{text}");
            };
            let (one, other) = (&all.properties[0].verdict, &part.properties[0].verdict);
            assert_eq!(
                (one.holds(), one.is_violated(), one.run().is_some()),
                (other.holds(), other.is_violated(), other.run().is_some()),
                "{term} {is_possible}: {text}"
            );
            assert!(part.states <= all.states, "{text}");
            if let Verdict::Violated(Some(run)) | Verdict::Holds(Some(run)) = other {
                // the locations of the specification, not of a part
                assert!(part.left_out.is_empty());
                assert_eq!(run.steps.len(), one.run().unwrap().steps.len());
                assert!(simulated(&text, run).1.is_none(), "{text}");
                violated += 1;
            } else {
                left_out += u32::from(!part.left_out.is_empty());
                fewer += u32::from(part.states < all.states);
                held += 1;
            }
        }
    }
    assert!(
        left_out > 60 && fewer > 30 && violated > 60 && held > 60,
        "{left_out} {fewer} {violated} {held}"
    );
}

#[test]
fn locations_that_do_not_matter_are_left_out() {
    let text = "asm model
import StandardLibrary
import CTLLibrary
signature:
  domain Number subsetof Integer
  monitored push: Boolean
  controlled a: Number
  controlled b: Number
  controlled c: Number
definitions:
  domain Number = {0 : 9}
  invariant inv_a over a: a < 8
  main rule r_Main = par
    if push then a := (a + 1) mod 8 endif
    if a = 3 then b := (b + 1) mod 10 endif
    c := (c + b) mod 10
  endpar
default init s0:
  function a = 0
  function b = 0
  function c = 0
";
    let of = |names: &[&str], cone| Options {
        only: names.iter().map(|it| (*it).to_owned()).collect(),
        cone,
        ..Options::default()
    };
    let all = verified(text, &of(&["inv_a"], false));
    let part = verified(text, &of(&["inv_a"], true));
    assert_eq!((all.states, part.states), (800, 8));
    assert_eq!(part.left_out, ["b", "c"]);
    assert!(part.properties[0].verdict.holds());
    // what is about all locations is not proved by a part
    let general = verified(text, &of(&[], true));
    assert_eq!((general.states, general.left_out.len()), (800, 0));
    let about_c = Options {
        properties: vec!["c < 9".to_owned()],
        ..of(&["c < 9"], true)
    };
    let found = verified(text, &about_c);
    assert_eq!((found.states, found.left_out.len()), (800, 0));
    assert!(found.properties[0].verdict.is_violated());
}
