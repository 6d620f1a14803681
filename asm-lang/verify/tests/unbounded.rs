//! Data without a bound: interned values, growing locations, and elements created by `extend`.

use crate::{verdict_of, verified};
use asmotion_verify::{Incomplete, Limits, Options};

fn limited(states: Option<u64>, reserve: Option<usize>) -> Options {
    Options {
        limits: Limits {
            states,
            reserve,
            ..Limits::default()
        },
        ..Options::default()
    }
}

#[test]
fn values_of_every_kind_are_part_of_the_state() {
    let verification = verified(
        "asm values
import StandardLibrary
signature:
  monitored next: Boolean
  controlled numbers: Seq(Integer)
  controlled names: Powerset(String)
  controlled table: Map(Integer, String)
  controlled ratio: Real
  controlled pair: Prod(Integer, Boolean)
  controlled far: Integer -> Integer
definitions:
  invariant small over numbers: length(numbers) < 3
  main rule r_Main =
    if next and length(numbers) < 2 then par
      numbers := append(numbers, length(numbers))
      names := including(names, \"a\")
      table := {1 -> \"one\"}
      ratio := ratio / 2.0
      pair := (1000000, not second(pair))
      far(123456789) := length(numbers)
    endpar endif
default init s0:
  function numbers = []
  function names = {}
  function ratio = 1.0
  function pair = (0, false)
",
        &Options::default(),
    );
    assert_eq!(verification.states, 3);
    assert_eq!(verdict_of(&verification, "small"), "holds");
    assert_eq!(verification.incomplete, None);
    assert!(verification.growing.is_empty());
}

#[test]
fn a_counter_without_a_bound_is_named() {
    let text = "asm counter
import StandardLibrary
signature:
  monitored up: Boolean
  controlled total: Integer
  controlled height: Real
  controlled isUp: Boolean
  controlled parity: Integer
definitions:
  invariant positive over total: total >= 0
  main rule r_Main = par
    isUp := up
    if up then par total := total + 1 height := height / 2.0 parity := (parity + 1) mod 2 endpar endif
  endpar
default init s0:
  function total = 0
  function height = 1.0
  function parity = 0
  function isUp = false
";
    let verification = verified(text, &limited(Some(1000), None));
    assert_eq!(verification.incomplete, Some(Incomplete::States));
    assert_eq!(verdict_of(&verification, "positive"), "unknown");
    let growing = verification.growing.iter();
    let growing: Vec<&str> = growing.map(|it| it.location.as_str()).collect();
    assert_eq!(growing, ["total", "height"]);
    let total = &verification.growing[0];
    assert_eq!(total.values, ["0", "1", "2"]);
    let sources = &verification.machines[0].specification.sources;
    assert_eq!(sources.position(total.place.file, total.place.start).0, 5);
    // a bound alone is no growth
    let short = verified(text, &limited(Some(10), None));
    assert!(short.growing.is_empty());
}

#[test]
fn elements_come_from_a_bounded_reserve() {
    let text = "asm parts
import StandardLibrary
import CTLLibrary
signature:
  dynamic abstract domain Part
  monitored more: Boolean
  controlled isBroken: Part -> Boolean
  controlled last: Part
definitions:
  invariant few over isBroken: (forall $p in Part with isUndef(isBroken($p)) or not isBroken($p))
  CTLSPEC none: ag(isUndef(last))
  main rule r_Main =
    if more then extend Part with $p do par isBroken($p) := false last := $p endpar endif
";
    for reserve in [0, 1, 4] {
        let verification = verified(text, &limited(None, Some(reserve)));
        assert_eq!(verification.states, reserve as u64 + 1);
        assert_eq!(verification.incomplete, Some(Incomplete::Reserve));
        assert_eq!(verdict_of(&verification, "few"), "unknown");
        let expected = if reserve == 0 { "unknown" } else { "violated" };
        assert_eq!(verdict_of(&verification, "none"), expected);
        assert_eq!(verdict_of(&verification, "no state is stuck"), "unknown");
    }
    let bounded = text.replace("if more then", "if more and isUndef(last) then");
    let verification = verified(&bounded, &limited(None, Some(1)));
    assert_eq!((verification.states, verification.incomplete), (2, None));
    assert_eq!(verdict_of(&verification, "few"), "holds");
}

/// A timer, with the rule that advances it.
fn timer(rule: &str) -> String {
    format!(
        "asm timer
import StandardLibrary
signature:
  monitored runs: Boolean
  controlled time: Real
  controlled late: Boolean
definitions:
  invariant small over late: not (late and time > 3.0)
  rule r_advance = time := time + 0.5
  rule r_set($x in Real) = $x := 0.0
  main rule r_Main = {rule}
default init s0:
  function time = 0.0
  function late = false
"
    )
}

/// The codes of the findings that refuse a specification.
fn refusal(text: &str, options: &Options) -> Vec<&'static str> {
    match asmotion_verify::verify(crate::open(text), options, &mut |_| true) {
        Ok(_) => Vec::new(),
        Err(refusal) => {
            let findings = refusal.report.diagnostics.iter();
            findings.map(|it| it.code.name).collect()
        }
    }
}

#[test]
fn a_real_that_grows_in_every_step_is_refused_at_once() {
    let grows = [
        "r_advance[]",
        "par late := runs r_advance[] endpar",
        "seq r_advance[] late := time > 1.0 endseq",
        "let ($x = 1.0) in r_advance[] endlet",
    ];
    for rule in grows {
        // without the rule whose parameter it might be
        let text = timer(rule).replace("  rule r_set($x in Real) = $x := 0.0\n", "");
        assert_eq!(refusal(&text, &Options::default()), ["M014"], "{rule}");
        // limits, assumptions
        for options in [
            limited(Some(20), None),
            Options {
                assumptions: vec!["time < 2.0".to_owned()],
                ..Options::default()
            },
        ] {
            assert_eq!(refusal(&text, &options), [""; 0], "{rule}");
        }
    }
    let ends = [
        "if time < 4.0 then r_advance[] endif",
        "par if time >= 4.0 then time := 0.0 else r_advance[] endif endpar",
        "seq r_advance[] time := 1.0 endseq",
        "time := time + 0.0",
        "time := if time > 2.0 then 0.0 else time + 0.5 endif",
    ];
    for rule in ends {
        assert_eq!(
            refusal(&timer(rule), &Options::default()),
            [""; 0],
            "{rule}"
        );
    }
}
