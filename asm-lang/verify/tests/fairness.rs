//! Fairness of agents and rules.

use crate::{open, verdicts, verified};
use asmotion_verify::{FairName, Options, verify};

/// Two agents count up to 1 independently; a third rule can only move in every second step.
const WORKERS: &str = "asm workers
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  domain Worker subsetof Integer
  controlled done: Worker -> Boolean
  controlled turn: Boolean
  controlled ended: Boolean
definitions:
  domain Worker = {1 : 2}
  rule r_end = ended := true
  CTLSPEC all_work: (forall $w in Worker with af(done($w)))
  LTLSPEC ends: f(ended)
  main rule r_Main =
    choose $w in Worker with true do
      choose $e in {false, true} with true do
        par
          turn := not turn
          if $w = 1 and not done(1) then done(1) := true endif
          if $w = 2 and not done(2) then done(2) := true endif
          if $e and turn then r_end[] endif
        endpar
default init s0:
  function done($w in Worker) = false
  function turn = false
  function ended = false
";

fn with(names: &[(&str, bool)]) -> Options {
    let fairness = names.iter().map(|(name, is_strong)| FairName {
        name: (*name).to_owned(),
        is_strong: *is_strong,
    });
    Options {
        fairness: fairness.collect(),
        ..Options::default()
    }
}

fn verdict_of(text: &str, options: &Options, name: &str) -> &'static str {
    let verification = verified(text, options);
    let all = verdicts(&verification);
    all.into_iter().find(|(it, _)| it == name).unwrap().1
}

#[test]
fn agents_that_are_never_chosen_violate_a_property_unless_they_are_fair() {
    assert_eq!(
        verdict_of(WORKERS, &Options::default(), "all_work"),
        "violated"
    );
    assert_eq!(
        verdict_of(WORKERS, &with(&[("Worker", false)]), "all_work"),
        "holds"
    );
    assert_eq!(
        verdict_of(WORKERS, &with(&[("Worker", true)]), "all_work"),
        "holds"
    );
    // fairness of something else does not help
    assert_eq!(
        verdict_of(WORKERS, &with(&[("r_end", true)]), "all_work"),
        "violated"
    );
}

#[test]
fn a_rule_that_can_move_only_now_and_then_needs_strong_fairness() {
    assert_eq!(verdict_of(WORKERS, &Options::default(), "ends"), "violated");
    assert_eq!(
        verdict_of(WORKERS, &with(&[("r_end", false)]), "ends"),
        "violated"
    );
    assert_eq!(
        verdict_of(WORKERS, &with(&[("r_end", true)]), "ends"),
        "holds"
    );
}

#[test]
fn comments_of_the_file_are_read() {
    let annotated = WORKERS.replace(
        "signature:",
        "//@Fair Worker\n//@StronglyFair r_end\nsignature:",
    );
    let verification = verified(&annotated, &Options::default());
    for name in ["all_work", "ends"] {
        assert_eq!(verdict_of(&annotated, &Options::default(), name), "holds");
    }
    assert_eq!(
        verification.assumptions,
        ["weak fairness of Worker", "strong fairness of r_end"]
    );
}

#[test]
fn a_violation_under_fairness_shows_a_fair_run() {
    let verification = verified(WORKERS, &with(&[("Worker", false)]));
    let ends = verification.properties.iter();
    let ends = ends.clone().find(|it| it.name.as_deref() == Some("ends"));
    let run = ends.unwrap().verdict.run().unwrap();
    let cycle = run.cycle.unwrap();
    let chosen: std::collections::BTreeSet<&str> = run.steps[cycle..]
        .iter()
        .map(|step| &*step.choices[0].values[0].1)
        .collect();
    assert_eq!(chosen.len(), 2, "both workers move in the cycle: {run:?}");
}

#[test]
fn unknown_names_are_refused() {
    for name in ["r_ennd", "r_unused", "Integer", "Boolean"] {
        let text = WORKERS.replace("  rule r_end", "  rule r_unused = skip\n  rule r_end");
        let refusal = verify(open(&text), &with(&[(name, false)]), &mut |_| true);
        let refusal = refusal.err().unwrap();
        assert_eq!(refusal.report.diagnostics[0].code.name, "M020", "{name}");
    }
}
