//! Packed states: equal if machines continue in the same way, and sufficient to continue from.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test fails by panicking, and the programs are on the disk"
)]

use asmotion_lang::machine::{PackedState, Snapshot};
use asmotion_lang::simulate::{Random, Seeded, Trace};
use asmotion_lang::{FirstChoice, Machine, MemoryFiles, NoInputs, ReadOptions, Specification};
use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;
use std::path::{Path, PathBuf};

/// Number of steps in a run, and number of steps between snapshots.
const STEPS: u64 = 12;
const EVERY: u64 = 3;

/// A machine with the sources of its inputs and choices.
#[derive(Clone)]
struct Going {
    machine: Machine,
    inputs: Random,
    choices: Seeded,
}

impl Going {
    fn new(specification: &Specification, seed: u64) -> Option<Self> {
        let machine = specification.machine().ok()?;
        let inputs = Random::new(specification.program.clone(), &machine, seed);
        Some(Self {
            machine,
            inputs,
            choices: Seeded::new(seed),
        })
    }

    /// Executes a step and returns its part of the trace.
    fn step(&mut self) -> String {
        let now_ns = self.machine.steps() as i64 * 100_000_000;
        let mut trace = Trace::default();
        let result = self
            .machine
            .step(&mut self.inputs, &mut self.choices, now_ns)
            .map(|_| ());
        match &result {
            Ok(()) => trace.step(&self.machine),
            Err(fault) => trace.fault(&self.machine, fault),
        }
        trace.end(&self.machine, result.err().as_deref())
    }
}

fn open(name: &str, text: &str, options: &ReadOptions) -> Option<Specification> {
    let mut files = MemoryFiles::new();
    files.add(name, text);
    asmotion_lang::open_with(name, &files, options).ok()
}

fn opened(text: &str) -> Specification {
    open("a.asm", text, &ReadOptions::default()).unwrap_or_else(|| panic!("does not open: {text}"))
}

/// Returns the self-contained programs of the repository that have a main rule.
fn programs() -> Vec<(String, Specification)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut paths: Vec<PathBuf> = Vec::new();
    for folder in ["tests/language/semantics", "benches/machines", "specs"] {
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            paths.push(entry.unwrap().path());
        }
    }
    paths.sort();
    let compatible = ReadOptions {
        compatible: true,
        ..ReadOptions::default()
    };
    let mut programs = Vec::new();
    for path in paths {
        if path.extension().is_none_or(|end| end != "asm") {
            continue;
        }
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // large programs add nothing, and endless ones take too long
        let is_large = ["life128.asm", "sort512.asm", "bfs1000.asm"].contains(&name.as_str());
        if is_large || name.contains("endless") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for (mode, options) in [
            ("", &ReadOptions::default()),
            (" (compatible)", &compatible),
        ] {
            let specification = open(&name, &text, options);
            if let Some(specification) = specification.filter(|it| it.program.main.is_some()) {
                programs.push((format!("{name}{mode}"), specification));
            }
        }
    }
    assert!(programs.len() > 150, "only {} programs", programs.len());
    programs
}

fn hash(state: &PackedState, by: &RandomState) -> u64 {
    by.hash_one(state)
}

fn assert_same(name: &str, left: &Snapshot, right: &Snapshot, by: &RandomState) {
    assert_eq!(left.state(), right.state(), "in {name}");
    assert_eq!(hash(left.state(), by), hash(right.state(), by), "in {name}");
}

#[test]
fn a_restored_machine_goes_on_with_the_same_trace() {
    let by = RandomState::new();
    let mut restored = 0;
    for (name, specification) in programs() {
        let Some(mut original) = Going::new(&specification, 11) else {
            continue;
        };
        // a machine that has accessed other locations, in another order
        let Some(mut other) = Going::new(&specification, 12) else {
            continue;
        };
        for step in 0..STEPS {
            let _ = other.step();
            if step % EVERY == 0 {
                let snapshot = original.machine.snapshot();
                let mut fresh = Going::new(&specification, 1).unwrap();
                for into in [&mut fresh, &mut other] {
                    let restored = into.machine.restore(&snapshot);
                    assert_eq!(restored, Ok(()), "in {name}");
                    (into.inputs, into.choices) =
                        (original.inputs.clone(), original.choices.clone());
                    assert_same(&name, &into.machine.snapshot(), &snapshot, &by);
                    let mut straight = original.clone();
                    for ahead in 0..EVERY + 1 {
                        let expected = straight.step();
                        assert_eq!(into.step(), expected, "in {name}, {step} + {ahead}");
                        assert_same(
                            &name,
                            &into.machine.snapshot(),
                            &straight.machine.snapshot(),
                            &by,
                        );
                    }
                }
                restored += 1;
            }
            // a machine that fails makes no further progress
            let before = original.machine.steps();
            let _ = original.step();
            if original.machine.steps() == before {
                break;
            }
        }
    }
    assert!(restored > 300, "only {restored} snapshots");
}

#[test]
fn a_state_that_comes_back_is_the_same_one() {
    let text = "asm wheel
import StandardLibrary
signature:
  domain Place subsetof Integer
  controlled at: Place
  controlled seen: Integer -> Integer
definitions:
  domain Place = {0 : 2}
  main rule r_Main = par
    at := (at + 1) mod 3
    if at = 2 then seen(100) := undef else seen(100) := at endif
  endpar
default init s0:
  function at = 0
";
    let specification = opened(text);
    let mut machine = specification.machine().unwrap();
    let by = RandomState::new();
    let mut states = vec![machine.snapshot()];
    for _ in 0..6 {
        machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
        states.push(machine.snapshot());
    }
    // `seen(100)` was accessed in the meantime, and has its initial value again
    for (early, late) in [(0, 3), (1, 4), (2, 5), (3, 6)] {
        assert_same("wheel", &states[early], &states[late], &by);
        assert!(states[early].steps() < states[late].steps());
    }
    assert_ne!(states[0].state(), states[1].state());
    assert_ne!(states[1].state(), states[2].state());
}

#[test]
fn the_order_in_which_locations_are_met_does_not_matter() {
    let text = |first: &str, second: &str| {
        format!(
            "asm order
import StandardLibrary
signature:
  controlled f: Integer -> Integer
  controlled n: Integer
definitions:
  main rule r_Main = seq
    {first}
    {second}
    n := 7
  endseq
"
        )
    };
    let (one, two) = ("f(1000) := 1", "f(-2000) := 2");
    let by = RandomState::new();
    let after = |text: String| {
        let mut machine = opened(&text).machine().unwrap();
        machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
        machine.snapshot()
    };
    assert_same("order", &after(text(one, two)), &after(text(two, one)), &by);
    assert_ne!(after(text(one, two)).state(), after(text(one, one)).state());
}

#[test]
fn what_the_environment_said_is_no_part_of_a_state_unless_it_is_kept() {
    let text = "asm inputs
import StandardLibrary
signature:
  monitored asked: Integer
  shared kept: Integer
  controlled n: Integer
definitions:
  main rule r_Main = if asked > kept then skip endif
default init s0:
  function kept = 0
";
    let specification = opened(text);
    let by = RandomState::new();
    let after = |asked: i64, kept: i64| {
        let mut machine = specification.machine().unwrap();
        let values = [("asked", asked), ("kept", kept)];
        for (name, value) in values {
            let function = specification.function(name, 0).unwrap();
            let value = asmotion_lang::Value::Int(value);
            machine.set(function, &[], value).unwrap();
        }
        machine.snapshot()
    };
    assert_same("inputs", &after(1, 5), &after(2, 5), &by);
    assert_ne!(after(1, 5).state(), after(1, 6).state());
}

#[test]
fn a_state_takes_little_memory() {
    let text = include_str!("../../../benches/machines/S1_navigate.asm");
    let specification = opened(text);
    let machine = specification.machine().unwrap();
    let slots = machine.state().slot_count();
    let state = machine.snapshot().into_state();
    let bytes = state.as_bytes().len() + size_of::<PackedState>();
    // in the store, each slot takes 16 bytes
    assert!(bytes < 16 * slots / 4, "{bytes} bytes for {slots} slots");

    // a single slot of one bit, to measure the overhead
    let text = "asm flag
import StandardLibrary
signature:
  controlled on: Boolean
definitions:
  main rule r_Main = on := not on
default init s0:
  function on = false
";
    let machine = opened(text).machine().unwrap();
    let bytes = machine.snapshot().into_state().as_bytes().len() + size_of::<PackedState>();
    assert!(bytes <= 32, "{bytes} bytes for one flag");
}

#[test]
fn a_snapshot_of_another_program_is_refused_or_at_least_harmless() {
    let programs = programs();
    let mut refused = 0;
    for pair in programs.windows(2) {
        let [(_, one), (name, other)] = pair else {
            continue;
        };
        let (Ok(machine), Ok(mut into)) = (one.machine(), other.machine()) else {
            continue;
        };
        let before = into.snapshot();
        if into.restore(&machine.snapshot()).is_err() {
            refused += 1;
            assert_eq!(into.snapshot(), before, "in {name}");
        }
    }
    assert!(refused > 20, "only {refused} were refused");
}
