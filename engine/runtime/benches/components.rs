//! Cost of a cycle in virtual time against the number of components.
//!
//! `cargo bench -p asmotion-runtime --bench components --profile release` prints a table and fails if a cycle among many
//! components costs more than `LIMIT` times a cycle among ten. Systems of all sizes take turns in one run, so load affects
//! all of them.

#![allow(
    clippy::disallowed_methods,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "robots/mod.rs"]
mod robots;

use asmotion_runtime::Run;
use robots::{PERIOD, started};

/// Numbers of robots, each with two components.
const ROBOTS: [usize; 4] = [5, 50, 500, 5000];
/// Cycles of a turn, approximately.
const CYCLES: usize = 40_000;
const TURNS: usize = 9;
/// Greatest ratio of the cost of a cycle to that in the smallest system. Larger systems do not fit into the caches, which makes a
/// cycle that does nothing nine times as expensive; a scan of all components would make it hundreds of times as expensive.
const LIMIT: f64 = 12.0;

/// CPU time of this thread in nanoseconds, which does not contain the time of other processes.
fn cpu_time() -> u64 {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    statistics.split(' ').next().unwrap().parse().unwrap()
}

fn main() {
    let mut systems = ROBOTS.map(started);
    let mut best = [f64::INFINITY; ROBOTS.len()];
    for _ in 0..TURNS {
        for ((robots, run), best) in ROBOTS.into_iter().zip(&mut systems).zip(&mut best) {
            let periods = u32::try_from(CYCLES / (2 * robots)).unwrap();
            let cycles = f64::from(periods) * 2.0 * robots as f64;
            let begun = cpu_time();
            run.run_for(PERIOD * periods);
            *best = best.min((cpu_time() - begun) as f64 / cycles);
        }
    }
    println!("| components | time of a cycle | ratio | limit |");
    println!("| --- | --- | --- | --- |");
    for (robots, time) in ROBOTS.into_iter().zip(best) {
        let ratio = time / best[0];
        println!("| {} | {time:.0} ns | {ratio:.2} | {LIMIT} |", robots * 2);
    }
    let last = best[ROBOTS.len() - 1] / best[0];
    assert!(last <= LIMIT, "a cycle costs {last:.2} times as much");
}
