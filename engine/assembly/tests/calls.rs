//! Versions of a running specification that call other operations (C18).

use asmotion_assembly::reconfigure::{Version, changes};
use asmotion_component::Span;
use asmotion_lang::MemoryFiles;
use asmotion_runtime::{Log, Run};

use crate::replacement::{BRAIN, COMPOSITE, apply, replaced, start, status, version};

/// The literals of all versions, so that each can continue in the state of another.
const LITERALS: &[(&str, &str)] = &[
    ("{NOACT | ASK}", "{NOACT | ASK | HALVE | OTHER}"),
    (
        "{NOEV | ANSWER | FAILED}",
        "{NOEV | ANSWER | FAILED | HALVED | DOUBLED}",
    ),
];

/// Asks for the half of a number in place of its double, and then another service for a double.
const FURTHER: &[(&str, &str)] = &[
    (
        "\tcontrolled mode",
        "\tcontrolled last: Ev\n\tcontrolled mode",
    ),
    (
        "\t\t\tif ev = ANSWER",
        "\t\t\tif ev = HALVED or ev = DOUBLED or ev = FAILED then last := ev endif\n\t\t\tif ev = HALVED then command := OTHER endif\n\t\t\tif ev = ANSWER",
    ),
    (
        "number = 1 then command := ASK",
        "last = NOEV and command != HALVE then command := HALVE",
    ),
    ("\tfunction mode", "\tfunction last = NOEV\n\tfunction mode"),
];

const OTHER_CALLS: &[(&str, &str)] = &[
    (
        "references = { sums = \"test/Arithmetic\" }",
        "references = { others = \"test/Arithmetic\", sums = \"test/Arithmetic\" }",
    ),
    (
        "[components.Brain.bind.out.command]",
        "[components.Brain.bind.out.command]\n\
        OTHER = { call = \"others.double\", with = { n = 5 }, ok = \"DOUBLED\", failed = \"FAILED\", event = \"ev\" }\n\
        HALVE = { call = \"sums.halve\", with = { n = 8 }, ok = \"HALVED\", failed = \"FAILED\", event = \"ev\" }",
    ),
];

const SECOND: &str = "
[components.Second]
implementation = { rust = \"test::Slow\" }
task = { period_ms = 50 }
[[wires]]
reference = \"Brain.others\"
service = \"Second.sums\"
timeout_ms = 5000
";

fn first() -> (MemoryFiles, Version) {
    version(COMPOSITE, &replaced(BRAIN, LITERALS))
}

fn further() -> (MemoryFiles, Version) {
    let composite = replaced(COMPOSITE, OTHER_CALLS) + SECOND;
    version(&composite, &replaced(&replaced(BRAIN, LITERALS), FURTHER))
}

/// Runs a system until it has called its service, changes it to a version with other calls, and then to the first version again.
fn calls_others(run: &mut dyn Run, log: &Log, first: &Version) {
    let (_, further) = further();
    run.run_for(500.ms());
    assert_eq!(status(run, "Brain").calls, ["sums.double"]);
    let planned = changes(first, &further, run).expect("no new start is needed");
    let refused = run.change(&planned).expect_err("a call is under way");
    assert_eq!(
        refused.to_string(),
        "`Brain` cannot be replaced: a call of `sums.double` is under way that the new version does not continue: try again \
         when it has ended"
    );
    run.run_for(1500.ms());
    assert!(status(run, "Brain").calls.is_empty());
    let words: Vec<_> = planned.iter().map(ToString::to_string).collect();
    assert_eq!(
        words,
        [
            "`Brain.sums` is unwired from `Slow.sums`",
            "`Second` is added and runs `test::Slow`",
            "`Brain` runs another version of `brain.asm`",
            "`Brain.sums` is wired to `Slow.sums`",
            "`Brain.others` is wired to `Second.sums`",
        ]
    );
    apply(run, first, &further).expect("a version with other calls");
    run.run_for(2.s());
    assert_eq!(status(run, "Brain").state["last"], "DOUBLED");
    for reply in ["sums.halve", "others.double"] {
        assert!(!log.lines_with(reply).is_empty(), "{reply}");
    }
    apply(run, &further, first).expect("the first version");
    let step = status(run, "Brain").step;
    run.run_for(500.ms());
    assert!(status(run, "Brain").step > step);
    assert_eq!(run.components().len(), 4);
    apply(run, first, &further).expect("the other version again");
    run.run_for(3.s());
    assert_eq!(status(run, "Brain").state["last"], "DOUBLED", "anew");
    let lines = log.lines_with("FAILED");
    assert!(lines.is_empty(), "{lines:?}");
}

#[test]
fn c18_a_new_version_calls_other_operations_through_other_references() {
    let first = first();
    let (system, log) = start(&first);
    calls_others(&mut system.simulate(), &log, &first.1);
    let (system, log) = start(&first);
    let mut run = system.live();
    calls_others(&mut run, &log, &first.1);
    run.stop();
}

#[test]
fn c18_a_version_with_other_calls_is_refused_as_a_whole() {
    let first = first();
    let (system, log) = start(&first);
    let mut run = system.simulate();
    run.run_for(2.s());
    let before = run.declaration("Brain");
    let (_, further) = further();
    let mut planned = changes(&first.1, &further, &run).expect("no new start is needed");
    let last = planned.last().cloned().expect("a change");
    // the same wire once more
    planned.push(last);
    let refused = run.change(&planned).expect_err("one change is impossible");
    assert!(refused.to_string().contains("already"), "{refused}");
    assert_eq!(run.declaration("Brain"), before);
    assert_eq!(run.components(), ["Counter", "Slow", "Brain", "Echo"]);
    run.run_for(500.ms());
    assert!(log.lines_with("sums.halve").is_empty());
    // what was refused has left nothing behind
    apply(&mut run, &first.1, &further).expect("the same without it");
    run.run_for(2.s());
    assert_eq!(status(&mut run, "Brain").state["last"], "DOUBLED");
}
