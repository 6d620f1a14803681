//! Random simulations take only steps that verification considers: constraints (`INVAR`) restrict both in the same way.

use crate::{naive, open, verdict_of, verified};
use asmotion_lang::simulate::{Causes, Random, Simulation, SimulationError, location};
use asmotion_lang::{FaultKind, Machine, StepFault};
use asmotion_verify::Options;
use std::collections::BTreeSet;

fn simulation(text: &str, seed: u64) -> Simulation {
    let specification = open(text);
    let machine = specification.machine().unwrap();
    let inputs = Random::new(specification.program.clone(), &machine, seed);
    Simulation::new(machine, Causes::Random(Box::new(inputs)), seed)
}

/// A condition that only the current state satisfies.
fn state(machine: &Machine) -> String {
    let (state, program) = (machine.state(), machine.program());
    let is_controlled = |slot: &u32| {
        let function = state.function(program, *slot).unwrap();
        program.functions[function.0 as usize].kind == asmotion_lang::ir::FunctionKind::Controlled
    };
    let naming = machine.naming();
    let slots = state.slots().filter(is_controlled);
    let equations = slots.map(|slot| {
        let value = state.get(slot).show(&naming);
        format!("{} = {value}", location(machine, slot))
    });
    equations.collect::<Vec<_>>().join(" and ")
}

/// The inputs of the last step as a condition.
fn inputs(machine: &Machine) -> String {
    let naming = machine.naming();
    let inputs = machine.last_step().inputs().iter().map(|input| {
        let value = input.value.show(&naming);
        format!(" and {} = {value}", location(machine, input.slot))
    });
    inputs.collect()
}

/// The states and inputs of a random simulation, and the fault that ended it.
fn simulated(text: &str, seed: u64) -> (BTreeSet<String>, String, Option<Box<StepFault>>) {
    let mut simulation = simulation(text, seed);
    let mut cases = BTreeSet::new();
    for _ in 0..25 {
        let before = state(simulation.machine());
        match simulation.step() {
            Ok(()) => {
                cases.insert(before + &inputs(simulation.machine()));
            }
            Err(SimulationError::Fault(fault)) => return (cases, before, Some(fault)),
            Err(other) => panic!("{other}"),
        }
    }
    let last = state(simulation.machine());
    (cases, last, None)
}

#[test]
fn every_step_is_one_that_verification_considers() {
    let mut random = naive::Random(7001);
    let (mut refused_at_once, mut ended, mut constrained) = (0, 0, 0);
    for seed in 0..150 {
        let mut constraint = format!("{} or {}", random.condition(2), random.condition(1));
        if seed % 2 == 0 {
            constraint = format!("left = right or {constraint}");
        }
        // each reads an input: otherwise a run does not keep to it
        let constraints = format!(
            "  INVAR {constraint} or left and not left\n  INVAR not (left and q) or n = 3\n  main rule"
        );
        let text = random.specification().replace("  main rule", &constraints);
        let text = text.replace(
            "import StandardLibrary\n",
            "import StandardLibrary\nimport CTLLibrary\n",
        );
        let (cases, last, fault) = simulated(&text, seed);
        let is_without_inputs = match fault.map(|fault| fault.kind) {
            Some(FaultKind::Invariant { .. }) => panic!("{text}"),
            Some(FaultKind::NoInputs { is_exhaustive, .. }) => {
                assert!(is_exhaustive, "{text}");
                true
            }
            _ => false,
        };
        let options = Options {
            possible: cases.iter().cloned().chain([last.clone()]).collect(),
            ..Options::default()
        };
        if cases.is_empty() && is_without_inputs {
            let refusal = asmotion_verify::verify(open(&text), &options, &mut |_| true);
            assert!(
                crate::refused(&refusal.unwrap_err()).contains("M006"),
                "{text}"
            );
            refused_at_once += 1;
            continue;
        }
        let verification = verified(&text, &options);
        constrained += u64::from(verification.excluded > 0);
        for case in &cases {
            assert_eq!(verdict_of(&verification, case), "holds", "{case}\n{text}");
        }
        if is_without_inputs {
            ended += 1;
            assert_eq!(
                verdict_of(&verification, &last),
                "violated",
                "{last}\n{text}"
            );
        }
    }
    assert!(
        constrained > 50 && ended > 0 && refused_at_once > 0,
        "{constrained} {ended} {refused_at_once}"
    );
}

/// A specification with inputs and a constraint.
fn constrained(inputs: &str, constraint: &str) -> String {
    format!(
        "asm constrained
import StandardLibrary
import CTLLibrary
signature:
  domain Level subsetof Integer
{inputs}
  controlled n: Level
definitions:
  domain Level = {{0 : 1000}}
  INVAR {constraint}
  main rule r_Main = n := (n + 1) mod 1000
default init s0:
  function n = 0
"
    )
}

/// Up to one of a million combinations: draws alone do not find it.
#[test]
fn rare_inputs_are_found_by_trying_values_in_order() {
    let two = "  monitored a: Level\n  monitored b: Level";
    for constraint in ["a = 7 and b = n", "a = 10\n  INVAR b = a", "n + 3 = a"] {
        let mut simulation = simulation(&constrained(two, constraint), 3);
        for _ in 0..5 {
            simulation
                .step()
                .unwrap_or_else(|error| panic!("{constraint}: {error}"));
        }
    }
}

#[test]
fn inputs_of_infinite_domains_are_drawn_until_they_fit() {
    for (input, constraint) in [
        ("  monitored a: Integer", "a = 77"),
        ("  monitored a: Natural", "a > 98"),
        ("  monitored a: Real", "a = 1.25"),
        ("  monitored a: String", "a = \"beta\""),
        ("  monitored a: Prod(Level, Boolean)", "a = (n, true)"),
        ("  monitored a: Seq(Boolean)", "length(a) = 3"),
        ("  monitored a: Level -> Boolean", "a(n) and not a(n + 1)"),
        ("  shared a: Boolean", "a"),
    ] {
        let text = constrained(input, constraint);
        let mut first = simulation(&text, 5);
        let mut second = simulation(&text, 5);
        for _ in 0..5 {
            first
                .step()
                .unwrap_or_else(|error| panic!("{constraint}: {error}"));
            second.step().unwrap();
            let inputs = |it: &Simulation| inputs(it.machine());
            assert_eq!(inputs(&first), inputs(&second), "{constraint}");
        }
    }
}

/// The initial state is made of inputs that satisfy the constraint too.
#[test]
fn inputs_of_the_initial_state_are_those_of_the_first_step() {
    let text = constrained("  monitored a: Level", "a >= 990 and a != n + 1")
        .replace("function n = 0", "function n = a");
    for seed in 0..20 {
        let mut simulation = simulation(&text, seed);
        simulation.step().unwrap();
        let machine = simulation.machine();
        let step = machine.last_step();
        let [input] = step.inputs() else {
            panic!("{:?}", step.inputs());
        };
        assert_eq!(step.before(), std::slice::from_ref(&input.value));
    }
}

#[test]
fn values_that_were_not_tried_are_no_proof() {
    let text = constrained("  monitored a: Seq(Level)", "length(a) = 4");
    let fault = simulated(&text, 1).2.unwrap();
    let FaultKind::NoInputs {
        constraints,
        is_exhaustive,
    } = fault.kind
    else {
        panic!("{fault:?}");
    };
    assert_eq!((constraints, is_exhaustive), (vec![0], false));
}
