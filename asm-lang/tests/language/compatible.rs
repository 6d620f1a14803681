//! `--compat asmeta`: the initial values and inputs that only an invariant reads.

use asmotion_lang::simulate::{Recording, Trace};
use asmotion_lang::{FirstChoice, MemoryFiles, ReadOptions};

/// Returns the trace of a specification that replays a recording.
fn replayed(text: &str, recording: &str, compatible: bool) -> String {
    let mut files = MemoryFiles::new();
    files.add("a.asm", text);
    let options = ReadOptions {
        compatible,
        initial: None,
    };
    let opened = asmotion_lang::open_with("a.asm", &files, &options).unwrap();
    let mut machine = opened.machine().unwrap();
    let mut trace = Trace::begin(&machine, "");
    for step in Recording::read(recording).steps() {
        let mut inputs = step.inputs(&machine).unwrap();
        machine.step(&mut inputs, &mut FirstChoice, 0).unwrap();
        trace.step(&machine);
    }
    trace.end(&machine, None)
}

/// Checks that the trace has these lines in this mode.
#[track_caller]
fn keeps(text: &str, recording: &str, compatible: bool, lines: &[&str]) {
    let trace = replayed(text, recording, compatible);
    for line in lines {
        assert!(
            trace.lines().any(|found| found == *line),
            "compatible: {compatible}, no `{line}` in\n{trace}"
        );
    }
}

#[test]
fn a_location_that_only_an_invariant_reads_is_part_of_the_state() {
    let text = "asm a\nimport StandardLibrary\nsignature:\n  controlled p: Boolean\n  controlled q: Integer -> Boolean\n  \
                controlled x: Integer\ndefinitions:\n  invariant over p: not p and not q(3)\n  main rule r_Main = x := 1\n\
                default init s0:\n  function p = false\n  function q($i in Integer) = false\n";
    let recording = "@step 1\n@step 2\n@end\n";
    keeps(text, recording, false, &["S p = false", "S x = 1"]);
    keeps(
        text,
        recording,
        true,
        &["S p = false", "S q(3) = false", "S x = 1"],
    );
}

#[test]
fn an_initial_value_reads_the_inputs_of_the_first_step() {
    let text = "asm a\nimport StandardLibrary\nsignature:\n  monitored mon: Boolean\n  controlled foo: Boolean\n  \
                controlled x: Integer\ndefinitions:\n  invariant over foo: foo\n  main rule r_Main = x := 1\n\
                default init s0:\n  function foo = mon\n";
    let recording = "@step 1\nM mon = true\n@step 2\n@end\n";
    let lines = ["M mon = true", "S foo = true", "S x = 1"];
    keeps(text, recording, false, &lines);
    keeps(text, recording, true, &lines);
}
