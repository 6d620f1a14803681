//! Advice and mutants.

use crate::models::LAMP;
use crate::naive::Random;
use crate::{open, verified};
use asmotion_verify::{AdviceKind, Options, mutants, verify};

const ODD: &str = "asm odd
import StandardLibrary
signature:
  enum domain Mode = {IDLE | BUSY | BROKEN}
  domain Count subsetof Integer
  controlled mode: Mode
  controlled count: Count
  monitored start: Boolean
  monitored unused: Boolean
definitions:
  domain Count = {0 : 3}
  main rule r_Main =
    par
      if start and mode = IDLE then mode := BUSY endif
      if mode = BROKEN then mode := IDLE endif
      if count < 3 then count := 0 endif
    endpar
default init s0:
  function mode = IDLE
  function count = 0
";

#[test]
fn advice_names_what_never_happens() {
    let options = Options {
        advice: true,
        ..Options::default()
    };
    let verification = verified(ODD, &options);
    let advice = verification.advice.iter().map(|it| (it.kind, &*it.text));
    assert_eq!(
        advice.collect::<Vec<_>>(),
        [
            (AdviceKind::UnusedValue, "`mode` is never BROKEN"),
            (AdviceKind::UnusedValue, "`count` is never 1, 2, 3"),
            (AdviceKind::UnreadInput, "no step reads `unused`"),
            (AdviceKind::UnreachedBranch, "`mode = BROKEN` is never true"),
            (AdviceKind::UnreachedBranch, "`count < 3` is always true"),
            (
                AdviceKind::TrivialUpdate,
                "`count := 0` never changes anything"
            ),
        ]
    );
    assert!(verification.has_advice_on_steps);
    assert!(verified(LAMP, &options).advice.is_empty());
    // none without all states
    let mut incomplete = options.clone();
    incomplete.limits.depth = Some(0);
    assert!(verified(ODD, &incomplete).advice.is_empty());
}

/// Verifies with advice, in grounded form or by a machine; returns what is listed.
fn advised(text: &str, without_grounding: bool) -> (bool, Vec<String>) {
    let options = Options {
        advice: true,
        without_grounding,
        ..Options::default()
    };
    let found = verified(text, &options);
    let advice = found.advice.iter();
    let advice = advice.map(|it| format!("{:?} {:?} {}", it.place, it.kind, it.text));
    (found.is_grounded, advice.collect())
}

#[test]
fn grounded_steps_give_the_same_advice() {
    let mut random = Random(0xad71_ce5e_ed00_0017);
    let (mut grounded, mut lines) = (0, 0);
    for _ in 0..200 {
        let text = random.specification();
        let (is_grounded, advice) = advised(&text, false);
        let (is_machine, expected) = advised(&text, true);
        assert!(!is_machine);
        assert_eq!(advice, expected, "{text}");
        grounded += usize::from(is_grounded);
        lines += expected.len();
    }
    assert!(grounded > 100 && lines > 200, "{grounded} {lines}");
    let mut compared = 0;
    for folder in ["allocation", "estop", "navigation", "patrol", "recovery"] {
        let file = if folder == "navigation" {
            "navigate"
        } else {
            folder
        };
        let path = format!("../../specs/{folder}/{file}.asm");
        let specification = |without_grounding| {
            let text = std::fs::read_to_string(&path).unwrap();
            // dead branches, values and updates besides those that the file has
            let dead = text.replacen(" then", " and 1 > 2 then", 1);
            [text, dead].map(|text| advised(&text, without_grounding))
        };
        let (found, expected) = (specification(false), specification(true));
        for ((is_grounded, found), (_, expected)) in found.into_iter().zip(expected) {
            assert_eq!(found, expected, "{path}");
            compared += usize::from(is_grounded);
        }
    }
    assert!(compared >= 6, "{compared}");
}

#[test]
fn advice_names_properties_about_nothing_that_is_reached() {
    let text = ODD.replace(
        "  main rule",
        "  CTLSPEC recovers: ag(mode = BROKEN implies af(mode = IDLE))
  CTLSPEC starts: ag(mode = IDLE implies ex(mode = BUSY))
  invariant counts over mode, count: mode = BROKEN and count = 0 implies mode = IDLE
  main rule",
    );
    let text = text.replace(
        "import StandardLibrary",
        "import StandardLibrary\nimport CTLLibrary",
    );
    let options = Options {
        advice: true,
        ..Options::default()
    };
    let verification = verified(&text, &options);
    let advice = verification.advice.iter();
    let advice = advice.filter(|it| it.kind == AdviceKind::UnreachedCondition);
    assert_eq!(
        advice.map(|it| &*it.text).collect::<Vec<_>>(),
        [
            "`recovers` is about no reachable state: `mode = BROKEN` is never true",
            "`counts` is about no reachable state: `mode = BROKEN and count = 0` is never true",
        ]
    );
}

#[test]
fn mutants_have_one_change_each() {
    let specification = open(ODD);
    let all = mutants(&specification);
    let changes: Vec<&str> = all.iter().map(|it| &*it.change).collect();
    for change in [
        "`mode := BUSY` becomes `skip`",
        "`BUSY` becomes `BROKEN`",
        "`start and mode = IDLE` becomes `not (start and mode = IDLE)`",
        "`start and mode = IDLE` becomes `start`",
        "`start and mode = IDLE` becomes `mode = IDLE`",
        "`mode = IDLE` becomes `mode != IDLE`",
        "`count < 3` becomes `count <= 3`",
        "`0` becomes `1`",
    ] {
        assert!(
            changes.contains(&change),
            "{change} is missing: {changes:#?}"
        );
    }
    assert_eq!(all, mutants(&open(ODD)));
    // each is a specification that differs from the others
    let texts = all.iter().map(|it| it.applied_to(ODD).unwrap());
    let texts: std::collections::BTreeSet<String> = texts.collect();
    assert_eq!(texts.len(), all.len());
    for text in &texts {
        let verified = verify(open(text), &Options::default(), &mut |_| true);
        assert!(verified.is_ok(), "{text}");
    }
}

#[test]
fn an_invariant_kills_mutants() {
    let text = ODD.replace(
        "  main rule",
        "  invariant inv_zero over count: count = 0\n  main rule",
    );
    let mutant = mutants(&open(&text));
    let mutant = mutant
        .iter()
        .find(|it| it.change == "`0` becomes `1`")
        .unwrap();
    let verification = verified(&mutant.applied_to(&text).unwrap(), &Options::default());
    let invariant = verification.properties.iter();
    let mut invariant = invariant.filter(|it| it.name.as_deref() == Some("inv_zero"));
    assert!(invariant.next().unwrap().verdict.is_violated());
}
