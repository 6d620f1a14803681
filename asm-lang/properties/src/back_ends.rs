//! The property of back ends: they execute the same steps.

use crate::generated;
use asmotion_lang::ir::{Program, Rule, RuleNode, Term, TermNode};
use asmotion_lang::machine::back_end::{DirectRule, NativeRule};
use asmotion_lang::machine::{NativeCompiler, NoNativeCode};
use asmotion_lang::simulate::{Random, Seeded};
use asmotion_lang::{BackEnd, Machine, MemoryFiles, Specification, Value};
use asmotion_native::Cranelift;
use std::sync::Arc;

/// Number of steps, successful or not.
const STEPS: i64 = 12;

/// Compiles no direct rules, so that native code has detours to closures.
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

/// The steps of a generated specification are the same in all back ends, from the first one on: by closures, by native code
/// with detours, and by native code for whole steps; with and without coverage counters. A step that is only evaluated has
/// the same updates. They are also the same where locations are kept in another way. Returns `false` if the specification does not open, or has no initial state.
pub fn back_ends(bytes: &[u8]) -> bool {
    let text = generated::specification(bytes);
    let mut files = MemoryFiles::new();
    files.add("generated.asm", text.as_str());
    let Ok(mut specification) = asmotion_lang::open("generated.asm", &files) else {
        return false;
    };
    let seed = bytes
        .iter()
        .fold(0, |sum: u64, byte| sum.rotate_left(5) ^ u64::from(*byte));
    for is_covered in [false, true] {
        if is_covered && specification.lower_covered().is_err() {
            return false;
        }
        let Ok(machine) = specification.machine() else {
            return false;
        };
        let mut closures = machine.clone();
        let _ = closures.set_back_end(BackEnd::Closures);
        let expected = run(&specification, closures, seed);
        if !is_covered {
            differs_nowhere(&specification, &expected, seed, &text);
        }
        let mut detours = machine.clone();
        detours.set_native_compiler(&OnlyDetours);
        // a machine of its own, because clones share compiled code
        let Ok(mut direct) = specification.machine() else {
            return false;
        };
        direct.set_native_compiler(&Cranelift);
        for (name, mut machine) in [("detours", detours), ("direct", direct)] {
            let is_native = machine.set_back_end(BackEnd::Native);
            assert_eq!(is_native, Ok(()), "{text}");
            let done = run(&specification, machine, seed);
            for (step, (done, expected)) in done.iter().zip(&expected).enumerate() {
                assert_eq!(done, expected, "{name}, step {}, of\n{text}", step + 1);
            }
        }
    }
    true
}

/// Compares the steps with those of a machine that interns the locations for which there are lazy slots otherwise, and that
/// has no index for any range.
fn differs_nowhere(specification: &Specification, expected: &[Done], seed: u64, text: &str) {
    let interned = asmotion_lang::ir::lower_with(&specification.model, 1 << 16, 0)
        .ok()
        .and_then(|mut lowered| {
            for routine in &mut lowered.program.routines {
                negate_guards_twice(&mut routine.code);
            }
            Machine::new(Arc::new(lowered.program)).ok()
        });
    assert!(interned.is_some(), "no machine without lazy slots: {text}");
    let Some(mut interned) = interned else {
        return;
    };
    let _ = interned.set_back_end(BackEnd::Closures);
    for (step, (done, expected)) in run(specification, interned, seed)
        .iter()
        .zip(expected)
        .enumerate()
    {
        assert_eq!(
            (&done.shown, &done.message),
            (&expected.shown, &expected.message),
            "interned, step {}, of\n{text}",
            step + 1
        );
    }
}

/// Replaces the guards of ranges by equivalent ones that no index answers.
fn negate_guards_twice(rule: &mut Rule) {
    if let RuleNode::Choose(_, Some(guard), _, _) | RuleNode::Forall(_, Some(guard), _) =
        &mut *rule.node
    {
        for _ in 0..2 {
            let negated = Term {
                node: Box::new(TermNode::Not(guard.clone())),
                ..*guard
            };
            *guard = negated;
        }
    }
    for inner in rule.node.rules_mut() {
        negate_guards_twice(inner);
    }
}

/// The effects of a step.
#[derive(Debug, PartialEq)]
struct Done {
    /// The fault, with numbers of slots.
    fault: String,
    /// The fault as users read it.
    message: String,
    /// Everything else.
    shown: String,
}

/// Returns the effects of each step.
fn run(specification: &Specification, mut machine: Machine, seed: u64) -> Vec<Done> {
    let mut inputs = Random::new(specification.program.clone(), &machine, seed);
    let mut choices = Seeded::new(seed);
    let mut steps = Vec::new();
    for now_ns in 0..STEPS {
        let mut evaluated = None;
        if machine.can_revert() && now_ns % 2 == 0 {
            let before = machine.snapshot();
            let (mut inputs, mut choices) = (inputs.clone(), choices.clone());
            let updates = machine.evaluate_step(&mut inputs, &mut choices, now_ns);
            evaluated = Some(updates.map(<[_]>::to_vec));
            assert_eq!(
                machine.snapshot().state(),
                before.state(),
                "an evaluation changed the state"
            );
        }
        let result = machine.step(&mut inputs, &mut choices, now_ns);
        let result = result.map(|step| step.updates().to_vec());
        if let Some(evaluated) = evaluated {
            assert_eq!(evaluated, result, "an evaluated step differs from the step");
        }
        let step = machine.last_step();
        let state = machine.state();
        let location = |slot| state.location(machine.program(), slot);
        let record = (
            step.updates()
                .iter()
                .map(|update| (location(update.slot), &update.value, update.origin))
                .collect::<Vec<_>>(),
            step.inputs()
                .iter()
                .map(|input| (location(input.slot), &input.value))
                .collect::<Vec<_>>(),
            (step.before(), step.choices(), step.extended()),
        );
        let shown = format!(
            "{record:?}\n{:?}\n{:?}",
            machine.snapshot(),
            machine.counts()
        );
        let fault = result.err();
        let message = fault
            .as_ref()
            .map(|fault| specification.explain_in(fault, &machine).message);
        steps.push(Done {
            fault: format!("{fault:?}"),
            message: message.unwrap_or_default(),
            shown,
        });
    }
    steps
}
