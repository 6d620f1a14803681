//! The semantics of rules and terms: one construct per file.
//!
//! Comments in a program specify the inputs and the complete update set of each step.
//!
//! ```asm
//! //? step 1: m = 3, choose 1      what the environment answers; which candidate is chosen
//! //= step 1: x := 4, y := undef   the update set of the step; `nothing` if it is empty
//! //= step 1: a -> b: order(3)      a message that the step sends
//! //= step 2: R001                 the step fails with this code
//! ```

use asmotion_lang::simulate::{Recording, Trace};
use asmotion_lang::{BackEnd, Machine, Specification, ir};
use std::collections::BTreeMap;
use std::sync::Arc;

#[test]
fn does_what_its_comments_say() {
    let mut wrong = String::new();
    for (name, text) in super::programs(&super::folder().join("semantics")) {
        let specification = super::opened(&name, &text);
        let machine = specification.machine();
        let done = match machine {
            Ok(machine) => steps(&specification, machine, &text),
            Err(fault) => {
                BTreeMap::from([(0, vec![specification.explain(&fault).code.to_string()])])
            }
        };
        let expected = expected(&text);
        assert!(!expected.is_empty(), "{name}.asm expects nothing");
        if done != expected {
            wrong.push_str(&format!(
                "{name}.asm\n  expected {expected:?}\n  found    {done:?}\n"
            ));
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn does_the_same_wherever_locations_are_kept() {
    for (name, text) in super::programs(&super::folder().join("semantics")) {
        let specification = super::opened(&name, &text);
        let Ok(dense) = specification.machine() else {
            continue;
        };
        let dense = steps(&specification, dense, &text);
        for (kept, lazy) in [("interned", 1), ("in lazy slots", 1 << 16)] {
            let lowered = ir::lower_with(&specification.model, 1, lazy).unwrap();
            let machine = Machine::new(Arc::new(lowered.program)).unwrap();
            assert_eq!(
                steps(&specification, machine, &text),
                dense,
                "in {name}.asm, {kept}"
            );
        }
    }
}

#[test]
fn does_the_same_as_native_code() {
    for (name, text) in super::programs(&super::folder().join("semantics")) {
        let specification = super::opened(&name, &text);
        let Ok(closures) = specification.machine() else {
            continue;
        };
        let mut native = closures.clone();
        // without native code, closures are compared with themselves
        let _ = native.set_back_end(BackEnd::Native);
        assert_eq!(
            steps(&specification, native, &text),
            steps(&specification, closures, &text),
            "in {name}.asm"
        );
    }
}

/// Runs a program as long as its comments say. Returns the update set of each step, or its code.
fn steps(
    specification: &Specification,
    mut machine: Machine,
    text: &str,
) -> BTreeMap<u64, Vec<String>> {
    let recording = Recording::read(&causes(text));
    let mut done = BTreeMap::new();
    for (number, step) in (1..).zip(recording.steps()) {
        let mut inputs = step.inputs(&machine).unwrap();
        let result = machine.step(&mut inputs, &mut step.choices(), step.now_ns);
        if let Err(fault) = result.map(|_| ()) {
            let code = specification.explain_in(&fault, &machine).code;
            done.insert(number, vec![code.to_string()]);
            break;
        }
        let mut trace = Trace::begin(&machine, "");
        trace.step(&machine);
        done.insert(number, updates(&trace.end(&machine, None)));
    }
    done
}

/// The update set in a trace of one step, in the notation of the comments.
pub(super) fn updates(trace: &str) -> Vec<String> {
    let updates = trace.lines().filter_map(|line| {
        let (word, fact) = line.split_once(' ')?;
        match word {
            "U" => Some(fact.replacen(" = ", " := ", 1)),
            "UD" => Some(fact.replacen(" = ", " + ", 1)),
            "P" => Some(fact.to_owned()),
            _ => None,
        }
    });
    let mut updates: Vec<String> = updates.collect();
    updates.sort();
    if updates.is_empty() {
        vec!["nothing".to_owned()]
    } else {
        updates
    }
}

/// The comments that begin with a mark, as step and parts.
fn marked<'a>(text: &'a str, mark: &'a str) -> impl Iterator<Item = (u64, Vec<&'a str>)> {
    text.lines().filter_map(move |line| {
        let (step, rest) = line
            .trim()
            .strip_prefix(mark)?
            .trim()
            .strip_prefix("step ")?
            .split_once(": ")?;
        Some((
            step.parse().unwrap(),
            rest.split(", ").map(str::trim).collect(),
        ))
    })
}

fn expected(text: &str) -> BTreeMap<u64, Vec<String>> {
    let expected = marked(text, "//=").map(|(step, parts)| {
        let mut parts: Vec<String> = parts.into_iter().map(str::to_owned).collect();
        parts.sort();
        (step, parts)
    });
    expected.collect()
}

/// The inputs and choices in the comments, as a trace.
fn causes(text: &str) -> String {
    let last = marked(text, "//=").map(|(step, _)| step).max().unwrap_or(0);
    let mut trace = String::new();
    for number in 1..=last {
        trace.push_str(&format!("@step {number}\n"));
        for (_, parts) in marked(text, "//?").filter(|(step, _)| *step == number) {
            for part in parts {
                match part.split_once(' ') {
                    Some(("choose", index)) => trace.push_str(&format!("C {index} of\n")),
                    Some(("time", nanoseconds)) => trace.push_str(&format!("T {nanoseconds}\n")),
                    _ => trace.push_str(&format!("M {part}\n")),
                }
            }
        }
    }
    trace
}
