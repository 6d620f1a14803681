//! Verdicts that could mislead are stated in words.

use crate::verified;
use asmotion_verify::{FairName, Note, Options, Verification};

const GATE: &str = "asm gate
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  enum domain Phase = {CLOSED | OPENING | OPEN}
  controlled phase: Phase
  monitored request: Boolean
definitions:
  CTLSPEC vacuous: ag(phase = OPEN and phase = CLOSED implies ax(phase = OPENING))
  LTLSPEC loose: g(phase = OPENING implies f(phase = OPEN)) or g(request)
  main rule r_Main =
    switch phase
      case CLOSED: if request then phase := OPENING endif
      case OPENING: phase := OPEN
      case OPEN: skip
    endswitch
default init s0:
  function phase = CLOSED
";

fn notes<'a>(verification: &'a Verification, name: &str) -> &'a [Note] {
    let mut properties = verification.properties.iter();
    let found = properties
        .find(|it| it.name.as_deref() == Some(name))
        .unwrap();
    assert!(found.verdict.holds(), "{found:?}");
    &found.notes
}

#[test]
fn an_implication_whose_condition_never_occurs_is_vacuous() {
    let verification = verified(GATE, &Options::default());
    let notes = notes(&verification, "vacuous");
    let unmet = |note: &Note| matches!(note, Note::Unmet(texts) if texts == &["phase = OPEN and phase = CLOSED"]);
    assert!(notes.iter().any(unmet), "{notes:?}");
}

#[test]
fn a_part_that_does_not_matter_is_named() {
    let verification = verified(GATE, &Options::default());
    let notes = notes(&verification, "loose");
    let irrelevant = |note: &Note| matches!(note, Note::Irrelevant(texts) if texts.contains(&"request".to_owned()));
    assert!(notes.iter().any(irrelevant), "{notes:?}");
}

#[test]
fn a_property_that_holds_because_no_run_is_fair_says_so() {
    let unfair = GATE.replace("  main rule", "  JUSTICE phase = OPENING\n  main rule");
    let verification = verified(&unfair, &Options::default());
    let notes = notes(&verification, "loose");
    let none = |note: &Note| matches!(note, Note::Unfair { all: true });
    assert!(notes.iter().any(none), "{notes:?}");
}

#[test]
fn fairness_that_some_run_satisfies_is_no_reason_for_a_note() {
    let options = Options {
        fairness: vec![FairName {
            name: "r_Main".to_owned(),
            is_strong: true,
        }],
        ..Options::default()
    };
    let verification = verified(GATE, &options);
    let unfair = |note: &Note| matches!(note, Note::Unfair { .. });
    assert!(!notes(&verification, "loose").iter().any(unfair));
}

#[test]
fn assumptions_that_cut_the_graph_are_counted() {
    let options = Options {
        assumptions: vec!["phase != OPEN".to_owned()],
        ..Options::default()
    };
    let verification = verified(GATE, &options);
    assert!(verification.excluded > 0);
    assert_eq!(verification.assumptions, ["phase != OPEN"]);
}

#[test]
fn states_without_a_successor_are_counted_if_a_property_is_about_paths() {
    let text = "asm fragile
import StandardLibrary
import CTLLibrary
signature:
  domain Load subsetof Integer
  monitored heavy: Boolean
  controlled load: Load
  controlled isBroken: Boolean
definitions:
  domain Load = {0:2}
  CTLSPEC ends: af(load = 2)
  main rule r_Main =
    if heavy then load := load + 1 else if load = 2 then load := load + 1 endif endif
default init s0:
  function load = 0
  function isBroken = false
";
    // in the last state every step fails, and the only run there stays in it
    let verification = verified(text, &Options::default());
    assert_eq!((verification.states, verification.ends), (3, 1));
    let invariants = text.replace("CTLSPEC ends: af(load = 2)", "CTLSPEC ends: ag(load < 3)");
    assert_eq!(verified(&invariants, &Options::default()).ends, 0);
    let continues = text.replace("load := load + 1 else if", "load := 1 else if");
    assert_eq!(verified(&continues, &Options::default()).ends, 0);
}

#[test]
fn the_symbolic_engine_names_parts_that_do_not_matter() {
    let options = Options {
        engine: asmotion_verify::Engine::Symbolic,
        ..Options::default()
    };
    let verification = verified(GATE, &options);
    let notes = notes(&verification, "loose");
    let irrelevant = |note: &Note| matches!(note, Note::Irrelevant(texts) if texts.contains(&"request".to_owned()));
    assert!(notes.iter().any(irrelevant), "{notes:?}");
}
