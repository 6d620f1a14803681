//! Native code and closures execute the same steps and reach the same states.

#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use asmotion_lang::simulate::{Random, Seeded, Trace};
use asmotion_lang::{BackEnd, Machine, MemoryFiles, Specification};
use std::path::Path;

/// Number of steps that are compared.
const STEPS: i64 = 30;

/// Number of faults after which a run is abandoned, as the machine makes no progress.
const FAULTS: usize = 2;

fn open(name: &str, text: &str) -> Option<Specification> {
    let mut files = MemoryFiles::new();
    files.add(name, text);
    asmotion_lang::open(name, &files).ok()
}

/// Returns the trace of each step, followed by the state after it.
fn run(specification: &Specification, mut machine: Machine) -> Vec<String> {
    let mut inputs = Random::new(specification.program.clone(), &machine, 5);
    let mut choices = Seeded::new(5);
    let mut faults = 0;
    let mut done = Vec::new();
    for now in 0..STEPS {
        let result = machine
            .step(&mut inputs, &mut choices, now * 100_000_000)
            .map(|_| ());
        let mut trace = Trace::default();
        match &result {
            Ok(()) => trace.step(&machine),
            Err(fault) => trace.fault(&machine, fault),
        }
        faults += usize::from(result.is_err());
        let text = trace.end(&machine, result.err().as_deref());
        done.push(format!("{text}\n{:?}", machine.snapshot()));
        if faults == FAULTS {
            break;
        }
    }
    done
}

#[test]
fn both_back_ends_lead_to_the_same_states() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut compared = 0;
    for folder in ["tests/language/semantics", "benches/machines", "specs"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        for path in entries.map(|entry| entry.unwrap().path()) {
            if path.extension().is_none_or(|end| end != "asm") {
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let text = std::fs::read_to_string(&path).unwrap();
            let Some(specification) = open(&name, &text) else {
                continue;
            };
            let Ok(mut closures) = specification.machine() else {
                continue;
            };
            let mut native = closures.clone();
            closures.set_back_end(BackEnd::Closures).unwrap();
            if specification.program.main.is_none() {
                continue;
            }
            native.set_back_end(BackEnd::Native).unwrap();
            assert_eq!(native.back_end(), BackEnd::Native, "in {name}");
            let (closures, native) = (run(&specification, closures), run(&specification, native));
            for (step, (closures, native)) in closures.iter().zip(&native).enumerate() {
                assert_eq!(native, closures, "in {name}, step {}", step + 1);
            }
            assert_eq!(native.len(), closures.len(), "in {name}");
            compared += 1;
        }
    }
    assert!(compared > 90, "only {compared} programs ran");
}
