//! Cost against size: of a step for each agent, of the initial state for each agent, and of `choose` by an equation.
//!
//! `cargo bench -p asmotion-native --bench scaling --profile release` prints a table and fails if a ratio or a time exceeds
//! its limit. Ratios compare sizes and kinds of agents within one run, in turns, so load affects both sides. With names
//! after `--`, only these subjects: `near`, `created`, `initial`, `choose`.

#![allow(
    clippy::disallowed_methods,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "specifications/mod.rs"]
mod specifications;

use asmotion_lang::simulate::Seeded;
use asmotion_lang::{BackEnd, Machine, MemoryFiles, NoInputs, Specification};
use specifications::{agents, chosen, listed, numbered};
use std::time::{Duration, Instant};

/// Number of turns of each measurement.
const TURNS: usize = 7;

/// Approximate duration of a turn.
const TURN: Duration = Duration::from_millis(40);

fn open(text: &str) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("scaling.asm", text);
    asmotion_lang::open("scaling.asm", &files).unwrap_or_else(|failure| panic!("{failure}"))
}

/// Returns a machine with native code, after steps in which locations get their first values.
fn started(text: &str) -> Machine {
    let mut machine = open(text).machine().unwrap();
    machine.set_back_end(BackEnd::Native).unwrap();
    run(&mut machine, 4);
    machine
}

fn run(machine: &mut Machine, steps: u64) {
    for now_ns in 0..steps as i64 {
        machine
            .step(&mut NoInputs, &mut Seeded::new(7), now_ns)
            .unwrap();
    }
}

/// Returns the least time of a step of each machine, in nanoseconds. The machines take turns.
fn steps(machines: &mut [Machine]) -> Vec<f64> {
    let counts: Vec<u64> = machines
        .iter_mut()
        .map(|machine| {
            let begun = Instant::now();
            run(machine, 2);
            let step = begun.elapsed().as_secs_f64() / 2.0;
            (TURN.as_secs_f64() / step).ceil() as u64
        })
        .collect();
    let mut least = vec![f64::MAX; machines.len()];
    for _ in 0..TURNS {
        for ((machine, count), least) in machines.iter_mut().zip(&counts).zip(&mut least) {
            let begun = Instant::now();
            run(machine, *count);
            *least = least.min(begun.elapsed().as_nanos() as f64 / *count as f64);
        }
    }
    least
}

/// Prints a row, and returns `true` if the limit is kept.
fn row(
    subject: &str,
    size: &str,
    time: &str,
    ratio: Option<f64>,
    limit: &str,
    is_kept: bool,
) -> bool {
    let ratio = ratio.map_or(String::new(), |ratio| format!("{ratio:.2}"));
    let missed = if is_kept { "" } else { " missed" };
    println!("| {subject} | {size} | {time} | {ratio} | {limit} |{missed}");
    is_kept
}

fn near() -> bool {
    let sizes = [1_000, 10_000, 100_000, 1_000_000];
    let mut machines: Vec<Machine> = sizes.iter().map(|&size| started(&numbered(size))).collect();
    let times = steps(&mut machines);
    let first = times[0] / 1_000.0;
    let mut is_kept = true;
    for (size, time) in sizes.iter().zip(times) {
        let each = time / *size as f64;
        is_kept &= row(
            "step, for each agent",
            &size.to_string(),
            &format!("{each:.1} ns"),
            Some(each / first),
            "2 times that of 1,000; fails above 3",
            // a step of a million agents moves 300 MB, so other load on the memory counts twice
            each / first <= 3.0,
        );
    }
    is_kept
}

fn created() -> bool {
    let mut is_kept = true;
    for size in [100, 1_000, 10_000] {
        let mut machines = [started(&agents(size, false)), started(&agents(size, true))];
        let times = steps(&mut machines);
        for (what, time, limit) in [("declared", times[0], 1.0), ("created", times[1], 1.5)] {
            let ratio = time / times[0];
            is_kept &= row(
                &format!("step, for each agent, {what}"),
                &size.to_string(),
                &format!("{:.1} ns", time / size as f64),
                Some(ratio),
                &format!("{limit} times declared"),
                ratio <= limit,
            );
        }
    }
    is_kept
}

fn initial() -> bool {
    let mut is_kept = true;
    for size in [1_000, 10_000] {
        let specification = open(&listed(size));
        let least = (0..TURNS).map(|_| {
            let begun = Instant::now();
            let machine = specification.machine().unwrap();
            let taken = begun.elapsed();
            drop(machine);
            taken
        });
        let each = least.min().unwrap_or_default().as_nanos() as f64 / size as f64;
        is_kept &= row(
            "initial state, for each agent",
            &size.to_string(),
            &format!("{each:.0} ns"),
            None,
            "3,000 ns",
            each <= 3_000.0,
        );
    }
    is_kept
}

fn choose() -> bool {
    let mut is_kept = true;
    for (robots, zones, limit) in [
        (1_000, 200, 1.0),
        (10_000, 2_000, 10.0),
        (100_000, 20_000, 200.0),
    ] {
        let time = steps(&mut [started(&chosen(robots, zones))])[0] / 1e6;
        is_kept &= row(
            "step, `choose` by an equation in `forall`",
            &format!("{robots} × {zones}"),
            &format!("{time:.2} ms"),
            None,
            &format!("{limit} ms"),
            time <= limit,
        );
    }
    is_kept
}

/// The name of a subject, and its measurement, which returns `true` if the limits are kept.
type Subject = (&'static str, fn() -> bool);

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_selected = |name: &str| {
        let mut names = arguments
            .iter()
            .filter(|it| !it.starts_with('-'))
            .peekable();
        names.peek().is_none() || names.any(|it| it == name)
    };
    println!("| | size | time | ratio | at most |");
    println!("| --- | --- | --- | --- | --- |");
    let subjects: [Subject; 4] = [
        ("near", near),
        ("created", created),
        ("initial", initial),
        ("choose", choose),
    ];
    let mut is_kept = true;
    for (name, measure) in subjects {
        is_kept &= !is_selected(name) || measure();
    }
    assert!(is_kept, "a limit was missed");
}
