//! Machines switch to native code while they run, and large programs are compiled within bounds.

#![allow(
    clippy::panic,
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test fails by panicking, and waits for a thread"
)]

use asmotion_lang::{BackEnd, FirstChoice, Machine, MemoryFiles, NoInputs};
use std::fmt::Write as _;
use std::time::{Duration, Instant};

fn machine(text: &str) -> Machine {
    let mut files = MemoryFiles::new();
    files.add("tiering.asm", text.to_owned());
    let opened = asmotion_lang::open("tiering.asm", &files);
    opened
        .unwrap_or_else(|failure| panic!("{failure}"))
        .machine()
        .unwrap()
}

fn step(machine: &mut Machine) {
    machine.step(&mut NoInputs, &mut FirstChoice, 0).unwrap();
}

const COUNTER: &str = "asm tiering
import StandardLibrary
signature:
  controlled n: Integer
  controlled last: Integer
  controlled seen: Powerset(Integer)
definitions:
  main rule r_Main = par
    n := (n * 7 + 1) mod 101
    last := n
    RULES
  endpar
default init s0:
  function n = 0
  function seen = {}
";

#[test]
fn a_machine_switches_to_native_code_in_the_background() {
    // the second one has no direct rule
    for rules in ["skip", "seen := {n}"] {
        let text = COUNTER.replace("RULES", rules);
        let (mut auto, mut closures) = (machine(&text), machine(&text));
        closures.set_back_end(BackEnd::Closures).unwrap();
        assert_eq!(auto.back_end(), BackEnd::Closures);
        let started = Instant::now();
        let mut after = 0;
        while after < 100 {
            step(&mut auto);
            step(&mut closures);
            assert_eq!(auto.last_step().updates(), closures.last_step().updates());
            assert_eq!(auto.last_step().before(), closures.last_step().before());
            after += usize::from(auto.back_end() == BackEnd::Native);
            assert!(
                started.elapsed() < Duration::from_secs(60),
                "never switched"
            );
        }
        assert_eq!(auto.snapshot(), closures.snapshot());
        assert!(auto.steps() > 500, "compiled after {} steps", auto.steps());
    }
}

/// Returns a specification with about 25 lines for each of so many rules.
fn large(rules: usize) -> String {
    let mut functions = String::new();
    let mut definitions = String::new();
    let mut calls = String::new();
    for rule in 0..rules {
        let _ = writeln!(functions, "  controlled f{rule}: Integer");
        let _ = writeln!(functions, "  controlled g{rule}: Integer");
        let _ = writeln!(calls, "    r_{rule}[]");
        let mut cases = String::new();
        for case in 0..8 {
            let _ = writeln!(
                cases,
                "      case {case}:\n        par f{rule} := f{rule} + {case}\n        g{rule} := g{rule} mod {} endpar",
                case + 2
            );
        }
        let _ = writeln!(
            definitions,
            "  rule r_{rule} =\n    switch g{rule}\n{cases}      otherwise g{rule} := f{rule} mod 8\n    endswitch\n"
        );
    }
    format!(
        "asm large\nimport StandardLibrary\nsignature:\n{functions}definitions:\n{definitions}\n  \
         main rule r_Main = par\n{calls}  endpar\ndefault init s0:\n{}",
        (0..rules)
            .map(|rule| format!(
                "  function f{rule} = 0\n  function g{rule} = {}\n",
                rule % 8
            ))
            .collect::<String>()
    )
}

#[test]
fn a_large_specification_is_compiled_within_bounds() {
    for rules in [100, 1_900] {
        let text = large(rules);
        let (mut native, mut closures) = (machine(&text), machine(&text));
        closures.set_back_end(BackEnd::Closures).unwrap();
        let started = Instant::now();
        native.set_back_end(BackEnd::Native).unwrap();
        let taken = started.elapsed();
        println!("{} lines: {} ms", text.lines().count(), taken.as_millis());
        // code is not optimised in this profile, and other tests run at the same time
        assert!(taken < Duration::from_secs(20), "{taken:?}");
        for _ in 0..4 {
            step(&mut native);
            step(&mut closures);
            assert_eq!(native.snapshot(), closures.snapshot());
        }
    }
}

/// Returns the processor time of the calling thread, where the kernel counts it.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds = text.split_whitespace().next()?.parse().ok()?;
    Some(Duration::from_nanos(nanoseconds))
}

/// Prints the processor time of the compilation of `coord`, which depends less on other load than the time does.
#[test]
fn a_coordinator_is_compiled_within_a_bound() {
    const TIMES: u32 = 50;
    let text = include_str!("../../../benches/machines/coord.asm");
    let machines = (0..TIMES).map(|_| machine(text));
    let mut machines: Vec<Machine> = machines.collect();
    let Some(before) = processor_time() else {
        return;
    };
    for machine in &mut machines {
        machine.set_back_end(BackEnd::Native).unwrap();
    }
    // the kernel adds to its count a few times in 10 ms
    let each = (processor_time().unwrap() - before) / TIMES;
    println!("compilation of coord: {each:?} of processor time");
    assert!(each < Duration::from_millis(200), "{each:?}");
}
