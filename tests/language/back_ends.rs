//! Closures and native code do the same steps: equal inputs in the same order, equal choices, equal updates with the
//! same origins, equal faults.

use asmotion::DiskLoader;
use asmotion_lang::simulate::{Random, Seeded};
use asmotion_lang::{BackEnd, Machine, Specification};
use std::path::{Path, PathBuf};

/// Number of steps to compare.
const STEPS: u64 = 40;

/// Number of consecutive faults after which a machine is considered stuck.
const FAULTS: usize = 3;

#[test]
fn agree_on_all_programs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut compared = 0;
    for folder in ["tests/language", "benches/machines", "specs"] {
        for file in files(&root.join(folder)) {
            let text = std::fs::read_to_string(&file).unwrap();
            let name = file.file_stem().unwrap().to_string_lossy();
            if let Ok(specification) = super::open(&name, &text) {
                compared += usize::from(agree(&name, &specification));
            }
        }
    }
    assert!(compared > 120, "only {compared} programs ran");
}

#[test]
fn agree_on_the_corpus() {
    let Some(corpus) = asmotion_skip::corpus() else {
        return;
    };
    let mut compared = 0;
    for file in files(&corpus) {
        let path = file.to_string_lossy();
        if let Ok(specification) = asmotion_lang::open(&path, &DiskLoader) {
            compared += usize::from(agree(&path, &specification));
        }
    }
    eprintln!("{compared} specifications compared");
    assert!(compared > 1_000, "only {compared} specifications ran");
}

/// All `.asm` files in a folder and its subfolders, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    let within = |path: PathBuf| {
        if path.is_dir() {
            files(&path)
        } else {
            vec![path]
        }
    };
    let all = entries.into_iter().flat_map(within);
    all.filter(|path| path.extension().is_some_and(|end| end == "asm"))
        .collect()
}

/// Compares the steps of both back ends. Returns whether there were any.
fn agree(name: &str, specification: &Specification) -> bool {
    if specification.program.main.is_none() {
        return false;
    }
    let Ok(mut closures) = specification.machine() else {
        return false;
    };
    let mut native = closures.clone();
    closures.set_back_end(BackEnd::Closures).unwrap();
    native.set_back_end(BackEnd::Native).unwrap();
    assert_eq!(native.back_end(), BackEnd::Native, "in {name}");
    let (closures, native) = (run(specification, closures), run(specification, native));
    for (step, (closures, native)) in closures.iter().zip(&native).enumerate() {
        assert_eq!(native, closures, "in {name}, step {}", step + 1);
    }
    assert_eq!(closures.len(), native.len(), "in {name}");
    true
}

/// The effects of each step, with inputs and choices drawn from the same seed.
fn run(specification: &Specification, mut machine: Machine) -> Vec<String> {
    let mut random = Random::new(specification.program.clone(), &machine, 7);
    let mut seeded = Seeded::new(7);
    let mut done = Vec::new();
    let mut faults = 0;
    for now in 0..STEPS {
        let result = machine.step(&mut random, &mut seeded, now as i64 * 100_000_000);
        let ended = result.map(|_| ());
        let at = |slot| machine.state().location(machine.program(), slot);
        let snapshot = machine.snapshot();
        let step = machine.last_step();
        let inputs = step
            .inputs()
            .iter()
            .map(|input| (at(input.slot), &input.value));
        let updates = step
            .updates()
            .iter()
            .map(|update| (at(update.slot), &update.value, update.origin));
        done.push(format!(
            "{:?}\n{:?}\n{}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}\n{:?}",
            ended
                .as_ref()
                .map_err(|fault| (fault, specification.explain_in(fault, &machine))),
            snapshot,
            step.number(),
            inputs.collect::<Vec<_>>(),
            step.choices(),
            updates.collect::<Vec<_>>(),
            step.before(),
            step.extended(),
            step.printed(),
        ));
        faults += usize::from(ended.is_err());
        if faults >= FAULTS {
            break;
        }
    }
    let locations = machine.state().locations(machine.program());
    let held = locations
        .into_iter()
        .map(|(function, arguments, slot)| (function, arguments, machine.state().get(slot)));
    done.push(format!("{:?}", held.collect::<Vec<_>>()));
    done
}
