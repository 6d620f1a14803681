//! Cost of starting components of one specification, and of their cycles in virtual time, against their number.
//!
//! `cargo bench -p asmotion-assembly --bench start` prints the CPU time and the memory of a component, from its composite to
//! a system that runs, and the CPU time of a cycle after that, in which its specification makes a step.

#![allow(
    clippy::disallowed_methods,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "rovers/mod.rs"]
mod rovers;

use std::time::Duration;

use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, NoPrograms};
use asmotion_lang::MemoryFiles;
use asmotion_runtime::Run;
use rovers::{BUILD, SPECIFICATION, composite};

/// Numbers of components.
const COMPONENTS: [usize; 5] = [1, 10, 100, 1_000, 10_000];
/// Cycles that are measured in a system, approximately; each component has at least ten.
const CYCLES: usize = 10_000;

/// CPU time of this thread in microseconds, which does not contain the time of other processes.
fn cpu_time() -> f64 {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    let nanoseconds: u64 = statistics.split(' ').next().unwrap().parse().unwrap();
    nanoseconds as f64 / 1e3
}

/// Resident memory in KiB.
fn memory() -> f64 {
    let statistics = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = statistics.split(' ').nth(1).unwrap().parse().unwrap();
    pages as f64 * 4.0
}

fn main() {
    println!("| components | open | assemble | start and 10 cycles | memory | a cycle |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for components in COMPONENTS {
        let mut files = MemoryFiles::new();
        files.add("main.toml", composite(components));
        files.add("rover.asm", SPECIFICATION);
        let specifications = AsmFiles::new(&files);
        let context = Context {
            loader: &files,
            environment: &EmptyEnvironment,
            catalogue: &BUILD,
            specifications: &specifications,
            programs: &NoPrograms,
            settings: &[],
        };
        let begun = cpu_time();
        let opened = asmotion_plan::open("main.toml", &context);
        let plan = opened.plan(None).unwrap_or_else(|| {
            let first = opened.report.diagnostics.first();
            panic!("{:?}", first.map(|it| &it.message))
        });
        let open = cpu_time();
        let before = memory();
        let mut workshop = Standard::new(&BUILD, &files, CoordinatorOptions::seeded(1));
        let system = asmotion_assembly::start(plan, &mut workshop).unwrap();
        let assembled = cpu_time();
        let after = memory();
        let mut run = system.simulate();
        run.run_for(Duration::from_millis(1000));
        let ran = cpu_time();
        let cycles = (CYCLES / components).max(10);
        // a cycle in 100 ms
        run.run_for(Duration::from_millis(100 * cycles as u64));
        let cycled = cpu_time();
        let each = |time: f64| time / components as f64;
        println!(
            "| {components} | {:.0} µs | {:.0} µs | {:.0} µs | {:.1} KiB | {:.2} µs |",
            each(open - begun),
            each(assembled - open),
            each(ran - assembled),
            each(after - before),
            each(cycled - ran) / cycles as f64
        );
    }
}
