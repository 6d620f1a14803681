//! Runs that show a verdict: they can be repeated, and they are shortest.

use crate::models::{FAULTY, LAMP, PHILOSOPHERS};
use crate::{open, verified};
use asmotion_lang::simulate::{Causes, Recording, Simulation, SimulationError};
use asmotion_verify::{Options, PropertyKind, Run, Verdict};

/// Simulates the inputs and choices of a run; returns the simulation, and the fault that ends it.
pub fn simulated(text: &str, run: &Run) -> (Simulation, Option<Box<asmotion_lang::StepFault>>) {
    let machine = open(text).machine().unwrap();
    let recording = Recording::read(&run.traces[0]);
    let steps = recording.steps().len();
    assert_eq!(steps, run.steps.len());
    let mut simulation = Simulation::new(machine, Causes::Recording(recording), 1);
    for _ in 0..steps {
        match simulation.step() {
            Ok(()) => {}
            Err(SimulationError::Fault(fault)) => return (simulation, Some(fault)),
            Err(other) => panic!("{other}"),
        }
    }
    (simulation, None)
}

#[test]
fn a_violated_invariant_is_violated_in_the_simulation() {
    let verification = verified(PHILOSOPHERS, &Options::default());
    let wrong = &verification.properties[1];
    let run = wrong.verdict.run().unwrap();
    // two philosophers take two forks each
    assert_eq!(run.steps.len(), 4);
    let (_, fault) = simulated(PHILOSOPHERS, run);
    let fault = fault.unwrap();
    assert!(
        matches!(
            fault.kind,
            asmotion_lang::FaultKind::Invariant { index: 1, .. }
        ),
        "{fault:?}"
    );
    assert_eq!(fault.step, 4);
}

#[test]
fn a_fault_occurs_in_the_simulation() {
    let verification = verified(FAULTY, &Options::default());
    let run = verification.properties[0].verdict.run().unwrap();
    let (_, fault) = simulated(FAULTY, run);
    assert_eq!(fault.unwrap().step, run.steps.len() as u64);
}

#[test]
fn a_stuck_state_is_reached_by_the_simulation() {
    let verification = verified(PHILOSOPHERS, &Options::default());
    let stuck = verification
        .properties
        .iter()
        .find(|it| it.kind == PropertyKind::NotStuck)
        .unwrap();
    let run = stuck.verdict.run().unwrap();
    assert_eq!(run.steps.len(), 5);
    let without = PHILOSOPHERS.replace(
        "invariant inv_wrong over phase: not (phase(0) = EATS and phase(2) = EATS)",
        "",
    );
    let (simulation, fault) = simulated(&without, run);
    assert!(fault.is_none());
    let machine = simulation.machine();
    let state = asmotion_lang::machine::Naming {
        program: machine.program(),
        reserve: &[],
    };
    let slots = machine.state().slots();
    let values: Vec<String> = slots
        .map(|slot| machine.state().get(slot).show(&state).to_string())
        .collect();
    assert_eq!(
        values.iter().filter(|value| *value == "HOLDS_LEFT").count(),
        5
    );
}

#[test]
fn a_lasso_returns_to_its_beginning() {
    for (text, name) in [(PHILOSOPHERS, "hungry"), (LAMP, "darkens")] {
        let verification = verified(text, &Options::default());
        let property = verification
            .properties
            .iter()
            .find(|it| it.name.as_deref() == Some(name))
            .unwrap();
        let Verdict::Violated(Some(run)) = &property.verdict else {
            panic!("{property:?}");
        };
        let cycle = run.cycle.unwrap();
        assert!(cycle < run.steps.len(), "{run:?}");
        // applies the updates to the initial values, and compares the state before and after the cycle
        let mut state: std::collections::BTreeMap<String, String> =
            run.initial.iter().cloned().collect();
        let mut before = state.clone();
        for (index, step) in run.steps.iter().enumerate() {
            if index == cycle {
                before = state.clone();
            }
            for update in &step.updates {
                assert_eq!(state.get(&update.location), Some(&update.before), "{name}");
                state.insert(update.location.clone(), update.after.clone());
            }
        }
        assert_eq!(state, before, "{name}");
    }
}

#[test]
fn equal_verifications_give_equal_runs() {
    let traces = || {
        let verification = verified(PHILOSOPHERS, &Options::default());
        let properties = verification.properties.into_iter();
        let runs = properties.map(|it| it.verdict.run().map(|run| run.traces.clone()));
        runs.collect::<Vec<Option<Vec<String>>>>()
    };
    assert_eq!(traces(), traces());
}
