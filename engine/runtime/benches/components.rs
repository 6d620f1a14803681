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

use std::time::Duration;

use asmotion_component::{Activity, Component, Cycle, Fault, In, Interface, Out, Policy};
use asmotion_runtime::{Run, Simulation, System};

asmotion_datum::message! {
    /// A reading of a robot.
    pub struct Reading = "bench/Reading" {
        /// Number of readings before it.
        pub number: i64,
    }
}

/// Numbers of robots, each with two components.
const ROBOTS: [usize; 4] = [5, 50, 500, 5000];
/// Period of each robot's sensor.
const PERIOD: Duration = Duration::from_millis(100);
/// Cycles of a turn, approximately.
const CYCLES: usize = 40_000;
const TURNS: usize = 9;
/// Greatest ratio of the cost of a cycle to that in the smallest system. Larger systems do not fit into the caches, which makes a
/// cycle that does nothing nine times as expensive; a scan of all components would make it hundreds of times as expensive.
const LIMIT: f64 = 12.0;

/// Publishes a reading in each period.
struct Sensor {
    reading: Out<Reading>,
    number: i64,
}

impl Component for Sensor {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        self.number += 1;
        let number = self.number;
        cycle.write(self.reading, Reading { number });
        Ok(())
    }
}

/// Reads the readings of its robot, as a coordinator does.
struct Reader {
    reading: In<Reading>,
    sum: i64,
}

impl Component for Reader {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if let Some(reading) = cycle.read(self.reading).new() {
            self.sum += reading.number;
        }
        Ok(())
    }
}

/// A system of so many robots, whose sensors are out of phase, after its first seconds.
fn started(robots: usize) -> Simulation {
    let mut system = System::new();
    for robot in 0..robots {
        let delay = PERIOD * u32::try_from(robot).unwrap() / u32::try_from(robots).unwrap();
        let activity = Activity::periodic(PERIOD).delay(delay);
        let sensor = |interface: &mut Interface| -> Box<dyn Component> {
            let reading = interface.output("reading", "its readings");
            Box::new(Sensor { reading, number: 0 })
        };
        let reader = |interface: &mut Interface| -> Box<dyn Component> {
            let reading = interface.input("reading", "those of its robot");
            Box::new(Reader { reading, sum: 0 })
        };
        let [sensor_name, reader_name] = ["Sensor", "Reader"].map(|kind| format!("{kind}{robot}"));
        system.add(&sensor_name, activity, sensor).unwrap();
        system.add(&reader_name, Activity::event(), reader).unwrap();
        let topic = format!("robot{robot}/reading");
        system
            .publish(&format!("{sensor_name}.reading"), &topic)
            .unwrap();
        system
            .subscribe(&topic, &format!("{reader_name}.reading"), Policy::data())
            .unwrap();
    }
    let mut run = system.simulate();
    run.run_for(PERIOD * 20);
    run
}

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
