//! A panic of a chooser or an environment unwinds to the caller of a step, whatever executes the step.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking, and panics are its subject"
)]

use asmotion_lang::ir::FunctionId;
use asmotion_lang::{BackEnd, Chooser, Environment, Machine, MemoryFiles, NoInputs, Value};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Chooses the first of several candidates, and panics once.
struct Panicking {
    choices: usize,
    at: usize,
}

impl Chooser for Panicking {
    fn choose(&mut self, _count: usize) -> usize {
        self.choices += 1;
        assert!(self.choices != self.at, "the chooser panics");
        0
    }
}

impl Environment for Panicking {
    fn read(&mut self, _: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        let index = self.choose(1);
        Ok(Some(Value::Int(index as i64)))
    }
}

fn machine(rules: &str, back_end: BackEnd) -> Machine {
    let text = format!(
        "asm panics
import StandardLibrary
signature:
  domain Place subsetof Integer
  monitored heard: Integer
  controlled n: Integer
  controlled at: Place -> Integer
definitions:
  domain Place = {{0 : 3}}
  main rule r_Main = {rules}
default init s0:
  function n = 0
  function at($p in Place) = 0
"
    );
    let mut files = MemoryFiles::new();
    files.add("panics.asm", text);
    let opened = asmotion_lang::open("panics.asm", &files);
    let opened = opened.unwrap_or_else(|failure| panic!("{failure}"));
    let mut machine = opened.machine().unwrap();
    machine.set_back_end(back_end).unwrap();
    machine
}

const CHOOSING: &str = "par
    choose $p in Place with at($p) < 100 do at($p) := at($p) + 1
    choose $q in Place with at($q) >= 0 do n := n + at($q)
  endpar";

const HEARING: &str = "par
    n := n + heard
    forall $p in Place with heard > 5 do at($p) := heard
  endpar";

const HEARING_IN_SEQUENCE: &str = "seq
    n := n + 1
    while n mod 3 != heard do n := n + 1
    choose $p in Place with at($p) < 100 do at($p) := n
  endseq";

#[test]
fn panics_unwind_through_native_code() {
    for rules in [CHOOSING, HEARING, HEARING_IN_SEQUENCE] {
        for back_end in [BackEnd::Closures, BackEnd::Native] {
            for at in [3, 4] {
                let mut machine = machine(rules, back_end);
                let mut chooser = Panicking { choices: 0, at };
                let mut environment = Panicking { choices: 0, at };
                let mut panicked = None;
                for _ in 0..6 {
                    let step = AssertUnwindSafe(|| {
                        let done = machine.step(&mut environment, &mut chooser, 0);
                        done.map(|_| ()).unwrap();
                    });
                    if let Err(payload) = catch_unwind(step) {
                        panicked = payload.downcast_ref::<&str>().copied();
                        break;
                    }
                }
                assert_eq!(
                    panicked,
                    Some("the chooser panics"),
                    "{back_end:?}: {rules}"
                );
            }
        }
    }
}

#[test]
fn steps_without_a_panic_are_not_affected() {
    for back_end in [BackEnd::Closures, BackEnd::Native] {
        let mut machine = machine(CHOOSING, back_end);
        let mut chooser = Panicking { choices: 0, at: 0 };
        for _ in 0..6 {
            machine.step(&mut NoInputs, &mut chooser, 0).unwrap();
        }
        assert_eq!(chooser.choices, 12);
    }
}
