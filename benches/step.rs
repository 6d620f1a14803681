//! Measures the duration of a step of the machines in `benches/machines`, without input or output.
//!
//! `S1_navigate` is the coordinator of a robot and must stay below two microseconds; each of the others has one kind of
//! load. Choices are drawn from a cheap generator.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a bench fails by panicking"
)]

#[path = "machines/mission.rs"]
mod mission;

use asmotion_lang::{Chooser, Machine, MemoryFiles};
use criterion::{Criterion, criterion_group, criterion_main};
use mission::Mission;

/// The machines, with the number of steps after which their load is typical.
const MACHINES: &[(&str, &str, u64)] = &[
    ("S1_navigate", include_str!("machines/S1_navigate.asm"), 100),
    ("agents100", include_str!("machines/agents100.asm"), 100),
    ("bfs1000", include_str!("machines/bfs1000.asm"), 100),
    ("coord", include_str!("machines/coord.asm"), 1_000),
    ("counter", include_str!("machines/counter.asm"), 1_000),
    ("gcd", include_str!("machines/gcd.asm"), 1_000),
    ("life128", include_str!("machines/life128.asm"), 10),
    ("life32", include_str!("machines/life32.asm"), 100),
    ("phil5", include_str!("machines/phil5.asm"), 1_000),
    ("phil50", include_str!("machines/phil50.asm"), 1_000),
    ("phil500", include_str!("machines/phil500.asm"), 1_000),
    ("sort512", include_str!("machines/sort512.asm"), 100),
    ("sort64", include_str!("machines/sort64.asm"), 1_000),
];

/// Chooses with a xorshift generator.
struct Shifts(u64);

impl Chooser for Shifts {
    fn choose(&mut self, count: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (((self.0 >> 32) * count as u64) >> 32) as usize
    }
}

fn machine(name: &str, text: &str) -> Machine {
    let mut files = MemoryFiles::new();
    files.add(&format!("{name}.asm"), text);
    let opened = asmotion_lang::open(&format!("{name}.asm"), &files);
    opened
        .unwrap_or_else(|failure| panic!("{failure}"))
        .machine()
        .unwrap()
}

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for (name, text, warm) in MACHINES {
        let mut machine = machine(name, text);
        let mut mission = Mission::of(&machine);
        let mut shifts = Shifts(88_172_645_463_325_252);
        for _ in 0..*warm {
            machine.step(&mut mission, &mut shifts, 0).unwrap();
        }
        group.bench_function(*name, |bencher| {
            bencher.iter(|| machine.step(&mut mission, &mut shifts, 0).unwrap().number());
        });
    }
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
