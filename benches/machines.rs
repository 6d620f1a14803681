//! Compares machines with hand-written Rust, run alternately, and measures how long it takes to read a specification.
//!
//! `cargo bench --bench machines` prints the tables of `docs/benchmarks.md`; with names after `--`, only those
//! machines. Every final state is compared with that of the hand-written machine first.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "machines/hand/mod.rs"]
mod hand;
#[path = "machines/large.rs"]
mod large;

use asmotion_lang::{BackEnd, Chooser, Machine, MemoryFiles, NoInputs};
use hand::{Hand, Shifts};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// A machine, with the permitted ratio of its time to hand-written code, and that of AsmetaS.
struct Case {
    name: &'static str,
    /// Name of the hand-written machine.
    hand: &'static str,
    text: &'static str,
    limit: f64,
    asmetas: f64,
}

macro_rules! cases {
    ($($name:literal $hand:literal $limit:literal $asmetas:literal;)*) => {
        &[$(Case {
            name: $name,
            hand: $hand,
            text: include_str!(concat!("machines/", $name, ".asm")),
            limit: $limit,
            asmetas: $asmetas,
        }),*]
    };
}

/// Each machine must be at least five hundred times as fast as AsmetaS. The factors of AsmetaS were measured once,
/// against the same hand-written machines.
const CASES: &[Case] = cases! {
    "counter" "counter" 4.0 6425.0;
    "gcd" "gcd" 4.0 9192.0;
    "phil5" "phil5" 2.0 9989.0;
    "phil50" "phil50" 2.0 4803.0;
    "phil500" "phil500" 2.0 6159.0;
    "life32" "life32" 30.0 81970.0;
    "life32" "life32_scalar" 8.0 81970.0;
    "life128" "life128" 60.0 243703.0;
    "life128" "life128_scalar" 20.0 243703.0;
    "sort64" "sort64" 5.0 79094.0;
    "sort512" "sort512" 5.0 83651.0;
    "agents100" "agents100" 1.5 16932.0;
    "coord" "coord" 2.5 9746.0;
    "bfs1000" "bfs1000" 1104.0 552073.0;
};

/// Number of turns for each side.
const TURNS: usize = 60;

/// Approximate duration of a turn.
const TURN: Duration = Duration::from_millis(5);

impl Chooser for Shifts {
    fn choose(&mut self, count: usize) -> usize {
        self.below(count as u32) as usize
    }
}

fn machine(case: &Case) -> Machine {
    let name = format!("{}.asm", case.name);
    let mut files = MemoryFiles::new();
    files.add(&name, case.text);
    let opened = asmotion_lang::open(&name, &files).unwrap_or_else(|failure| panic!("{failure}"));
    let mut machine = opened.machine().unwrap();
    machine.set_back_end(BackEnd::Native).unwrap();
    machine
}

fn run(machine: &mut Machine, shifts: &mut Shifts, steps: u64) {
    for _ in 0..steps {
        machine.step(&mut NoInputs, shifts, 0).unwrap();
    }
}

/// The values of all locations that were accessed.
fn state(machine: &Machine) -> Vec<String> {
    let naming = machine.naming();
    let line = |(function, arguments, slot)| {
        let function: asmotion_lang::ir::FunctionId = function;
        let arguments: Vec<asmotion_lang::value::Value> = arguments;
        let name = &naming.program.symbols.functions[function.0 as usize];
        let shown: Vec<String> = arguments
            .iter()
            .map(|argument| argument.show(&naming).to_string())
            .collect();
        let value = machine.state().get(slot).show(&naming);
        if shown.is_empty() {
            format!("{name}={value}")
        } else {
            format!("{name}({})={value}", shown.join(","))
        }
    };
    let locations = machine.state().locations(naming.program);
    locations.into_iter().map(line).collect()
}

/// Checks that all locations of the machine have the same values as in the hand-written one.
fn agree(case: &Case, hand: Hand, steps: u64) {
    let mut machine = machine(case);
    run(&mut machine, &mut Shifts(Shifts::SEED), steps);
    let by_hand: BTreeSet<String> = hand(steps, true).into_iter().collect();
    let ours = state(&machine);
    assert!(!ours.is_empty(), "{} has no locations", case.name);
    for line in ours {
        let line = line.replace(", ", ",");
        assert!(by_hand.contains(&line), "{}: {line}", case.name);
    }
}

/// The number of steps that take about one turn.
fn steps_for(mut run: impl FnMut(u64)) -> u64 {
    let mut steps = 1;
    loop {
        let started = Instant::now();
        run(steps);
        let taken = started.elapsed();
        if taken > TURN / 4 {
            return (steps as f64 * TURN.as_secs_f64() / taken.as_secs_f64()).ceil() as u64;
        }
        steps *= 2;
    }
}

/// Nanoseconds per step: the minimum over all turns, which was least disturbed by other processes.
fn compare(case: &Case, hand: Hand) -> (f64, f64) {
    let mut machine = machine(case);
    let mut shifts = Shifts(Shifts::SEED);
    let hand_steps = steps_for(|steps| drop(hand(steps, false)));
    let our_steps = steps_for(|steps| run(&mut machine, &mut shifts, steps));
    let (mut by_hand, mut ours) = (f64::MAX, f64::MAX);
    for _ in 0..TURNS {
        let started = Instant::now();
        drop(std::hint::black_box(hand(hand_steps, false)));
        by_hand = by_hand.min(started.elapsed().as_nanos() as f64 / hand_steps as f64);
        let started = Instant::now();
        run(&mut machine, &mut shifts, our_steps);
        ours = ours.min(started.elapsed().as_nanos() as f64 / our_steps as f64);
    }
    (by_hand, ours)
}

fn main() {
    let all: Vec<String> = std::env::args().collect();
    if all.get(1).map(String::as_str) == Some("steps") {
        let case = CASES.iter().find(|case| case.name == all[2]).unwrap();
        let mut machine = machine(case);
        run(
            &mut machine,
            &mut Shifts(Shifts::SEED),
            all[3].parse().unwrap(),
        );
        return;
    }
    let selected: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| !argument.starts_with('-'))
        .collect();
    println!(
        "| machine | by hand, ns | a step, ns | factor | at most | AsmetaS, factor | faster than AsmetaS |"
    );
    println!("|---|---|---|---|---|---|---|");
    for case in CASES {
        if !selected.is_empty() && !selected.iter().any(|name| name == case.name) {
            continue;
        }
        let (_, hand) = *hand::MACHINES
            .iter()
            .find(|(name, _)| *name == case.hand)
            .unwrap();
        for steps in [1, 2, 10, 500, 3001] {
            agree(case, hand, steps);
        }
        let (by_hand, ours) = compare(case, hand);
        let factor = ours / by_hand;
        println!(
            "| `{}` | {by_hand:.1} | {ours:.1} | {factor:.1} | {} | {:.0} | {:.0} × |{}",
            case.hand,
            case.limit,
            case.asmetas,
            case.asmetas / factor,
            if factor > case.limit { " missed" } else { "" },
        );
    }
    if selected.is_empty() {
        large::print();
    }
}
