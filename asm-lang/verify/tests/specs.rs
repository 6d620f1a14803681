//! The specifications of the repository: their properties hold, and notice changes.

use crate::systems::changed;
use asmotion_lang::{MemoryFiles, Specification};
use asmotion_verify::{Options, SystemSpecification, Verification, mutants, verify};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Specifications with their properties, which are verified alone.
const VERIFIED: &[&str] = &[
    "allocation/allocation.asm",
    "estop/estop.asm",
    "navigation/navigate.asm",
    "patrol/patrol.asm",
    "recovery/recovery.asm",
    "youbot/youbot.asm",
];

/// The others, with the reason for which they are not in the list.
const OTHERS: &[(&str, Reason)] = &[
    ("allocation/robot.asm", Reason::WithoutProperties),
    ("allocation/robot_protocol.asm", Reason::WithoutProperties),
    // stores the angle of the camera, a Real: verified with the protocols of its composite, where a mutant violates a property
    // (`composites` of asmotion-verification)
    ("ball_tracker/ball_tracker.asm", Reason::Refused("M001")),
    ("ball_tracker/camera.asm", Reason::WithoutProperties),
    (
        "ball_tracker/camera_protocol.asm",
        Reason::WithoutProperties,
    ),
    // computes with `offset`, a Real; states no properties
    ("ball_tracker/tracker.asm", Reason::Refused("M001")),
    (
        "ball_tracker/tracker_protocol.asm",
        Reason::WithoutProperties,
    ),
    ("courier/Dispatch.asm", Reason::Module),
    // receives messages: verified together with the dispatcher below
    ("courier/courier.asm", Reason::Refused("M005")),
    ("courier/dispatcher.asm", Reason::WithoutProperties),
    ("nav2/navigate_to_pose.asm", Reason::Large),
    ("nav2/servers.asm", Reason::WithoutProperties),
    ("recovery/service.asm", Reason::WithoutProperties),
    ("youbot/driver_protocol.asm", Reason::WithoutProperties),
];

/// Properties that no mutant violates, with the reason.
const UNNOTICED: &[(&str, &str, &str)] = &[
    (
        "navigation/navigate.asm",
        "ag(command = FOLLOW implies mode = FOLLOWING)",
        "one macro gives the command and enters the mode",
    ),
    (
        "navigation/navigate.asm",
        "tries <= maxTries",
        "the bound is that of the domain, so that a step beyond it fails",
    ),
    (
        "youbot/youbot.asm",
        "ag((mode = BUSY and goal) implies ax(not solve))",
        "no mutant changes the value of an update that is a condition",
    ),
];

/// The reason for which a specification is not verified alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    /// It states no properties: it is the environment of another one, or part of a composite with properties elsewhere.
    WithoutProperties,
    /// It has no main rule.
    Module,
    /// The verification is refused with this code.
    Refused(&'static str),
    /// The verification of all its mutants takes minutes: the test below has some of them.
    Large,
}

/// Opens a specification from a folder, with another text for its file if one is given.
fn open(folder: &Path, file: &str, text: Option<String>) -> Option<Specification> {
    let mut files = MemoryFiles::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|it| it == "asm") {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            files.add(&name, std::fs::read_to_string(&path).unwrap());
        }
    }
    if let Some(text) = text {
        files.add(file, text);
    }
    asmotion_lang::open(file, &files).ok()
}

/// Names of the properties that hold, without those that every specification should have.
fn holding(verification: &Verification) -> BTreeSet<String> {
    let own = verification
        .properties
        .iter()
        .filter(|it| it.place.is_some());
    let own = own.filter(|it| it.verdict.holds());
    own.map(|it| it.text.clone()).collect()
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../specs")
}

#[test]
fn every_specification_is_verified_or_has_a_reason() {
    let mut found = BTreeSet::new();
    for folder in std::fs::read_dir(folder()).unwrap() {
        let folder = folder.unwrap().path();
        for file in folder
            .is_dir()
            .then(|| std::fs::read_dir(&folder).unwrap())
            .into_iter()
            .flatten()
        {
            let file = file.unwrap().path();
            if file.extension().is_some_and(|it| it == "asm") {
                let (folder, file) = (folder.file_name().unwrap(), file.file_name().unwrap());
                found.insert(format!("{}/{}", folder.display(), file.display()));
            }
        }
    }
    let listed = VERIFIED.iter().chain(OTHERS.iter().map(|(path, _)| path));
    let listed: BTreeSet<String> = listed.map(ToString::to_string).collect();
    assert_eq!(found, listed);
    let mut wrong = Vec::new();
    for (path, reason) in OTHERS {
        let (name, file) = path.split_once('/').unwrap();
        let specification = open(&folder().join(name), file, None).unwrap();
        let model = &specification.model;
        let is_module = model.main.is_none();
        let has_properties = !(model.invariants.is_empty() && model.properties.is_empty());
        let limited = Options {
            limits: asmotion_verify::Limits {
                states: Some(2000),
                ..Default::default()
            },
            ..Options::default()
        };
        let result = (!is_module).then(|| verify(specification, &limited, &mut |_| true));
        let refused = result.and_then(Result::err);
        let refused = refused.and_then(|it| it.report.diagnostics.first().map(|it| it.code.name));
        let is_so = match reason {
            Reason::Module => is_module,
            Reason::WithoutProperties => !is_module && !has_properties,
            Reason::Refused(code) => refused == Some(code),
            Reason::Large => !is_module && has_properties && refused.is_none(),
        };
        if !is_so {
            wrong.push(format!("{path}: {reason:?}, {has_properties}, {refused:?}"));
        }
    }
    assert_eq!(wrong, [""; 0]);
}

#[test]
fn every_property_holds_and_notices_a_mutant() {
    let mut unnoticed = Vec::new();
    for path in VERIFIED {
        let (name, file) = path.split_once('/').unwrap();
        let folder = folder().join(name);
        let original = open(&folder, file, None).unwrap();
        let mutants = mutants(&original);
        assert!(mutants.len() > 3, "{file}");
        let verification = verify(original, &Options::default(), &mut |_| true).unwrap();
        assert_eq!(verification.incomplete, None, "{path}");
        let all = verification.properties.iter();
        let violated = all.filter(|it| it.verdict.is_violated()).map(|it| &it.text);
        assert_eq!(
            violated.collect::<Vec<_>>(),
            Vec::<&String>::new(),
            "{path}"
        );
        let mut waiting = holding(&verification);
        let limited = Options {
            limits: asmotion_verify::Limits {
                states: Some(100_000),
                ..Default::default()
            },
            ..Options::default()
        };
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        for mutant in &mutants {
            if waiting.is_empty() {
                break;
            }
            let Some(mutated) = open(&folder, file, mutant.applied_to(&text)) else {
                continue;
            };
            let Ok(verification) = verify(mutated, &limited, &mut |_| true) else {
                continue;
            };
            for property in verification
                .properties
                .iter()
                .filter(|it| it.verdict.is_violated())
            {
                waiting.remove(&property.text);
            }
        }
        unnoticed.extend(waiting.into_iter().map(|it| (path.to_string(), it)));
    }
    let expected = UNNOTICED.iter().map(|(path, property, reason)| {
        assert!(!reason.is_empty());
        (path.to_string(), property.to_string())
    });
    assert_eq!(unnoticed, expected.collect::<Vec<_>>());
}

/// Mistakes in navigate_to_pose.asm: the text, what replaces it, and a property that notices it.
const MISTAKES: &[(&str, &str, &str)] = &[
    (
        "if estop or cancelArrived then",
        "if cancelArrived then",
        "(estop or cancelArrived) implies",
    ),
    (
        "if plannerRests and controllerRests and behaviourRests then",
        "if plannerRests and behaviourRests then",
        "followed = NOTHING) implies ax(behaviour != WORKING)",
    ),
    (
        "else if planned = HOPELESS or followed = HOPELESS then",
        "else if followed = HOPELESS then",
        "planned = HOPELESS) implies",
    ),
    (
        "case STOPPING: r_stop[after]",
        "case STOPPING: skip",
        "mode = STOPPING and plannerRests",
    ),
    (
        "r_stop[AT_GOAL]",
        "r_stop[GAVE_UP]",
        "ag(ef(mode = AT_GOAL))",
    ),
];

#[test]
fn a_coordinator_of_nav2_holds_and_notices_mistakes() {
    let folder = folder().join("nav2");
    let file = "navigate_to_pose.asm";
    let text = std::fs::read_to_string(folder.join(file)).unwrap();
    // fewer recoveries, which reach the same control states
    let text = text
        .replace("domain Count = {0 : 6}", "domain Count = {0 : 3}")
        .replace("maxRecoveries = 6", "maxRecoveries = 1");
    let violated = |text: String| {
        let specification = open(&folder, file, Some(text)).unwrap();
        let verification = verify(specification, &Options::default(), &mut |_| true).unwrap();
        assert_eq!(verification.incomplete, None);
        let properties = verification.properties.into_iter();
        let violated = properties.filter(|it| it.verdict.is_violated());
        violated.map(|it| it.text).collect::<Vec<_>>()
    };
    assert_eq!(violated(text.clone()), [""; 0]);
    for (right, wrong, property) in MISTAKES {
        assert!(text.contains(right), "{right}");
        let found = violated(text.replace(right, wrong));
        assert!(
            found.iter().any(|it| it.contains(property)),
            "{wrong}: {found:?}"
        );
    }
}

/// The properties that specifications of case studies state hold, and a mutant of each violates one of them.
#[test]
fn properties_of_case_studies_hold_and_notice_a_mutant() {
    let Some(folder) = asmotion_skip::shared("specs") else {
        return;
    };
    let entries = std::fs::read_dir(&folder).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|it| it.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|it| it == "asm"));
    files.sort();
    assert!(files.len() > 5, "{files:?}");
    for path in files {
        let file = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).unwrap();
        let original = open(&folder, &file, None).unwrap();
        let mutants = mutants(&original);
        let verification = verify(original, &Options::default(), &mut |_| true).unwrap();
        let stated = verification.properties.iter();
        let stated = stated.filter(|it| it.place.is_some()).count();
        let holding = holding(&verification);
        assert!(stated > 2, "{file}");
        assert_eq!(holding.len(), stated, "{file}");
        let is_noticed = mutants.iter().any(|mutant| {
            let mutated = mutant.applied_to(&text);
            let mutated = open(&folder, &file, mutated);
            let found = mutated.map(|it| verify(it, &Options::default(), &mut |_| true));
            let Some(Ok(found)) = found else {
                return false;
            };
            let mut violated = found.properties.iter();
            violated.any(|it| it.verdict.is_violated() && holding.contains(&it.text))
        });
        assert!(is_noticed, "{file}");
    }
}

/// The courier's property holds together with the dispatcher, as far as its counters are explored, and notices a mutant.
#[test]
fn the_courier_with_its_dispatcher_notices_a_mutant() {
    let options = Options {
        limits: asmotion_verify::Limits {
            states: Some(3000),
            ..Default::default()
        },
        ..Options::default()
    };
    let verdict = |change| {
        let system = SystemSpecification {
            machines: vec![
                changed("courier", "courier", "courier", change),
                changed("courier", "dispatcher", "dispatcher", ("", "")),
            ],
            ..SystemSpecification::default()
        };
        let found = crate::verified_system(system, &options);
        crate::verdict_of(&found, "jobs >= 0")
    };
    assert_eq!(verdict(("", "")), "unknown");
    let mutant = ("jobs := jobs + 1", "jobs := jobs - 1");
    assert_eq!(verdict(mutant), "violated");
}
