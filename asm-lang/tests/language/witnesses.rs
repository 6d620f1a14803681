//! Explanations of failed steps: the step is repeated with the same inputs, and ends with the same fault.

use crate::support::opened;
use asmotion_lang::ir::FunctionId;
use asmotion_lang::{Environment, FaultKind, FirstChoice, Machine, Value};

/// Signature and rules of all programs. `m` is refused or answered; `unanswered` is never answered.
fn program(rule: &str, rest: &str) -> String {
    format!(
        "asm witnesses
import StandardLibrary
signature:
  domain Small subsetof Integer
  monitored m: Integer
  monitored small: Small
  shared unanswered: Integer
  controlled x: Integer
  controlled first: Integer
definitions:
  domain Small = {{1 : 3}}
  {rest}
  main rule r_Main = {rule}
default init s0:
  function unanswered = 7
"
    )
}

/// Answers `m` and `small`, or refuses `m`.
struct Inputs {
    functions: Vec<(FunctionId, Option<i64>)>,
}

impl Inputs {
    fn of(machine: &Machine, m: Option<i64>, small: i64) -> Self {
        let names = &machine.program().symbols.functions;
        let id = |name: &str| {
            let index = names.iter().position(|it| &**it == name).unwrap();
            FunctionId(index as u32)
        };
        Self {
            functions: vec![(id("m"), m), (id("small"), Some(small))],
        }
    }
}

impl Environment for Inputs {
    fn read(&mut self, function: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        match self.functions.iter().find(|(known, _)| *known == function) {
            Some((_, Some(number))) => Ok(Some(Value::Int(*number))),
            Some((_, None)) => Err("the sensor is broken".to_owned()),
            None => Ok(None),
        }
    }

    fn source(&self, _: FunctionId, _: &[Value]) -> String {
        "line 3".to_owned()
    }
}

/// Makes steps until one fails.
fn fail(text: &str, m: Option<i64>, small: i64) -> (Machine, Box<asmotion_lang::StepFault>) {
    let mut machine = opened("witnesses", text).machine().unwrap();
    let mut inputs = Inputs::of(&machine, m, small);
    for _ in 0..5 {
        if let Err(fault) = machine.step(&mut inputs, &mut FirstChoice, 0).map(|_| ()) {
            return (machine, fault);
        }
    }
    panic!("no step fails: {text}");
}

#[test]
fn are_there_for_every_kind_of_failed_step() {
    let twice = "par x := m x := 1 endpar";
    let clash = |kind: &FaultKind| matches!(kind, FaultKind::Clash { .. });
    let violated = |kind: &FaultKind| matches!(kind, FaultKind::Invariant { .. });
    let refused = |kind: &FaultKind| matches!(kind, FaultKind::Input { .. });
    let outside = |kind: &FaultKind| matches!(kind, FaultKind::OutsideInput { .. });
    type Kind<'a> = &'a dyn Fn(&FaultKind) -> bool;
    // rule, definitions, input `m`, input `small`, kind of the fault, number of the failed step
    type Case<'a> = (&'a str, &'a str, Option<i64>, i64, Kind<'a>, u64);
    let cases: [Case<'_>; 10] = [
        (twice, "", Some(2), 1, &clash, 1),
        // after a step without a fault, and after an input that the environment left to the machine
        (
            "if x = 5 then par x := m x := 1 endpar else x := 5 endif",
            "",
            Some(2),
            1,
            &clash,
            2,
        ),
        (
            "par x := m first := unanswered x := unanswered endpar",
            "",
            Some(2),
            1,
            &clash,
            1,
        ),
        ("x := m", "", None, 1, &refused, 1),
        (
            "if x = 5 then first := m else x := 5 endif",
            "",
            None,
            1,
            &refused,
            2,
        ),
        // only one of two inputs was refused
        (
            "par first := unanswered x := m endpar",
            "",
            None,
            1,
            &refused,
            1,
        ),
        ("x := small", "", Some(1), 4, &outside, 1),
        (
            "par first := unanswered x := small endpar",
            "",
            Some(1),
            4,
            &outside,
            1,
        ),
        // the step is done, and its new state violates an invariant
        (
            "x := 3",
            "invariant inv_x over x: x != 3",
            Some(1),
            1,
            &violated,
            1,
        ),
        (
            "if first = 1 then x := 3 else first := 1 endif",
            "invariant inv_x over x: x != 3",
            Some(1),
            1,
            &violated,
            2,
        ),
    ];
    for (rule, definitions, m, small, is_kind, step) in cases {
        let (machine, fault) = fail(&program(rule, definitions), m, small);
        assert!(is_kind(&fault.kind), "{rule}: {fault:?}");
        assert_eq!(fault.step, step, "{rule}");
        let witness = machine.witness(&fault);
        let witness = witness.unwrap_or_else(|| panic!("no witness: {rule} {fault:?}"));
        assert!(!witness.path.is_empty(), "{rule}");
    }
}

#[test]
fn of_an_initial_value_repeat_its_inputs() {
    let text = "asm witnesses
import StandardLibrary
signature:
  monitored m: Integer
  monitored small: Integer
  controlled x: Integer
definitions:
  main rule r_Main = x := x + 1
default init s0:
  function x = 5 mod m
";
    let (machine, fault) = fail(text, Some(0), 1);
    assert_eq!(fault.step, 0);
    assert!(matches!(fault.kind, FaultKind::Library(_)), "{fault:?}");
    let witness = machine.witness(&fault).unwrap();
    let mut reads = witness.path.iter().flat_map(|entry| entry.reads.values());
    assert!(reads.any(|value| *value == Value::Int(0)), "{witness:?}");
}

#[test]
fn of_the_initial_state_repeat_its_inputs() {
    let text = "asm witnesses
import StandardLibrary
signature:
  monitored m: Integer
  monitored small: Integer
  controlled x: Integer
  controlled first: Integer -> Integer
definitions:
  invariant inv_x over x: x > 3
  main rule r_Main = x := x + 1
default init s0:
  function x = m
";
    let (machine, fault) = fail(text, Some(2), 1);
    assert_eq!(fault.step, 0);
    assert!(
        matches!(fault.kind, FaultKind::Invariant { .. }),
        "{fault:?}"
    );
    let witness = machine.witness(&fault).unwrap();
    let mut reads = witness.path.iter().flat_map(|entry| entry.reads.values());
    assert!(reads.any(|value| *value == Value::Int(2)), "{witness:?}");
}
