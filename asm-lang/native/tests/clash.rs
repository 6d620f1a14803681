//! Updates that clash, and updates that only seem to: direct rules do what closures do.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    reason = "a test fails by panicking"
)]

use asmotion_lang::machine::NativeCompiler;
use asmotion_lang::{BackEnd, FaultKind, FirstChoice, Machine, MemoryFiles, NoInputs};
use asmotion_native::Cranelift;

fn machine(rules: &str, back_end: BackEnd) -> Machine {
    let text = format!(
        "asm clash
import StandardLibrary
signature:
  domain Place subsetof Integer
  controlled n: Integer
  controlled f: Place -> Integer
  controlled h: Prod(Place, Place) -> Integer
definitions:
  domain Place = {{0 : 3}}
  rule r_set($p in Place, $v in Integer) = f($p) := $v
  main rule r_Main = {rules}
default init s0:
  function n = 1
  function f($p in Place) = $p
  function h($p in Place, $q in Place) = $p * $q
"
    );
    let mut files = MemoryFiles::new();
    files.add("clash.asm", text);
    let opened = asmotion_lang::open("clash.asm", &files);
    let opened = opened.unwrap_or_else(|failure| panic!("{failure}"));
    let mut machine = opened.machine().unwrap();
    let direct = Cranelift.compile_direct(&opened.program, machine.slots());
    // a sequence whose updates may clash is left to code with detours
    let has_direct = !rules.contains("endseq endpar") || rules.ends_with("f(1) := n endpar");
    assert_eq!(direct.is_some(), has_direct, "{rules}");
    machine.set_back_end(back_end).unwrap();
    machine
}

/// Executes three steps with both back ends; returns `true` if a step clashes.
fn clashes(rules: &str) -> bool {
    let mut closures = machine(rules, BackEnd::Closures);
    let mut direct = machine(rules, BackEnd::Native);
    let mut has_clash = false;
    for _ in 0..3 {
        let step = |machine: &mut Machine| {
            let step = machine.step(&mut NoInputs, &mut FirstChoice, 0);
            step.map(|step| (step.updates().to_vec(), step.before().to_vec()))
        };
        let (expected, done) = (step(&mut closures), step(&mut direct));
        assert_eq!(done, expected, "{rules}");
        assert_eq!(direct.snapshot(), closures.snapshot(), "{rules}");
        if let Err(fault) = done {
            has_clash |= matches!(fault.kind, FaultKind::Clash { .. });
        }
    }
    has_clash
}

#[test]
fn updates_that_clash_are_faults() {
    for rules in [
        "par n := 2 n := 3 endpar",
        "par f(1) := 5 forall $p in Place with $p > 0 do f($p) := 6 endpar",
        "forall $p in Place with $p < 3 do par f($p) := 10 f($p + 1) := 20 endpar",
        "forall $p in Place with true do n := $p",
        "forall $p in Place, $q in Place with true do f($p) := $q",
        "forall $p in Place with true do if $p > 1 then f(0) := 1 else f(0) := 2 endif",
        "par r_set[2, 7] r_set[2, 8] endpar",
        "forall $p in Place with true do r_set[(2 * $p) mod 4, $p]",
        "par n := 5 seq n := 1 n := n + 1 endseq endpar",
        "par seq n := 1 n := 2 endseq seq n := 3 endseq endpar",
        "par choose $p in Place with true do f($p) := 8 f(0) := 9 endpar",
        "forall $p in Place with true do forall $q in Place with true do h($q, $q) := $p",
    ] {
        assert!(clashes(rules), "{rules}");
    }
}

#[test]
fn updates_of_different_locations_and_equal_values_are_none() {
    for rules in [
        "par n := 2 n := 2 endpar",
        "forall $p in Place with true do f($p) := f($p) + 1",
        "forall $p in Place with true do if f($p) > 2 then f($p) := 1 else f($p) := f($p) + 1 endif",
        "forall $p in Place, $q in Place with true do h($p, $q) := h($q, $p) + 1",
        "par r_set[2, 7] r_set[1, 8] endpar",
        "if n > 1 then n := 0 else n := n + 1 endif",
        "switch n case 0: n := 1 case 1: n := 2 case 2: n := 3 case 3: n := 4 otherwise n := 0 endswitch",
        "seq n := n + 1 n := n * 2 if n > 50 then n := 1 endif endseq",
        "par seq n := n + 1 while n < 9 do n := n + 2 endseq f(1) := n endpar",
        "forall $p in Place with $p < 2 do par h($p, 0) := $p h($p, 1) := n endpar",
    ] {
        assert!(!clashes(rules), "{rules}");
    }
}
