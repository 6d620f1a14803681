//! The symbolic engine agrees with the explicit one.

use crate::naive::Random;
use crate::{open, verdicts};
use asmotion_lang::MemoryFiles;
use asmotion_verify::{
    Engine, Incomplete, Limits, Note, Options, PropertyKind, Verdict, Verification, verify,
};

fn with(text: &str, engine: Engine, options: &Options) -> Result<Verification, String> {
    let options = Options {
        engine,
        ..options.clone()
    };
    verify(open(text), &options, &mut |_| true).map_err(|refusal| {
        let messages = refusal.report.diagnostics.iter();
        messages
            .map(|it| it.message.clone())
            .collect::<Vec<String>>()
            .join("; ")
    })
}

/// Number of steps of each run that shows a violation or a possibility.
fn lengths(verification: &Verification) -> Vec<Option<usize>> {
    let properties = verification.properties.iter();
    let runs = properties.map(|property| {
        // only the explicit engine shows why a temporal formula holds
        let is_shown = property.verdict.is_violated() || property.kind == PropertyKind::Possible;
        Some(property.verdict.run().filter(|_| is_shown)?.steps.len())
    });
    runs.collect()
}

/// Remarks on which the engines agree.
fn notes(verification: &Verification) -> Vec<String> {
    let properties = verification.properties.iter();
    let notes = properties.flat_map(|property| {
        property.notes.iter().map(move |note| match note {
            Note::Also(places) if property.kind == PropertyKind::RulesRun => places.join(", "),
            // which of several faults of a step comes first differs
            Note::Also(_) => String::new(),
            Note::Undefined(_)
            | Note::Fails(_)
            | Note::Unmet(_)
            | Note::Irrelevant(_)
            | Note::Unfair { .. }
            | Note::Undecided(_)
            | Note::Unexamined(_)
            | Note::FailingSteps => {
                format!("{} {note:?}", property.text)
            }
        })
    });
    notes.filter(|it| !it.is_empty()).collect()
}

/// Everything on which the engines must agree.
fn agree(text: &str, options: &Options) -> (Verification, Verification) {
    let explicit =
        with(text, Engine::Explicit, options).unwrap_or_else(|it| panic!("{it}\n{text}"));
    let symbolic =
        with(text, Engine::Symbolic, options).unwrap_or_else(|it| panic!("{it}\n{text}"));
    compare(&explicit, &symbolic, text);
    (explicit, symbolic)
}

fn compare(explicit: &Verification, symbolic: &Verification, text: &str) {
    assert_eq!(verdicts(symbolic), verdicts(explicit), "{text}");
    let numbers = |it: &Verification| (it.states, it.transitions, it.depth, it.excluded, it.ends);
    assert_eq!(numbers(symbolic), numbers(explicit), "{text}");
    assert_eq!(notes(symbolic), notes(explicit), "{text}");
}

/// Adds a function for which conditions are short, and temporal properties.
pub fn formula(random: &mut Random, depth: u32, is_linear: bool) -> String {
    if depth == 0 || random.below(5) == 0 {
        return random.condition(1);
    }
    let unary = if is_linear {
        ["x", "f", "g", "y", "z", "o", "h", "not"]
    } else {
        ["ex", "ax", "ef", "af", "eg", "ag", "not", "ef"]
    };
    let binary = if is_linear {
        ["u", "v", "s", "t", "and", "or", "implies", "u"]
    } else {
        ["eu", "au", "ew", "aw", "and", "or", "implies", "iff"]
    };
    if random.below(2) == 0 {
        let operator = random.one_of(&unary);
        return format!("{operator}({})", formula(random, depth - 1, is_linear));
    }
    let operator = random.one_of(&binary);
    let left = formula(random, depth - 1, is_linear);
    let right = formula(random, depth - 1, is_linear);
    match operator {
        "and" | "or" | "implies" | "iff" => format!("(({left}) {operator} ({right}))"),
        _ => format!("{operator}({left}, {right})"),
    }
}

#[test]
fn random_specifications_have_the_same_states_and_verdicts() {
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    let (mut large, mut violated, mut fails) = (0, 0, 0);
    for _ in 0..300 {
        let text = random.specification();
        let invariant = random.condition(2);
        let text = text.replace(
            "  main rule",
            &format!("  invariant inv over p: {invariant}\n  main rule"),
        );
        let options = Options {
            possible: vec![random.condition(2)],
            ..Options::default()
        };
        let (explicit, symbolic) = agree(&text, &options);
        assert_eq!(lengths(&symbolic), lengths(&explicit), "{text}");
        large += u32::from(explicit.states > 4);
        violated += explicit
            .properties
            .iter()
            .filter(|it| it.verdict.is_violated())
            .count();
        let fault = explicit
            .properties
            .iter()
            .find(|it| it.text == "no step fails");
        fails += u32::from(fault.unwrap().verdict.is_violated());
    }
    // the specifications are not all trivial
    assert!(
        large > 30 && violated > 100 && fails > 20,
        "{large} {violated} {fails}"
    );
}

#[test]
fn random_temporal_formulas_have_the_same_verdicts() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let (mut holds, mut violated) = (0, 0);
    for round in 0..300 {
        let text = random.specification();
        let mut properties = String::new();
        for _ in 0..2 {
            properties += &format!("  CTLSPEC {}\n", formula(&mut random, 3, false));
            properties += &format!("  LTLSPEC {}\n", formula(&mut random, 3, true));
        }
        if round % 3 == 0 {
            properties += &format!("  JUSTICE {}\n", random.condition(1));
        }
        if round % 5 == 0 {
            let (cause, effect) = (random.condition(1), random.condition(1));
            properties += &format!("  COMPASSION({cause}, {effect})\n");
        }
        if round % 7 == 0 {
            properties += "  INVAR not (left and right)\n";
        }
        let text = text
            .replace(
                "StandardLibrary",
                "StandardLibrary\nimport CTLLibrary\nimport LTLLibrary",
            )
            .replace("  main rule", &format!("{properties}  main rule"));
        let (explicit, symbolic) = agree(&text, &Options::default());
        assert_eq!(lengths(&symbolic), lengths(&explicit), "{text}");
        holds += explicit
            .properties
            .iter()
            .filter(|it| it.verdict.holds())
            .count();
        violated += explicit
            .properties
            .iter()
            .filter(|it| it.verdict.is_violated())
            .count();
    }
    assert!(holds > 300 && violated > 300, "{holds} {violated}");
}

/// The specifications in a folder, with those that they import.
fn specifications(folder: &std::path::Path) -> MemoryFiles {
    let mut files = MemoryFiles::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|it| it == "asm") {
            let text = std::fs::read_to_string(&path).unwrap();
            files.add(path.file_name().unwrap().to_str().unwrap(), text.as_str());
        }
    }
    files
}

/// Compares the engines on all specifications of a folder. Returns those that were compared and those that the symbolic engine
/// refuses.
fn compared(folder: &std::path::Path) -> (Vec<String>, Vec<String>) {
    let files = specifications(folder);
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.ends_with(".asm"))
        .collect();
    names.sort();
    let (mut done, mut refused) = (Vec::new(), Vec::new());
    for name in names {
        let run = |engine: Engine| {
            let specification = asmotion_lang::open(&name, &files).ok()?;
            specification.model.main?;
            let limits = Limits {
                states: Some(20_000),
                ..Limits::default()
            };
            let options = Options {
                limits,
                engine,
                ..Options::default()
            };
            Some(verify(specification, &options, &mut |_| true))
        };
        let Some(Ok(explicit)) = run(Engine::Explicit) else {
            continue;
        };
        match run(Engine::Symbolic) {
            Some(Ok(symbolic)) if explicit.incomplete.is_none() => {
                compare(&explicit, &symbolic, &name);
                assert_eq!(lengths(&symbolic), lengths(&explicit), "{name}");
                done.push(name);
            }
            Some(Ok(_)) => {}
            Some(Err(_)) | None => refused.push(name),
        }
    }
    (done, refused)
}

#[test]
fn specifications_have_the_same_states_and_verdicts() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let (mut done, mut refused) = compared(&root.join("tests/models"));
    for folder in [
        "ball_tracker",
        "estop",
        "navigation",
        "patrol",
        "recovery",
        "youbot",
        "allocation",
        "courier",
    ] {
        let (here, not_here) = compared(&root.join("../../specs").join(folder));
        done.extend(here);
        refused.extend(not_here);
    }
    if let Some(shared) = asmotion_skip::shared("specs") {
        let (here, not_here) = compared(&shared);
        done.extend(here);
        refused.extend(not_here);
    }
    assert!(done.len() >= 9, "{done:?}");
    // it exchanges messages
    assert_eq!(refused, ["robot.asm"]);
}

#[test]
fn models_of_other_checkers_have_the_same_states_and_verdicts() {
    let smaller: &[(&str, &[(&str, &str)])] = &[
        ("phil.asm", &[("{0:15}", "{0:5}"), ("mod 16", "mod 6")]),
        ("philinv.asm", &[("{0:15}", "{0:5}"), ("mod 16", "mod 6")]),
        (
            "pet.asm",
            &[
                ("domain Pid = {0:4}", "domain Pid = {0:2}"),
                ("j($i)<4", "j($i)<2"),
            ],
        ),
        ("tpc.asm", &[("domain Pid = {0:7}", "domain Pid = {0:3}")]),
        (
            "queue.asm",
            &[
                ("domain Sel = {0:4}", "domain Sel = {0:3}"),
                ("domain New = {0:2}", "domain New = {0:1}"),
            ],
        ),
    ];
    for (name, changes) in smaller {
        let Some(path) = asmotion_skip::shared(&format!("verify/{name}")) else {
            return;
        };
        let mut text = std::fs::read_to_string(path).unwrap();
        for (from, to) in *changes {
            text = text.replace(from, to);
        }
        let (explicit, symbolic) = agree(&text, &Options::default());
        assert_eq!(lengths(&symbolic), lengths(&explicit), "{name}");
        assert!(explicit.states > 100, "{name}: {}", explicit.states);
    }
}

#[test]
fn a_limit_leaves_nothing_said_to_hold() {
    let text = "asm count
import StandardLibrary
import CTLLibrary
signature:
  domain Number subsetof Integer
  controlled n: Number
definitions:
  domain Number = {0 : 9}
  invariant inv over n: n < 10
  CTLSPEC af(n = 9)
  main rule r_Main = if n < 9 then n := n + 1 endif
default init s0:
  function n = 0
";
    let limits = [
        (
            Limits {
                depth: Some(4),
                ..Limits::default()
            },
            Incomplete::Depth,
        ),
        (
            Limits {
                states: Some(4),
                ..Limits::default()
            },
            Incomplete::States,
        ),
    ];
    for (limits, reason) in limits {
        let options = Options {
            limits,
            ..Options::default()
        };
        let found = with(text, Engine::Symbolic, &options).unwrap();
        assert_eq!(found.incomplete, Some(reason));
        let claimed = found.properties.iter().filter(|it| it.verdict.holds());
        let claimed: Vec<&str> = claimed.map(|it| it.text.as_str()).collect();
        assert_eq!(claimed, ["every rule runs"]);
    }
    let options = Options {
        engine: Engine::Symbolic,
        ..Options::default()
    };
    for calls in [0, 1, 5, 20] {
        let mut left = calls;
        let stopped = verify(open(text), &options, &mut |_| {
            left -= 1;
            left >= 0
        });
        let stopped = stopped.unwrap_or_else(|_| panic!("refused"));
        assert_eq!(stopped.incomplete, Some(Incomplete::Stopped), "{calls}");
        let of_paths = stopped.properties.iter().find(|it| it.text == "af(n = 9)");
        assert!(
            matches!(of_paths.unwrap().verdict, Verdict::Unknown),
            "{calls}"
        );
    }
}

#[test]
fn locations_without_a_finite_domain_get_the_values_of_their_updates() {
    let text = "asm count
import StandardLibrary
signature:
  monitored go: Boolean
  controlled n: Integer
  controlled name: String
definitions:
  invariant inv over n: n <= 5
  main rule r_Main = par
    if go and n < 6 then n := n + 1 endif
    if n = 3 then name := \"three\" endif
  endpar
default init s0:
  function n = 0
  function name = \"\"
";
    let (explicit, symbolic) = agree(text, &Options::default());
    assert_eq!(lengths(&symbolic), lengths(&explicit));
}

#[test]
fn what_has_no_representation_is_refused_with_a_way_out() {
    let unbounded = "asm count
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := n + 1
default init s0:
  function n = 0
";
    let options = Options {
        engine: Engine::Symbolic,
        ..Options::default()
    };
    let Err(refusal) = verify(open(unbounded), &options, &mut |_| true) else {
        panic!("accepted");
    };
    let found = &refusal.report.diagnostics[0];
    assert_eq!(
        found.message,
        "the symbolic engine cannot represent a location with this many values"
    );
    let created = "asm grow
import StandardLibrary
signature:
  abstract domain Job
  controlled jobs: Integer
definitions:
  main rule r_Main = extend Job with $job do jobs := 1
default init s0:
  function jobs = 0
";
    let refused = with(created, Engine::Symbolic, &Options::default()).unwrap_err();
    assert_eq!(refused, "the symbolic engine cannot represent `extend`");
}

#[test]
fn a_part_of_a_value_outside_its_domain_is_a_fault_for_both_engines() {
    let text = "asm parts
import StandardLibrary
signature:
  domain Few subsetof Integer
  monitored go: Boolean
  controlled n: Few
  controlled row: Seq(Few)
  controlled bag: Bag(Prod(Few, Boolean))
definitions:
  domain Few = {3, 5, 7}
  main rule r_Main = par
    if go and n < 7 then n := n + 2 endif
    if n = 5 then row := [3, PART] endif
    if n = 7 then bag := <(PART, go)> endif
  endpar
default init s0:
  function n = 3
  function row = [3]
";
    for (part, fails) in [("3", false), ("4", true), ("n", false), ("n - 1", true)] {
        let text = text.replace("PART", part);
        let (explicit, symbolic) = agree(&text, &Options::default());
        assert_eq!(lengths(&symbolic), lengths(&explicit), "{part}");
        let mut properties = explicit.properties.iter();
        let found = properties.find(|it| it.text == "no step fails").unwrap();
        assert_eq!(found.verdict.is_violated(), fails, "{part}");
    }
}
