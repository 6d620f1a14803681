//! Symmetry, compared with the exploration of all states.

use crate::naive::Random;
use crate::runs::simulated;
use crate::verified;
use asmotion_verify::{
    CheckedProperty, Limits, Options, PropertyKind, Storage, Verdict, Verification,
};

/// Draws specifications of agents that are used alike, apart from an occasional literal.
struct Agents<'a> {
    random: &'a mut Random,
    /// `true` for a relation between agents.
    has_pairs: bool,
    /// `true` for literals that tell agents apart.
    has_literals: bool,
}

impl Agents<'_> {
    fn condition(&mut self, depth: u32, agent: &str) -> String {
        let number = self.random.below(3);
        match self.random.below(if depth == 0 { 5 } else { 10 }) {
            0 => format!("f({agent}) = {number}"),
            1 => format!("g({agent})"),
            2 => format!("n = {number}"),
            3 if self.has_literals => format!("f(ONE) = {number}"),
            3 => format!("f({agent}) < 2"),
            4 if self.has_pairs => format!("e({agent}, {agent})"),
            4 => format!("(exists $x in Worker with f($x) = {number})"),
            5 => format!("(forall $x in Worker with g($x) or $x = {agent})"),
            6 => format!("not ({})", self.condition(depth - 1, agent)),
            7 if self.has_pairs => format!("(exists $y in Worker with e({agent}, $y))"),
            7 | 8 => format!(
                "({} and {})",
                self.condition(depth - 1, agent),
                self.condition(depth - 1, agent)
            ),
            _ => format!(
                "({} or {})",
                self.condition(depth - 1, agent),
                self.condition(depth - 1, agent)
            ),
        }
    }

    fn rule(&mut self, depth: u32, agent: &str) -> String {
        match self.random.below(if depth == 0 { 5 } else { 10 }) {
            0 => format!("f({agent}) := (f({agent}) + 1) mod 3"),
            1 => format!("g({agent}) := not g({agent})"),
            2 => format!(
                "n := {}",
                self.random.one_of(&["(n + 1) mod 4", "0", "n + 1"])
            ),
            3 if self.has_literals => "g(TWO) := true".to_owned(),
            3 => format!("g({agent}) := {}", self.condition(0, agent)),
            4 if self.has_pairs => format!("e({agent}, {agent}) := g({agent})"),
            4 => "skip".to_owned(),
            5 => format!(
                "par {} {} endpar",
                self.rule(depth - 1, agent),
                self.rule(depth - 1, agent)
            ),
            6 => format!(
                "if {} then {} endif",
                self.condition(1, agent),
                self.rule(depth - 1, agent)
            ),
            7 => format!(
                "forall $z in Worker with {} do g($z) := false",
                self.condition(1, "$z")
            ),
            8 if self.has_pairs => format!(
                "choose $b in Worker with $b != {agent} do e({agent}, $b) := {}",
                self.condition(0, "$b")
            ),
            _ => format!(
                "choose $c{depth} in Worker with {} do {} ifnone {}",
                self.condition(1, &format!("$c{depth}")),
                self.rule(depth - 1, &format!("$c{depth}")),
                self.rule(depth - 1, agent)
            ),
        }
    }

    fn specification(&mut self) -> String {
        let count = 3;
        let domain = "enum domain Worker = {ONE | TWO | THREE}";
        let rules: Vec<String> = (0..count).map(|_| self.rule(2, "$a")).collect();
        let guards: Vec<String> = (0..count).map(|_| self.condition(1, "$a")).collect();
        let acts = rules.iter().zip(&guards);
        let acts = acts.map(|(rule, guard)| format!("if {guard} then {rule} endif"));
        let acts: Vec<String> = acts.collect();
        format!(
            "asm model
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  {domain}
  domain Level subsetof Integer
  domain Number subsetof Integer
  domain Act subsetof Integer
  controlled f: Worker -> Level
  controlled g: Worker -> Boolean
  controlled e: Prod(Worker, Worker) -> Boolean
  controlled n: Number
definitions:
  domain Level = {{0 : 2}}
  domain Number = {{0 : 3}}
  domain Act = {{0 : 2}}
  invariant over n: n < 3
  CTLSPEC ag(ef((forall $x in Worker with g($x))))
  CTLSPEC af(n = 2)
  CTLSPEC ag((exists $x in Worker with f($x) = 2) implies ef(n = 0))
  LTLSPEC g(f(n = 0))
  main rule r_Main = choose $a in Worker, $act in Act with true do
    switch $act case 0 : {} case 1 : {} case 2 : {} endswitch
default init s0:
  function f($a in Worker) = 0
  function g($a in Worker) = false
  function e($a in Worker, $b in Worker) = false
  function n = 0
",
            acts[0], acts[1], acts[2]
        )
    }
}

fn word(property: &CheckedProperty) -> &'static str {
    match property.verdict {
        Verdict::Holds(_) => "holds",
        Verdict::Violated(_) => "violated",
        Verdict::Unknown => "unknown",
    }
}

/// The violation that a run shows occurs in the simulation.
fn replays(text: &str, property: &CheckedProperty) -> bool {
    let Verdict::Violated(Some(run)) = &property.verdict else {
        return false;
    };
    let steps = run.steps.len();
    match property.kind {
        PropertyKind::Invariant | PropertyKind::Constraint => {
            let (_, fault) = simulated(text, run);
            let fault = fault.unwrap_or_else(|| panic!("{text}"));
            let is_it = matches!(fault.kind, asmotion_lang::FaultKind::Invariant { .. });
            assert!(is_it && fault.step as usize == steps, "{fault:?} {text}");
        }
        PropertyKind::NoFault => {
            let text = text.replace("  invariant over n: n < 3\n", "");
            let (_, fault) = simulated(&text, run);
            assert_eq!(fault.map(|it| it.step as usize), Some(steps), "{text}");
        }
        PropertyKind::Ctl | PropertyKind::Ltl | PropertyKind::NotStuck => {
            let text = text.replace("  invariant over n: n < 3\n", "");
            let (_, fault) = simulated(&text, run);
            assert!(fault.is_none(), "{fault:?} {text}");
            if let Some(cycle) = run.cycle {
                // a stuck state repeats without a step
                let start = run.states.get(cycle);
                assert_eq!(run.states.last(), start, "{text}");
            }
        }
        PropertyKind::Possible | PropertyKind::RulesRun => return false,
    }
    true
}

fn compare(text: &str, threads: usize) -> Option<(Verification, Verification, u32)> {
    let options = Options {
        limits: Limits {
            states: Some(4_000),
            ..Limits::default()
        },
        threads,
        keeps_states: true,
        ..Options::default()
    };
    let all = verified(text, &options);
    if all.incomplete.is_some() {
        return None;
    }
    let reduced = Options {
        symmetry: true,
        ..options
    };
    let found = verified(text, &reduced);
    assert!(all.symmetric.is_empty());
    assert!(
        found.states <= all.states && found.depth == all.depth,
        "{text}"
    );
    let mut replayed = 0;
    for (one, other) in all.properties.iter().zip(&found.properties) {
        assert_eq!(word(one), word(other), "{}: {text}", one.text);
        let lengths = |it: &CheckedProperty| it.verdict.run().map(|run| run.steps.len());
        if !matches!(one.kind, PropertyKind::Ctl | PropertyKind::Ltl) {
            assert_eq!(lengths(one), lengths(other), "{}: {text}", one.text);
        }
        assert_eq!(
            one.verdict.run().is_some(),
            other.verdict.run().is_some(),
            "{text}"
        );
        replayed += u32::from(replays(text, other));
    }
    Some((all, found, replayed))
}

#[test]
fn random_specifications_have_equal_verdicts_and_runs_that_replay() {
    let mut random = Random(0x5e11_a11e_5ca1_a25e);
    let (mut reduced, mut partly, mut replayed, mut compared) = (0, 0, 0, 0);
    for index in 0..260 {
        let mut agents = Agents {
            random: &mut random,
            has_pairs: index % 3 == 1,
            has_literals: index % 4 == 2,
        };
        let text = agents.specification();
        let Some((all, found, runs)) = compare(&text, 1 + index % 2) else {
            continue;
        };
        compared += 1;
        reduced += u32::from(found.states < all.states);
        partly += u32::from(found.symmetric.iter().any(|it| it.contains(':')));
        replayed += runs;
    }
    assert!(
        compared > 150 && reduced > 80 && partly > 5 && replayed > 200,
        "{compared} {reduced} {partly} {replayed}"
    );
}

#[test]
fn two_phase_commit_has_the_known_numbers_of_orbits() {
    let Some(path) = asmotion_skip::shared("verify/tpc.asm") else {
        return;
    };
    let eight = std::fs::read_to_string(path).unwrap();
    let invariant =
        "(forall $a in Pid, $b in Pid with not (rm($a) = ABORTED and rm($b) = COMMITTED))";
    for (managers, orbits) in [(3, 80), (5, 314), (8, 1_461)] {
        let last = managers - 1;
        let text = eight.replace("domain Pid = {0:7}", &format!("domain Pid = {{0:{last}}}"));
        for (threads, storage) in [(1, Storage::Exact), (3, Storage::Compact)] {
            let options = Options {
                properties: vec![invariant.to_owned()],
                symmetry: true,
                threads,
                storage,
                ..Options::default()
            };
            let found = verified(&text, &options);
            assert_eq!(
                (found.states, &*found.symmetric),
                (orbits, &["Pid".to_owned()][..])
            );
            let held = found.properties.iter().filter(|it| it.verdict.holds());
            assert_eq!(held.count(), 3, "all but: no state is stuck");
        }
    }
    // a property that names an element leaves the others symmetric
    let options = Options {
        properties: vec!["rm(0) != ABORTED".to_owned()],
        symmetry: true,
        ..Options::default()
    };
    let three = eight.replace("domain Pid = {0:7}", "domain Pid = {0:2}");
    let found = verified(&three, &options);
    assert_eq!(found.symmetric, ["Pid: 1, 2"]);
    assert!(found.states > 80 && found.states < 288, "{}", found.states);
    assert!(found.properties[0].verdict.is_violated());
}

#[test]
fn locks_whose_values_name_processes_are_explored_completely() {
    // Peterson's lock stores and compares processes, so that locations alone cannot be exchanged
    let Some(path) = asmotion_skip::shared("verify/pet.asm") else {
        return;
    };
    let text = std::fs::read_to_string(path).unwrap();
    let text = text.replace("domain Pid = {0:4}", "domain Pid = {0:2}");
    let text = text.replace("j($i)<4", "j($i)<2");
    let options = Options {
        symmetry: true,
        ..Options::default()
    };
    let found = verified(&text, &options);
    assert_eq!((found.states, found.symmetric.len()), (705, 0));
}

#[test]
fn fairness_of_agents_needs_all_states() {
    let text = "asm model
import StandardLibrary
import CTLLibrary
signature:
  enum domain Worker = {ONE | TWO}
  controlled done: Worker -> Boolean
definitions:
  CTLSPEC af((forall $a in Worker with done($a)))
  main rule r_Main = choose $a in Worker with true do done($a) := true
default init s0:
  function done($a in Worker) = false
";
    let fair = asmotion_verify::FairName {
        name: "Worker".to_owned(),
        is_strong: false,
    };
    let with = |fairness| Options {
        symmetry: true,
        fairness,
        ..Options::default()
    };
    let found = verified(text, &with(Vec::new()));
    assert_eq!((found.states, found.symmetric.len()), (3, 1));
    assert!(found.properties[0].verdict.is_violated());
    let found = verified(text, &with(vec![fair]));
    assert_eq!((found.states, found.symmetric.len()), (4, 0));
    assert!(found.properties[0].verdict.holds());
}
