//! Counts the instructions of a step, with callgrind: the same figures on every run and under any load.
//!
//! `cargo bench -p asmotion-native --bench instructions --profile release` prints a table of the machines of
//! `benches/machines` and of their hand-written equivalents, and fails if a factor exceeds its limit. With names after
//! `--`, only these machines. The counts include the choices, which both sides draw from the same generator.

#![allow(
    clippy::disallowed_methods,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "../../../benches/machines/hand/mod.rs"]
mod hand;

use asmotion_lang::machine::NativeCompiler;
use asmotion_lang::{BackEnd, Chooser, MemoryFiles, NoInputs};
use asmotion_native::Cranelift;
use hand::Shifts;
use std::process::Command;

/// A machine.
struct Case {
    name: &'static str,
    text: &'static str,
    /// Number of steps; three times as many are run as well, and the difference counts.
    steps: u64,
    /// Greatest permitted ratio to the hand-written machine.
    limit: f64,
}

macro_rules! cases {
    ($($name:literal $steps:literal $limit:literal;)*) => {
        &[$(Case {
            name: $name,
            text: include_str!(concat!("../../../benches/machines/", $name, ".asm")),
            steps: $steps,
            limit: $limit,
        }),*]
    };
}

const CASES: &[Case] = cases! {
    "counter" 4000 6.5;
    "gcd" 2000 4.4;
    "phil5" 2000 1.6;
    "phil50" 500 1.2;
    "life32" 40 2.9;
    "sort64" 400 3.5;
    "agents100" 100 1.8;
    "coord" 2000 2.7;
    "bfs1000" 200 150.0;
};

impl Chooser for Shifts {
    fn choose(&mut self, count: usize) -> usize {
        self.below(count as u32) as usize
    }
}

/// Runs one side, in the process that callgrind observes.
fn run(name: &str, side: &str, steps: u64) {
    if side == "hand" {
        // without vector instructions where there is a choice, because native code has none
        let scalar = format!("{name}_scalar");
        let machines = || hand::MACHINES.iter();
        let (_, hand) = machines()
            .find(|(known, _)| *known == scalar)
            .or_else(|| machines().find(|(known, _)| *known == name))
            .unwrap();
        drop(std::hint::black_box(hand(steps, false)));
        return;
    }
    let case = CASES.iter().find(|case| case.name == name).unwrap();
    let mut files = MemoryFiles::new();
    files.add(name, case.text);
    let opened = asmotion_lang::open(name, &files).unwrap_or_else(|failure| panic!("{failure}"));
    let mut machine = opened.machine().unwrap();
    if side == "compile" {
        for _ in 0..steps {
            let direct = Cranelift.compile_direct(&opened.program, machine.slots());
            if direct.is_none() {
                drop(Cranelift.compile(&opened.program).unwrap());
            }
        }
        return;
    }
    machine.set_back_end(BackEnd::Native).unwrap();
    let mut shifts = Shifts(Shifts::SEED);
    machine.step(&mut NoInputs, &mut shifts, 0).unwrap();
    for _ in 0..steps {
        match side {
            "step" => drop(
                machine
                    .step(&mut NoInputs, &mut shifts, 0)
                    .unwrap()
                    .number(),
            ),
            "evaluate" => drop(
                machine
                    .evaluate_step(&mut NoInputs, &mut shifts, 0)
                    .unwrap()
                    .len(),
            ),
            other => panic!("{other} is no side"),
        }
    }
}

/// Returns the number of instructions of a run.
fn count(name: &str, side: &str, steps: u64) -> f64 {
    let itself = std::env::current_exe().unwrap();
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(itself)
        .args(["run", name, side, &steps.to_string()])
        .output()
        .expect("callgrind is part of valgrind");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    let line = text.lines().find(|line| line.contains("Collected :"));
    let count = line.and_then(|line| line.rsplit(' ').next());
    count.unwrap_or_default().parse().expect(&text)
}

/// Returns the number of instructions of a step.
fn of_a_step(case: &Case, side: &str) -> f64 {
    let (few, many) = (case.steps, 3 * case.steps);
    (count(case.name, side, many) - count(case.name, side, few)) / (many - few) as f64
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, name, side, steps] = arguments.as_slice()
        && first == "run"
    {
        return run(name, side, steps.parse().unwrap());
    }
    let valgrind = Command::new("valgrind").arg("--version").output();
    if valgrind.is_err() {
        println!("valgrind is missing: nothing was measured (Debian: apt install valgrind)");
        return;
    }
    let selected: Vec<&String> = arguments.iter().filter(|it| !it.starts_with('-')).collect();
    println!(
        "| machine | by hand | a step | factor | at most | evaluated only | compilation, millions |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut missed = Vec::new();
    for case in CASES {
        if !selected.is_empty() && !selected.iter().any(|name| *name == case.name) {
            continue;
        }
        let [hand, step, evaluated] =
            ["hand", "step", "evaluate"].map(|side| of_a_step(case, side));
        let compiled = (count(case.name, "compile", 3) - count(case.name, "compile", 1)) / 2e6;
        let factor = step / hand;
        println!(
            "| `{}` | {hand:.0} | {step:.0} | {factor:.1} | {} | {evaluated:.0} | {compiled:.1} |",
            case.name, case.limit
        );
        if factor > case.limit {
            missed.push(case.name);
        }
    }
    assert!(missed.is_empty(), "above the limit: {missed:?}");
}
