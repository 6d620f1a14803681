//! A build without a code generator reports so, and still executes steps.

use asmotion_lang::{BackEnd, FirstChoice, MemoryFiles, NoInputs};

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
