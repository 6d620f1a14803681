//! Among the shortest runs, the one with the fewest switches, changes and the smallest values.

use crate::verified;
use asmotion_verify::{Options, Run, Verification};

/// Two agents each have to count to 2; each step reads an input that both need to be true.
const COUNTERS: &str = "asm counters
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  domain Agent2 subsetof Integer
  domain Level subsetof Integer
  controlled count: Agent2 -> Level
  monitored mode: Level
  controlled last: Level
definitions:
  domain Agent2 = {1 : 2}
  domain Level = {0 : 3}
  rule r_count($a in Agent2, $m in Level) =
    if count($a) < 2 and $m > 0 then count($a) := count($a) + 1 endif
  invariant inv_both over count: not (count(1) = 2 and count(2) = 2)
  CTLSPEC never: ag(not (count(1) = 2 and count(2) = 2))
  CTLSPEC rests: ag(count(1) = 2 implies ef(count(2) = 0))
  LTLSPEC lasts: f(count(1) = 2)
  main rule r_Main =
    choose $a in Agent2 with true do
      par
        r_count[$a, mode]
        last := if count($a) = 1 then 3 else mode endif
      endpar
default init s0:
  function count($a in Agent2) = 0
  function last = 0
";

fn run_of(verification: &Verification, name: &str) -> Run {
    let mut properties = verification.properties.iter();
    let found = properties.find(|it| it.name.as_deref() == Some(name));
    found.unwrap().verdict.run().unwrap().clone()
}

fn agents(run: &Run) -> Vec<&str> {
    run.steps
        .iter()
        .map(|step| &*step.choices[0].values[0].1)
        .collect()
}

fn inputs(run: &Run) -> Vec<&str> {
    run.steps.iter().map(|step| &*step.inputs[0].1).collect()
}

#[test]
fn a_run_switches_agents_and_changes_inputs_as_rarely_as_possible() {
    let verification = verified(COUNTERS, &Options::default());
    for name in ["inv_both", "never"] {
        let run = run_of(&verification, name);
        assert_eq!(agents(&run), ["1", "1", "2", "2"], "{name}");
        assert_eq!(inputs(&run), ["1", "1", "1", "1"], "{name}");
    }
}

#[test]
fn the_steps_of_a_cycle_are_simple_too() {
    let verification = verified(COUNTERS, &Options::default());
    let run = run_of(&verification, "lasts");
    assert_eq!(run.cycle, Some(0));
    assert_eq!(agents(&run).len(), 1);
    assert_eq!(inputs(&run), ["0"]);
}

#[test]
fn choices_and_guards_have_their_values() {
    let verification = verified(COUNTERS, &Options::default());
    let run = run_of(&verification, "inv_both");
    let step = &run.steps[1];
    assert_eq!(step.choices[0].values, [("$a".to_owned(), "1".to_owned())]);
    let update = &step.updates[0];
    assert_eq!(update.location, "count(1)");
    let [guard] = update.guards.as_slice() else {
        panic!("{update:?}");
    };
    assert_eq!(guard.text, "count($a) < 2 and $m > 0");
    assert!(guard.holds);
    assert!(
        guard
            .values
            .contains(&("count($a)".to_owned(), "1".to_owned())),
        "{guard:?}"
    );
}

#[test]
fn a_cycle_that_is_shown_violates_the_property() {
    // a run through both branches: the cycle has to avoid `served`, although a shorter one would not
    let text = "asm server
import StandardLibrary
import LTLLibrary
signature:
  enum domain Phase = {IDLE | ASKED | WORKING | SERVED}
  monitored isUrgent: Boolean
  controlled phase: Phase
definitions:
  LTLSPEC served: g(phase = ASKED implies f(phase = SERVED))
  main rule r_Main =
    switch phase
      case IDLE: phase := ASKED
      case ASKED: phase := if isUrgent then SERVED else WORKING endif
      case WORKING: phase := if isUrgent then SERVED else ASKED endif
      case SERVED: phase := IDLE
    endswitch
default init s0:
  function phase = IDLE
";
    let verification = verified(text, &Options::default());
    let run = run_of(&verification, "served");
    assert_eq!(run.cycle, Some(1));
    assert_eq!(run.steps.len(), 3);
    assert_eq!(run.steps[2].updates[0].guards[0].text, "phase = WORKING");
}
