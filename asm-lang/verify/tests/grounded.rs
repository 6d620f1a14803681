//! The grounded form of steps, compared with machines that execute every step.

use crate::naive::Random;
use crate::open;
use asmotion_lang::Specification;
use asmotion_verify::{Note, Options, PropertyKind, Verdict, Verification, verify};

/// Everything in which two verifications of one specification must agree.
fn summary(verification: &Verification) -> String {
    let mut text = format!(
        "{} states, {} transitions, {} deep, {} excluded, {:?}\n",
        verification.states,
        verification.transitions,
        verification.depth,
        verification.excluded,
        verification.incomplete
    );
    for property in &verification.properties {
        let verdict = match &property.verdict {
            Verdict::Holds(_) => "holds",
            Verdict::Violated(_) => "violated",
            Verdict::Unknown => "unknown",
        };
        text += &format!("{}: {verdict} {:?}\n", property.text, property.notes);
        if let Some(run) = property.verdict.run() {
            text += &format!("{} steps, cycle {:?}\n", run.steps.len(), run.cycle);
            let faults = run.steps.iter().filter_map(|step| step.fault.as_ref());
            for fault in faults {
                text += &format!("fault {}\n", fault.message);
            }
        }
    }
    text
}

/// Verifies a specification in both forms; returns the grounded result.
fn compared(
    text: &str,
    specification: impl Fn() -> Specification,
    options: &Options,
) -> Option<Verification> {
    let plain = Options {
        without_grounding: true,
        ..options.clone()
    };
    let found = verify(specification(), options, &mut |_| true);
    let expected = verify(specification(), &plain, &mut |_| true);
    match (found, expected) {
        (Ok(found), Ok(expected)) => {
            assert!(!expected.is_grounded);
            assert_eq!(summary(&found), summary(&expected), "{text}");
            Some(found)
        }
        (Err(found), Err(expected)) => {
            let messages = |refusal: &asmotion_verify::Refusal| {
                let diagnostics = refusal.report.diagnostics.iter();
                diagnostics
                    .map(|it| it.message.clone())
                    .collect::<Vec<String>>()
            };
            assert_eq!(messages(&found), messages(&expected), "{text}");
            None
        }
        (found, expected) => panic!("{text}: {} {}", found.is_ok(), expected.is_ok()),
    }
}

#[test]
fn grounded_random_specifications_have_the_results_of_machines() {
    let mut random = Random(0x1234_5678_9abc_def1);
    let mut grounded = 0;
    for _ in 0..300 {
        let text = random.specification();
        let properties = [
            "ag(p or n < 3)",
            "ef(q and n = 2)",
            "ag(ef(m(1) = 2))",
            "n = m(2) implies p",
        ];
        let options = Options {
            properties: properties.iter().map(|it| (*it).to_owned()).collect(),
            ..Options::default()
        };
        let text = text.replace(
            "import StandardLibrary",
            "import StandardLibrary\nimport CTLLibrary",
        );
        let found = compared(&text, || open(&text), &options);
        grounded += u32::from(found.is_some_and(|it| it.is_grounded));
    }
    assert!(grounded > 250, "{grounded}");
}

/// A condition is evaluated in a new state only if the step has changed something that it reads. Without inputs, each state is one
/// node.
#[test]
fn conditions_keep_their_values_while_nothing_that_they_read_changes() {
    let mut random = Random(0x51de_5678_9abc_def1);
    let (mut grounded, mut undefined, mut violated) = (0, 0, 0);
    for _ in 0..300 {
        let text = random.specification().replace("monitored", "controlled");
        let text = text.replace(
            "function p = false",
            "function p = false\n  function left = true\n  function right = undef",
        );
        let properties = std::iter::repeat_with(|| random.condition(2)).take(8);
        let options = Options {
            properties: properties.collect(),
            ..Options::default()
        };
        let Some(found) = compared(&text, || open(&text), &options) else {
            continue;
        };
        grounded += u32::from(found.is_grounded);
        let conditions = found.properties.iter();
        let conditions = conditions.filter(|it| it.kind == PropertyKind::Invariant);
        for condition in conditions {
            let mut notes = condition.notes.iter();
            undefined += u32::from(notes.any(|it| matches!(it, Note::Undefined(_))));
            let run = condition.verdict.run();
            violated += u32::from(run.is_some_and(|run| run.steps.len() > 1));
        }
    }
    assert!(
        grounded > 250 && undefined > 80 && violated > 20,
        "{grounded} {undefined} {violated}"
    );
}

#[test]
fn random_specifications_without_inputs_have_the_results_of_machines() {
    let mut random = Random(0x0dd0_5678_9abc_def1);
    let mut grounded = 0;
    for _ in 0..300 {
        let text = random.specification().replace("monitored", "controlled");
        let text = text.replace(
            "function p = false",
            "function p = false\n  function left = true\n  function right = undef",
        );
        let found = compared(&text, || open(&text), &Options::default());
        grounded += u32::from(found.is_some_and(|it| it.is_grounded));
    }
    assert!(grounded > 250, "{grounded}");
}

#[test]
fn properties_that_read_inputs_and_assumptions_have_the_results_of_machines() {
    let mut random = Random(0x1a50_5678_9abc_de41);
    let properties = [
        "ag(left implies ax(p or q))",
        "ag((left and n > 2) implies ef(right and q))",
        "left or right or n < 3",
        "ag(ef(m(1) = 2))",
        "af(q or left)",
    ];
    let assumptions = ["not (left and right)", "left or n < 3", "p or q or left"];
    let (mut grounded, mut excluded, mut unmet) = (0, 0, 0);
    for index in 0..300 {
        let text = random.specification().replace(
            "import StandardLibrary",
            "import StandardLibrary\nimport CTLLibrary",
        );
        let assumed = (index % 2 == 1).then(|| assumptions[index / 2 % 3].to_owned());
        let options = Options {
            properties: properties.iter().map(|it| (*it).to_owned()).collect(),
            assumptions: assumed.into_iter().collect(),
            threads: 1 + index % 3,
            ..Options::default()
        };
        let Some(found) = compared(&text, || open(&text), &options) else {
            unmet += 1;
            continue;
        };
        grounded += u32::from(found.is_grounded);
        excluded += u32::from(found.excluded > 0);
    }
    assert!(
        grounded > 200 && excluded > 50,
        "{grounded} {excluded} {unmet}"
    );
}

/// Agents that work, of which each may rest for ever unless it is fair.
const AGENTS: &str = "asm model
import StandardLibrary
import CTLLibrary
signature:
  domain Worker subsetof Integer
  domain Count subsetof Integer
  controlled work: Worker -> Count
  controlled turn: Worker
definitions:
  domain Worker = {1 : 3}
  domain Count = {0 : 3}
  rule r_work($a in Worker) = if work($a) < 3 then work($a) := work($a) + 1 else work($a) := 0 endif
  rule r_pass = turn := (turn mod 3) + 1
  CTLSPEC ag(af(work(1) = 3))
  CTLSPEC ag(af(work(2) = 0))
  CTLSPEC ag(af(turn = 2))
  main rule r_Main = choose $a in Worker with turn = $a or $a = 1 do par r_work[$a] if work($a) = 2 then r_pass[] endif endpar
default init s0:
  function work($a in Worker) = 0
  function turn = 1
";

#[test]
fn fairness_of_agents_and_rules_has_the_results_of_machines() {
    let mut verdicts = std::collections::BTreeSet::new();
    for (names, is_strong) in [
        (&[][..], false),
        (&["Worker"], false),
        (&["Worker"], true),
        (&["r_pass"], true),
        (&["Worker", "r_pass"], true),
    ] {
        let fairness = names.iter().map(|name| asmotion_verify::FairName {
            name: (*name).to_owned(),
            is_strong,
        });
        let options = Options {
            fairness: fairness.collect(),
            ..Options::default()
        };
        let found = compared(&format!("{names:?} {is_strong}"), || open(AGENTS), &options).unwrap();
        assert!(found.is_grounded, "{names:?}");
        let held = found.properties.iter().map(|it| it.verdict.holds());
        verdicts.insert(held.collect::<Vec<bool>>());
    }
    // fairness makes a difference
    assert!(verdicts.len() > 1, "{verdicts:?}");
}

/// The specifications below a folder.
pub fn specifications(folder: &std::path::Path, found: &mut Vec<std::path::PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    let mut entries: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            specifications(&path, found);
        } else if path.extension().is_some_and(|it| it == "asm") {
            found.push(path);
        }
    }
}

/// Compares all specifications of a folder that can be opened; returns how many, and how many of them were grounded.
fn compare_folder(folder: &std::path::Path) -> (u32, u32) {
    let mut paths = Vec::new();
    specifications(folder, &mut paths);
    let (mut opened, mut grounded) = (0, 0);
    for path in paths {
        let mut files = asmotion_lang::MemoryFiles::new();
        let neighbours = std::fs::read_dir(path.parent().unwrap()).unwrap().flatten();
        for neighbour in neighbours.map(|entry| entry.path()) {
            let name = neighbour.file_name().unwrap().to_str().unwrap();
            if name.ends_with(".asm") {
                files.add(name, &*std::fs::read_to_string(&neighbour).unwrap());
            }
        }
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let specification = || asmotion_lang::open(&name, &files);
        if !specification().is_ok_and(|it| it.model.main.is_some()) {
            continue;
        }
        let options = Options {
            limits: asmotion_verify::Limits {
                states: Some(3_000),
                ..Default::default()
            },
            ..Options::default()
        };
        let found = compared(
            path.to_str().unwrap(),
            || specification().unwrap(),
            &options,
        );
        opened += 1;
        grounded += u32::from(found.is_some_and(|it| it.is_grounded));
    }
    (opened, grounded)
}

#[test]
fn the_specifications_of_the_repository_have_the_results_of_machines() {
    let specs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../specs");
    let (opened, grounded) = compare_folder(&specs);
    assert!(opened > 10 && grounded > 2, "{opened} {grounded}");
}

#[test]
fn the_shared_specifications_have_the_results_of_machines() {
    for folder in ["specs", "verify"] {
        if let Some(folder) = asmotion_skip::shared(folder) {
            let (opened, grounded) = compare_folder(&folder);
            assert!(opened > 2 && grounded > 1, "{opened} {grounded}");
        }
    }
}

/// Each of the nested calls uses its argument twice, so that the grounded term would have 2^24 parts.
#[test]
fn a_term_that_would_be_copied_too_often_is_left_to_a_machine() {
    let nested = (0..24).fold("n".to_owned(), |term, _| format!("doubled({term})"));
    let text = format!(
        "asm nested
import StandardLibrary
signature:
  domain Number subsetof Integer
  controlled n: Number
  derived doubled: Number -> Number
definitions:
  domain Number = {{0 : 6}}
  function doubled($x in Number) = ($x + $x) mod 7
  main rule r_Main = n := {nested}
default init s0:
  function n = 1
"
    );
    let found = verify(open(&text), &Options::default(), &mut |_| true).unwrap();
    assert!(!found.is_grounded);
    // 2^24 is 1 modulo 7
    assert_eq!(found.states, 1);
}
