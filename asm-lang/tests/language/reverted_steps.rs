//! Steps that are reverted or only evaluated leave the state as it was.

use crate::support::opened;
use asmotion_lang::ir::{DomainId, FunctionId};
use asmotion_lang::simulate::Seeded;
use asmotion_lang::{BackEnd, Environment, Machine, MemoryFiles, ReadOptions, Value};

/// Answers every input with the same number.
struct Given(i64);

impl Environment for Given {
    fn read(&mut self, _: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        Ok(Some(Value::Int(self.0)))
    }
}

fn program(signature: &str, rule: &str, rest: &str) -> String {
    format!(
        "asm reverted\nimport StandardLibrary\n{signature}\n  controlled n: Integer\ndefinitions:\n  {rule}\n{rest}\n"
    )
}

/// Executes a step with inputs and choices that depend on a number.
fn step(machine: &mut Machine, given: i64) {
    let chooser = &mut Seeded::new(given as u64);
    machine.step(&mut Given(given), chooser, 0).unwrap();
}

#[test]
fn can_be_reverted_unless_they_change_more_than_locations() {
    let plain = "main rule r_Main = n := 1";
    let initial = "default init s0:\n  function kept = 1";
    let cases = [
        ("signature:", plain, "", true, true),
        (
            "signature:\n  monitored m: Integer",
            "main rule r_Main = n := m",
            "",
            true,
            true,
        ),
        // messages in transit
        ("import CommonBehavior\nsignature:", plain, "", false, false),
        // an input that is kept until the next one
        (
            "signature:\n  shared kept: Integer",
            "main rule r_Main = n := kept",
            initial,
            false,
            false,
        ),
        // the first inputs complete the initial state
        (
            "signature:\n  monitored m: Integer\n  controlled kept: Integer",
            plain,
            "default init s0:\n  function kept = m",
            false,
            true,
        ),
    ];
    for (signature, rule, rest, at_first, later) in cases {
        let mut machine = opened("reverted", &program(signature, rule, rest))
            .machine()
            .unwrap();
        assert_eq!(machine.can_revert(), at_first, "{signature}");
        step(&mut machine, 1);
        assert_eq!(machine.can_revert(), later, "{signature}");
    }
    let mut files = MemoryFiles::new();
    files.add("reverted.asm", program("signature:", plain, ""));
    let options = ReadOptions {
        compatible: true,
        ..ReadOptions::default()
    };
    let compatible = asmotion_lang::open_with("reverted.asm", &files, &options).unwrap();
    assert!(!compatible.machine().unwrap().can_revert());
}

const CHANGING: &str = "asm changing
import StandardLibrary
signature:
  abstract domain Item
  domain Box subsetof Item
  domain Side subsetof Integer
  monitored m: Integer
  controlled n: Integer
  controlled text: String
  controlled row: Seq(Integer)
  controlled at: Integer -> Integer
  controlled side: Side -> Integer
  controlled place: Item -> Integer
definitions:
  domain Side = {0 : 3}
  main rule r_Main = par
    n := n + m
    text := concat(text, \"x\")
    row := append(row, n)
    at(n + 1000) := m
    choose $s in Side with true do side($s) := n
    if n mod 2 = 0 then extend Box with $b do place($b) := n endif
  endpar
default init s0:
  function n = 0
  function text = \"\"
  function row = []
";

/// Returns what constitutes the state of a machine, including the elements of its domains.
fn state(machine: &Machine) -> impl PartialEq + std::fmt::Debug + use<> {
    let domains = 0..machine.program().domains.len() as u32;
    let extents = domains.map(|domain| machine.state().extent(DomainId(domain)).to_vec());
    (
        machine.snapshot().into_state(),
        machine.steps(),
        extents.collect::<Vec<_>>(),
        machine.naming().reserve.to_vec(),
    )
}

#[test]
fn leave_no_trace_in_the_state() {
    for back_end in [BackEnd::Closures, BackEnd::Native] {
        let specification = opened("changing", CHANGING);
        let mut machine = specification.machine().unwrap();
        let mut straight = specification.machine().unwrap();
        // without native code, closures run twice
        let _ = machine.set_back_end(back_end);
        for given in 1..12 {
            assert!(machine.can_revert());
            let before = state(&machine);
            for other in [given + 1, given] {
                let chooser = &mut Seeded::new(other as u64);
                let evaluated = machine.evaluate_step(&mut Given(other), chooser, 0);
                let evaluated = evaluated.unwrap().to_vec();
                assert_eq!(state(&machine), before, "{back_end:?}, {other} evaluated");
                step(&mut machine, other);
                let done = machine.last_step();
                assert_eq!(done.updates(), evaluated, "{back_end:?}, {other}");
                assert_eq!(done.before().len(), evaluated.len(), "{back_end:?}");
                assert_ne!(state(&machine), before, "{back_end:?}, {other}");
                machine.revert();
                assert_eq!(state(&machine), before, "{back_end:?}, {other} reverted");
            }
            step(&mut machine, given);
            step(&mut straight, given);
            assert_eq!(state(&machine), state(&straight), "{back_end:?}, {given}");
        }
    }
}
