//! A build without a code generator reports so, and still executes steps.

use asmotion_lang::ir::FunctionId;
use asmotion_lang::{
    BackEnd, Environment, FaultKind, FirstChoice, Machine, MemoryFiles, NoInputs, Value,
};

const COUNTER: &str = "asm counter
import StandardLibrary
signature:
  controlled n: Integer
definitions:
  main rule r_Main = n := n + 1
default init s0:
  function n = 0
";

#[test]
fn native_code_is_there_or_said_not_to_be() {
    let mut files = MemoryFiles::new();
    files.add("counter.asm", COUNTER);
    let specification = asmotion_lang::open("counter.asm", &files).unwrap();
    let mut machine = specification.machine().unwrap();
    let set = machine.set_back_end(BackEnd::Native);
    if cfg!(feature = "native") {
        assert_eq!((set, machine.back_end()), (Ok(()), BackEnd::Native))
    } else {
        assert_eq!(set, Err(asmotion_lang::machine::NoNativeCode::NotBuilt));
        assert_eq!(machine.back_end(), BackEnd::Closures);
        let why = set.unwrap_err().to_string();
        assert!(why.contains("cargo feature `native`"), "{why}");
    }
    for _ in 0..3 {
        machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
    }
    assert_eq!(machine.steps(), 3);
}

#[test]
fn a_machine_without_a_compiler_has_no_native_code() {
    let specification = super::opened("counter", COUNTER);
    let mut machine = Machine::new(specification.program.clone()).unwrap();
    let set = machine.set_back_end(BackEnd::Native);
    assert_eq!(set, Err(asmotion_lang::machine::NoNativeCode::NotBuilt));
    for back_end in [BackEnd::Auto, BackEnd::Closures] {
        assert_eq!(machine.set_back_end(back_end), Ok(()));
        assert_eq!(machine.back_end(), BackEnd::Closures);
    }
    machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
    assert_eq!(machine.steps(), 1);
}

/// Answers inputs, and counts how often it was asked.
struct Counting {
    answer: Result<Option<Value>, String>,
    asked: u32,
}

impl Environment for Counting {
    fn read(&mut self, _: FunctionId, _: &[Value]) -> Result<Option<Value>, String> {
        self.asked += 1;
        self.answer.clone()
    }
}

#[test]
fn a_fault_of_a_part_of_a_term_is_that_of_the_whole_term() {
    let rules = [
        "x := y + m",
        "x := length(s) + m",
        "if y + length(s) > m then x := 1 endif",
        "if length(s) > 0 and m > 0 then x := 1 endif",
        "if (exist $i in {1 : 2} with $i + m > length(s)) then x := 1 endif",
        "choose $i in {1 : 3} with $i > m + length(s) do x := $i",
        "forall $i in {1 : 3} with $i > m do f($i) := length(s)",
        "x := y + late(7)",
        "x := length(s) + late(7)",
        "if late(7) > length(s) then x := 1 endif",
        "x := (y + length(s)) mod (y - y)",
        "if (y + length(s)) mod y > 1 then x := 1 endif",
        "while x + late(7) < 3 do x := x + 1",
    ];
    let answers = [
        Err("the sensor is broken".to_owned()),
        Ok(Some(Value::Int(9))),
        Ok(Some(Value::Int(1))),
        Ok(None),
    ];
    for rule in rules {
        let text = format!(
            "asm parts
import StandardLibrary
signature:
  domain Small subsetof Integer
  monitored m: Small
  controlled x: Integer
  controlled y: Integer
  controlled s: Seq(Integer)
  controlled f: Integer -> Integer
  controlled late: Integer -> Integer
definitions:
  domain Small = {{0 : 3}}
  main rule r_Main = {rule}
default init s0:
  function x = 0
  function y = 0
  function s = [1, 2]
  function late($i in Integer) = 5 mod ($i - 7)
"
        );
        let specification = super::opened("parts", &text);
        for answer in &answers {
            let run = |back_end| {
                let mut machine = specification.machine().unwrap();
                // without native code, closures are compared with themselves
                let _ = machine.set_back_end(back_end);
                let answer = answer.clone();
                let mut inputs = Counting { answer, asked: 0 };
                let step = machine.step(&mut inputs, &mut FirstChoice, 0);
                let updates = step.map(|step| step.updates().to_vec());
                let fault = updates.map_err(|fault| (fault.kind, fault.origin, fault.step));
                (fault, inputs.asked)
            };
            let (expected, found) = (run(BackEnd::Closures), run(BackEnd::Native));
            assert_eq!(found, expected, "{rule} with {answer:?}");
            assert!(expected.1 <= 1, "{rule}");
            if let (Err(_), (Err((kind, ..)), 1)) = (answer, expected) {
                assert!(matches!(kind, FaultKind::Input { .. }), "{rule}: {kind:?}");
            }
        }
    }
}
