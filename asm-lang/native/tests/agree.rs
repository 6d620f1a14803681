//! Native code and closures execute the same steps and reach the same states.

#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use asmotion_lang::ir::Program;
use asmotion_lang::machine::back_end::{DirectRule, NativeCompiler, NativeRule, NoNativeCode};
use asmotion_lang::simulate::{Random, Seeded, Trace};
use asmotion_lang::{BackEnd, Machine, MemoryFiles, Specification, Value};
use asmotion_native::Cranelift;
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

/// Returns the programs of the repository that have a main rule and an initial state.
fn programs() -> Vec<(String, Specification)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut programs = Vec::new();
    for folder in ["tests/language/semantics", "benches/machines", "specs"] {
        let entries = std::fs::read_dir(root.join(folder)).unwrap();
        for path in entries.map(|entry| entry.unwrap().path()) {
            if path.extension().is_none_or(|end| end != "asm") {
                continue;
            }
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let text = std::fs::read_to_string(&path).unwrap();
            let opened = open(&name, &text);
            if let Some(specification) = opened
                && specification.program.main.is_some()
                && specification.machine().is_ok()
            {
                programs.push((name, specification));
            }
        }
    }
    assert!(programs.len() > 90, "only {} programs", programs.len());
    programs
}

/// The implementations of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Closures,
    /// Native code with detours to closures.
    Detours,
    /// Native code for whole steps, where the program permits it.
    Direct,
}

/// Compiles no direct rules.
#[derive(Debug)]
struct OnlyDetours;

impl NativeCompiler for OnlyDetours {
    fn compile(&self, program: &Program) -> Result<Box<dyn NativeRule>, NoNativeCode> {
        Cranelift.compile(program)
    }

    fn compile_direct(&self, _: &Program, _: &[Value]) -> Option<Box<dyn DirectRule>> {
        None
    }
}

fn machine(name: &str, specification: &Specification, way: Way) -> Machine {
    let mut machine = specification.machine().unwrap();
    let back_end = match way {
        Way::Closures => BackEnd::Closures,
        Way::Detours => {
            machine.set_native_compiler(&OnlyDetours);
            BackEnd::Native
        }
        Way::Direct => BackEnd::Native,
    };
    machine.set_back_end(back_end).unwrap();
    assert_eq!(machine.back_end(), back_end, "in {name}");
    machine
}

/// Returns the trace of each step, followed by the state after it and the coverage so far.
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
        let (state, counts) = (machine.snapshot(), machine.counts());
        done.push(format!("{text}\n{state:?}\n{counts:?}"));
        if faults == FAULTS {
            break;
        }
    }
    done
}

fn assert_same_runs(name: &str, specification: &Specification) {
    let closures = run(specification, machine(name, specification, Way::Closures));
    for way in [Way::Detours, Way::Direct] {
        let native = run(specification, machine(name, specification, way));
        for (step, (closures, native)) in closures.iter().zip(&native).enumerate() {
            assert_eq!(native, closures, "{way:?} in {name}, step {}", step + 1);
        }
        assert_eq!(native.len(), closures.len(), "{way:?} in {name}");
    }
}

#[test]
fn direct_rules_cover_the_machines_of_the_benchmark() {
    let mut direct = Vec::new();
    for (name, specification) in programs() {
        let machine = specification.machine().unwrap();
        let rule = Cranelift.compile_direct(&specification.program, machine.slots());
        if rule.is_some() {
            direct.push(name);
        }
    }
    for name in [
        "counter",
        "phil50",
        "life32",
        "sort64",
        "agents100",
        "coord",
    ] {
        assert!(direct.contains(&format!("{name}.asm")), "{direct:?}");
    }
}

#[test]
fn both_back_ends_lead_to_the_same_states() {
    for (name, specification) in programs() {
        assert_same_runs(&name, &specification);
    }
}

#[test]
fn both_back_ends_count_the_same_coverage() {
    for (name, mut specification) in programs() {
        specification.lower_covered().unwrap();
        assert!(!specification.program.counted.is_empty(), "in {name}");
        assert_same_runs(&name, &specification);
    }
}

#[test]
fn an_evaluated_step_has_the_updates_of_the_step_and_changes_nothing() {
    let mut compared = 0;
    for (name, specification) in programs() {
        for way in [Way::Closures, Way::Detours, Way::Direct] {
            let mut machine = machine(&name, &specification, way);
            let mut inputs = Random::new(specification.program.clone(), &machine, 5);
            let mut choices = Seeded::new(5);
            for now in 0..STEPS {
                let mut evaluated = None;
                if machine.can_revert() {
                    let before = machine.snapshot();
                    // twice, because an evaluation must leave no trace that influences the next one
                    for _ in 0..2 {
                        let (mut inputs, mut choices) = (inputs.clone(), choices.clone());
                        let result = machine.evaluate_step(&mut inputs, &mut choices, now);
                        let result = result.map(<[_]>::to_vec);
                        let step = machine.last_step();
                        let record = (
                            step.extended().to_vec(),
                            step.choices().to_vec(),
                            step.printed().to_vec(),
                        );
                        assert_eq!(
                            machine.snapshot().state(),
                            before.state(),
                            "in {name}, step {now}"
                        );
                        assert_eq!(machine.steps(), before.steps(), "in {name}");
                        if let Some(evaluated) = evaluated {
                            assert_eq!(evaluated, (result.clone(), record.clone()), "in {name}");
                        }
                        evaluated = Some((result, record));
                    }
                }
                let number = machine.steps();
                let result = machine
                    .step(&mut inputs, &mut choices, now)
                    .map(|step| step.updates().to_vec());
                if let Some((evaluated, record)) = evaluated {
                    // a violated invariant is a fault of the next state
                    if result.is_ok() || machine.steps() == number {
                        assert_eq!(evaluated, result, "in {name}, step {now}");
                    }
                    let step = machine.last_step();
                    assert_eq!(record.0, step.extended(), "in {name}");
                    assert_eq!(record.1, step.choices(), "in {name}");
                    assert_eq!(record.2, step.printed(), "in {name}");
                    compared += 1;
                }
                if result.is_err() {
                    break;
                }
            }
        }
    }
    assert!(compared > 1_000, "only {compared} steps");
}
