//! Models with known verdicts.

use crate::{verdicts, verified};
use asmotion_verify::{Engine, Incomplete, Limits, Note, Options};

pub const PHILOSOPHERS: &str = include_str!("models/philosophers.asm");
pub const LAMP: &str = include_str!("models/lamp.asm");
pub const FAULTY: &str = include_str!("models/faulty.asm");

#[test]
fn philosophers_starve() {
    let verification = verified(PHILOSOPHERS, &Options::default());
    let expected = [
        ("inv_exclusive", "holds"),
        ("inv_wrong", "violated"),
        ("eats", "holds"),
        ("recovers", "violated"),
        ("hungry", "violated"),
        ("ordered", "holds"),
        ("no step fails", "holds"),
        ("no state is stuck", "violated"),
        ("every rule runs", "holds"),
    ];
    let expected = expected.map(|(name, verdict)| (name.to_owned(), verdict));
    assert_eq!(verdicts(&verification), expected);
}

#[test]
fn the_lamp_is_verified_for_the_inputs_that_are_assumed() {
    let verification = verified(LAMP, &Options::default());
    let expected = [
        ("inv_off", "holds"),
        ("obeys", "violated"),
        ("can_be_dark", "holds"),
        ("darkens", "violated"),
        ("darkens_if_pressed", "holds"),
        ("no step fails", "holds"),
        ("no state is stuck", "holds"),
        ("every rule runs", "holds"),
    ];
    let expected = expected.map(|(name, verdict)| (name.to_owned(), verdict));
    assert_eq!(verdicts(&verification), expected);
    assert_eq!(verification.states, 4);
    // of each state with the inputs that the properties mention, one combination of four
    assert_eq!(verification.excluded, 4);
    assert_eq!(verification.assumptions, ["not (isPressed and isLocked)"]);
}

#[test]
fn operators_are_available_in_properties_from_outside() {
    let text = LAMP.lines().filter(|line| {
        let uses = ["CTL", "LTL"];
        !uses.iter().any(|it| line.contains(it))
    });
    let text = text.collect::<Vec<_>>().join("\n");
    let properties = [
        ("ag(isOn implies ef(not isOn))", "holds"),
        ("absenceG(isOn)", "violated"),
        // a tuple stands for all operands
        ("eu((not isOn, isOn))", "holds"),
        ("g(isOn implies f(not isOn))", "violated"),
        ("isOn implies isOn", "holds"),
    ];
    let selected: Vec<String> = properties.iter().map(|(it, _)| (*it).to_owned()).collect();
    for engine in [Engine::Explicit, Engine::Symbolic] {
        let options = Options {
            properties: selected.clone(),
            only: selected.clone(),
            engine,
            ..Options::default()
        };
        let found = verdicts(&verified(&text, &options));
        let expected = properties.map(|(text, verdict)| (text.to_owned(), verdict));
        assert_eq!(found, expected);
    }
}

const PATTERNS: &str = "asm crossing
import StandardLibrary
import CTLLibrary
import LTLLibrary
signature:
  enum domain Robot = {R1 | R2}
  enum domain Place = {OUT | WAITING | IN}
  controlled place: Robot -> Place
  static answered: Prod(Boolean, Boolean) -> Boolean
  static reaches: Prod(Robot, Place) -> Boolean
  static never: Boolean -> Boolean
  derived canMeet: Boolean
  derived level: Integer
  static endless: Boolean -> Boolean
definitions:
  // declared after its use
  function answered($p in Boolean, $q in Boolean) = ag($p implies never(never($q)))
  function never($p in Boolean) = not ef($p)
  function reaches($r in Robot, $to in Place) = ag(ef(place($r) = $to))
  function canMeet = ef(place(R1) = IN and place(R2) = IN)
  function level = if ag(place(R1) = OUT) then 1 else 2 endif
  function endless($p in Boolean) = ax($p) and endless(ax($p))
  main rule r_Main = choose $r in Robot with true do
    switch place($r)
      case OUT: place($r) := WAITING
      case WAITING: if (forall $o in Robot with place($o) != IN) then place($r) := IN endif
      case IN: place($r) := OUT
    endswitch
default init s0:
  function place($r in Robot) = OUT
";

#[test]
fn properties_apply_functions_that_are_defined_by_temporal_operators() {
    let properties = [
        (
            "(forall $r in Robot, $p in Place with reaches($r, $p))",
            "holds",
        ),
        ("reaches(R1, IN) implies canMeet", "violated"),
        ("not canMeet", "holds"),
        ("never(place(R1) = IN)", "violated"),
        (
            "ag(place(R1) = WAITING implies not never(place(R1) = IN))",
            "holds",
        ),
        ("answered(place(R1) = WAITING, place(R1) = IN)", "holds"),
        // a definition may contain all that a property may
        ("absenceAfter(place(R1) = OUT, place(R1) = IN)", "violated"),
        (
            "absenceBefore(place(R1) = IN, place(R1) = WAITING)",
            "holds",
        ),
        ("ap(place(R1) = IN, place(R1) = WAITING)", "holds"),
        (
            "pb(place(R2) = IN, place(R2) = WAITING, place(R1) = IN)",
            "holds",
        ),
        (
            "absenceBetween(place(R2) = IN, place(R1) = IN, place(R1) = OUT)",
            "holds",
        ),
        (
            "absenceAfterUntil(place(R2) = WAITING, place(R1) = IN, place(R1) = OUT)",
            "violated",
        ),
        ("ew(place(R1) = OUT, place(R1) = IN)", "holds"),
        ("aw(place(R1) != IN, place(R1) = WAITING)", "holds"),
    ];
    let selected: Vec<String> = properties.iter().map(|(it, _)| (*it).to_owned()).collect();
    for engine in [Engine::Explicit, Engine::Symbolic] {
        let options = Options {
            properties: selected.clone(),
            only: selected.clone(),
            engine,
            ..Options::default()
        };
        let found = verdicts(&verified(PATTERNS, &options));
        let expected = properties.map(|(text, verdict)| (text.to_owned(), verdict));
        assert_eq!(found, expected);
    }
}

#[test]
fn an_invariant_has_no_temporal_operators() {
    for condition in ["ag(ef(place(R1) = IN))", "place(R1) = IN or canMeet"] {
        let invariant = format!("  invariant inv_wrong over place: {condition}\n  main rule");
        let text = PATTERNS.replace("  main rule", &invariant);
        let mut files = asmotion_lang::MemoryFiles::new();
        files.add("crossing.asm", text);
        let specification = asmotion_lang::open("crossing.asm", &files).unwrap();
        let options = Options::default();
        let refusal = asmotion_verify::verify(specification, &options, &mut |_| true).unwrap_err();
        let text = crate::refused(&refusal);
        assert!(text.contains("an invariant is about one state"), "{text}");
        assert!(text.contains("declare a CTLSPEC"), "{text}");
    }
}

/// An operand of a pattern occurs several times in it: only if none of them matters, the operand does not.
#[test]
fn an_operand_of_a_pattern_matters_if_one_of_its_occurrences_does() {
    let property = "(forall $r in Robot with ap(place($r) = IN, place($r) = WAITING))";
    for engine in [Engine::Explicit, Engine::Symbolic] {
        let options = Options {
            properties: vec![property.to_owned()],
            only: vec![property.to_owned()],
            engine,
            ..Options::default()
        };
        let found = verified(PATTERNS, &options);
        assert_eq!(verdicts(&found), [(property.to_owned(), "holds")]);
        let notes = &found.properties[0].notes;
        let irrelevant = notes.iter().any(|it| matches!(it, Note::Irrelevant(_)));
        assert!(!irrelevant, "{notes:?}");
    }
}

#[test]
fn definitions_that_are_no_formulas_are_refused_where_they_are_applied() {
    for (property, problem) in [
        ("level = 2", "a temporal operator is inside a term"),
        (
            "endless(place(R1) = OUT)",
            "a temporal operator is inside a term",
        ),
        (
            "g(absenceG(place(R1) = IN))",
            "`absenceG` is no operator of LTL",
        ),
        ("f(axN(place(R1) = IN, 2n))", "`axN` is no operator of LTL"),
        // not a literal
        (
            "reaches(R1, place(R2))",
            "a temporal operator is inside a term",
        ),
    ] {
        let mut files = asmotion_lang::MemoryFiles::new();
        files.add("crossing.asm", PATTERNS);
        let specification = asmotion_lang::open("crossing.asm", &files).unwrap();
        let options = Options {
            properties: vec![property.to_owned()],
            ..Options::default()
        };
        let refusal = asmotion_verify::verify(specification, &options, &mut |_| true).unwrap_err();
        let text = crate::refused(&refusal);
        assert!(
            text.contains("M003") && text.contains(problem),
            "{property}: {text}"
        );
        assert!(text.contains("<property>"), "{text}");
    }
}

#[test]
fn a_function_of_the_specification_hides_an_operator() {
    let text = "asm hidden
import StandardLibrary
signature:
  controlled f: Integer -> Boolean
definitions:
  main rule r_Main = f(1) := not f(1)
default init s0:
  function f($i in Integer) = false
";
    let properties = ["f(1)".to_owned(), "ag(ef(f(1)))".to_owned()];
    let options = Options {
        properties: properties.to_vec(),
        only: properties.to_vec(),
        ..Options::default()
    };
    let found = verdicts(&verified(text, &options));
    let found: Vec<&str> = found.iter().map(|(_, verdict)| *verdict).collect();
    assert_eq!(found, ["violated", "holds"]);
}

#[test]
fn faults_are_found_with_the_shortest_run() {
    let verification = verified(FAULTY, &Options::default());
    let [faults, stuck, rules] = verification.properties.as_slice() else {
        panic!("{:?}", verdicts(&verification));
    };
    let run = faults.verdict.run().unwrap();
    assert_eq!(run.steps.len(), 1);
    let fault = run.steps[0].fault.as_ref().unwrap();
    assert!(fault.message.contains("`owner`"), "{}", fault.message);
    let [asmotion_verify::Note::Also(others)] = faults.notes.as_slice() else {
        panic!("{:?}", faults.notes);
    };
    assert_eq!(others.len(), 2, "{others:?}");
    assert!(stuck.verdict.holds());
    let [asmotion_verify::Note::Also(rules)] = rules.notes.as_slice() else {
        panic!("{:?}", rules.notes);
    };
    assert_eq!(rules.len(), 1);
    assert!(rules[0].starts_with("r_never "), "{rules:?}");
}

#[test]
fn a_truncated_exploration_never_says_holds_for_all_states() {
    let limits = [
        Limits {
            states: Some(20),
            ..Limits::default()
        },
        Limits {
            depth: Some(2),
            ..Limits::default()
        },
        Limits {
            memory: Some(1),
            ..Limits::default()
        },
    ];
    for limits in limits {
        let options = Options {
            limits,
            ..Options::default()
        };
        let verification = verified(PHILOSOPHERS, &options);
        assert!(verification.incomplete.is_some());
        let all = verdicts(&verification);
        let held: Vec<_> = all
            .iter()
            .filter(|(_, verdict)| *verdict == "holds")
            .collect();
        // rules can be known to run without knowing all states
        assert!(
            held.iter().all(|(name, _)| name == "every rule runs"),
            "{all:?}"
        );
    }
    let stopped =
        asmotion_verify::verify(crate::open(PHILOSOPHERS), &Options::default(), &mut |_| {
            false
        });
    assert!(stopped.unwrap().incomplete.is_some());
}

#[test]
fn properties_assumptions_and_ends_can_be_given() {
    let options = Options {
        properties: vec![
            "ag(level <= 3)".to_owned(),
            "level < 2".to_owned(),
            "f(isOn)".to_owned(),
        ],
        possible: vec!["level = 3".to_owned(), "level = 0 and isOn".to_owned()],
        only: [
            "ag(level <= 3)",
            "level < 2",
            "f(isOn)",
            "level = 3",
            "level = 0 and isOn",
        ]
        .map(str::to_owned)
        .into(),
        assumptions: vec!["not isLocked".to_owned()],
        ..Options::default()
    };
    let verification = verified(LAMP, &options);
    let expected = ["holds", "violated", "violated", "holds", "violated"];
    let found: Vec<&str> = verdicts(&verification)
        .into_iter()
        .map(|(_, verdict)| verdict)
        .collect();
    assert_eq!(found, expected);
    let options = Options {
        ends: Some("(forall $p in Philosopher with phase($p) = HOLDS_LEFT)".to_owned()),
        ..Options::default()
    };
    let verification = verified(PHILOSOPHERS, &options);
    assert!(verdicts(&verification).contains(&("no state is stuck".to_owned(), "holds")));
    let annotated = PHILOSOPHERS.replace("\tmain rule", "\t//@Final HOLDS_LEFT\n\tmain rule");
    let verification = verified(&annotated, &Options::default());
    assert!(verdicts(&verification).contains(&("no state is stuck".to_owned(), "holds")));
}

#[test]
fn fairness_changes_the_verdict_and_nothing_fair_is_said() {
    let fair = LAMP.replace("\tmain rule", "\tJUSTICE isPressed\n\tmain rule");
    let verification = verified(&fair, &Options::default());
    assert!(verdicts(&verification).contains(&("darkens".to_owned(), "holds")));
    let unfair = LAMP.replace(
        "\tmain rule",
        "\tJUSTICE isPressed and isLocked\n\tmain rule",
    );
    let verification = verified(&unfair, &Options::default());
    let darkens = verification
        .properties
        .iter()
        .find(|it| it.name.as_deref() == Some("darkens"));
    let notes = &darkens.unwrap().notes;
    assert!(
        matches!(
            notes.as_slice(),
            [asmotion_verify::Note::Unfair { all: true }]
        ),
        "{notes:?}"
    );
    // infinitely often pressed, though not in states in which the lamp is on: then it is never switched off
    let compassion = LAMP.replace("\tmain rule", "\tCOMPASSION(isOn, isPressed)\n\tmain rule");
    let verification = verified(&compassion, &Options::default());
    assert!(verdicts(&verification).contains(&("darkens".to_owned(), "holds")));
    let restricted = LAMP.replace("\tmain rule", "\tINVAR not isPressed\n\tmain rule");
    let verification = verified(&restricted, &Options::default());
    assert_eq!(verification.states, 1);
}

#[test]
fn vacuous_properties_are_marked() {
    let vacuous = LAMP
        .replace(
            "CTLSPEC obeys: ag(isPressed implies ax(isOn))",
            "CTLSPEC obeys: ag(level = 3 and not isOn implies ax(isOn))",
        )
        .replace(
            "inv_off over isOn, level: isOn or level = 0",
            "inv_off over isOn, level: (level = 1 and not isOn) implies level = 2",
        );
    let verification = verified(&vacuous, &Options::default());
    for name in ["obeys", "inv_off"] {
        let property = verification
            .properties
            .iter()
            .find(|it| it.name.as_deref() == Some(name))
            .unwrap();
        assert!(property.verdict.holds());
        let unmet = property
            .notes
            .iter()
            .any(|note| matches!(note, asmotion_verify::Note::Unmet(unmet) if unmet.len() == 1));
        assert!(unmet, "{:?}", property.notes);
    }
    let others = verification
        .properties
        .iter()
        .filter(|it| it.name.as_deref() == Some("can_be_dark"));
    assert!(others.clone().count() == 1 && others.into_iter().all(|it| it.notes.is_empty()));
}

/// The philosophers, verified until all states are explored.
fn explored_only(limits: Limits) -> asmotion_verify::Verification {
    let options = Options {
        limits,
        ..Options::default()
    };
    let specification = crate::open(PHILOSOPHERS);
    let found = asmotion_verify::verify(specification, &options, &mut |progress| {
        limits.memory.is_some() || progress.explored < progress.states
    });
    found.unwrap_or_else(|refusal| panic!("{}", crate::refused(&refusal)))
}

/// Returns the limit that was reached before each property was decided.
fn undecided(found: &asmotion_verify::Verification) -> Vec<(String, Incomplete)> {
    let properties = found.properties.iter();
    let undecided = properties.filter_map(|it| {
        let mut notes = it.notes.iter();
        let limit = notes.find_map(|note| {
            if let Note::Undecided(limit) = note {
                Some(*limit)
            } else {
                None
            }
        })?;
        assert!(matches!(it.verdict, asmotion_verify::Verdict::Unknown));
        Some((it.name.clone().unwrap_or_default(), limit))
    });
    undecided.collect()
}

#[test]
fn a_property_is_not_decided_beyond_a_limit() {
    let found = explored_only(Limits::default());
    assert_eq!(found.incomplete, None);
    let names: Vec<String> = undecided(&found)
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    assert_eq!(names, ["eats", "recovers", "hungry", "ordered"]);
    let kept = verdicts(&found);
    assert_eq!(kept[0], ("inv_exclusive".to_owned(), "holds"));
    assert_eq!(kept[1], ("inv_wrong".to_owned(), "violated"));
}

#[test]
fn a_property_is_not_decided_beyond_the_memory() {
    let all = verified(PHILOSOPHERS, &Options::default());
    // more than the exploration takes, and less than the formulas do
    let limits = (1..).map(|part| all.memory + all.memory * part / 16);
    let found = limits.map(|memory| {
        explored_only(Limits {
            memory: Some(memory),
            ..Limits::default()
        })
    });
    let explored = found.take(64).find(|it| it.incomplete.is_none()).unwrap();
    let limits: Vec<Incomplete> = undecided(&explored).into_iter().map(|(_, it)| it).collect();
    assert!(!limits.is_empty());
    assert!(limits.iter().all(|it| *it == Incomplete::Memory));
}

/// A step with 2^14 combinations of inputs, each of which leads to another state.
fn many_successors(limits: Limits, without_grounding: bool) -> asmotion_verify::Verification {
    let text = "asm many
import StandardLibrary
signature:
  domain Bit subsetof Integer
  monitored given: Bit -> Boolean
  controlled kept: Bit -> Boolean
definitions:
  domain Bit = {0 : 13}
  main rule r_Main = forall $b in Bit with true do kept($b) := given($b)
default init s0:
  function kept($b in Bit) = false
";
    let options = Options {
        limits,
        without_grounding,
        ..Options::default()
    };
    let mut calls = 0;
    let found = asmotion_verify::verify(crate::open(text), &options, &mut |_| {
        calls += 1;
        limits.memory.is_some() || calls < 20
    });
    found.unwrap_or_else(|refusal| panic!("{}", crate::refused(&refusal)))
}

#[test]
fn limits_hold_within_a_step_with_many_successors() {
    let found = many_successors(Limits::default(), true);
    assert_eq!(
        (found.incomplete, found.states),
        (Some(Incomplete::Stopped), 1)
    );
    let limits = Limits {
        memory: Some(100_000),
        ..Limits::default()
    };
    let found = many_successors(limits, true);
    assert_eq!(
        (found.incomplete, found.states),
        (Some(Incomplete::Memory), 1)
    );
}
