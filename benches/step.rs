//! How long a step takes: the machines of `benches/machines`, without input or output.
//!
//! `navigate` is the coordinator of a robot and has to stay below two microseconds; the others are
//! loads of one kind each. Their inputs are constant, their choices drawn from a cheap generator.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a bench fails by panicking")]

use asm_lang::value::Value;
use asm_lang::{Chooser, Environment, Files, Machine, ir};
use criterion::{Criterion, criterion_group, criterion_main};

/// The machines, and after how many steps they are in full swing.
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

/// Answers every input with the values of a list, one after the other: those of a mission.
struct Mission {
    program: std::sync::Arc<ir::Program>,
    at: usize,
}

impl Environment for Mission {
    fn read(&mut self, function: ir::FunctionId, _arguments: &[Value]) -> Result<Option<Value>, String> {
        self.at += 1;
        Ok(Some(match self.program.functions[function.0 as usize].codomain {
            // now and then something is pressed, arrived or cancelled
            ir::Shape::Bool => Value::Bool(self.at % 37 == 0),
            ir::Shape::Domain(domain) => match self.program.domains[domain.0 as usize].elements {
                ir::Elements::Atoms { first, count } => {
                    Value::Atom(asm_lang::value::Atom(first.0 + (self.at as u32 * 7) % count))
                }
                _ => Value::Undef,
            },
            _ => Value::Undef,
        }))
    }
}

/// Chooses by a generator of three shifts.
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
    let mut files = Files::new();
    files.add(&format!("{name}.asm"), text);
    let opened = asm_lang::open(&format!("{name}.asm"), &files);
    opened.unwrap_or_else(|failure| panic!("{failure}")).machine().unwrap()
}

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step");
    for (name, text, warm) in MACHINES {
        let mut machine = machine(name, text);
        let mut mission = Mission { program: machine.program().clone(), at: 0 };
        let mut shifts = Shifts(88_172_645_463_325_252);
        for _ in 0..*warm {
            machine.step(&mut mission, &mut shifts, 0).unwrap();
        }
        group.bench_function(*name, |bencher| {
            bencher.iter(|| machine.step(&mut mission, &mut shifts, 0).unwrap().number);
        });
    }
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
