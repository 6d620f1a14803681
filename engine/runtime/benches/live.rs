//! Components in real time: threads, CPU time, and how late cycles are, with executor threads and with a thread for each component.
//!
//! `cargo bench -p asmotion-runtime --bench live --profile release` prints two tables. In the first, components have a cycle every
//! 100 ms, out of phase; in the second, a component writes a sample every 10 ms to another one that is driven by it. Both kinds of
//! threads take turns in one run, so load affects both.

#![allow(
    clippy::disallowed_methods,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{
    Activity, Component, Cycle, Fault, In, Interface, Out, Policy, ThreadUse,
};
use asmotion_runtime::{Run, System};

asmotion_datum::message! {
    /// A reading.
    pub struct Stamped = "bench/Stamped" {
        /// Time since the beginning of the bench at which it was written, in nanoseconds.
        pub nanos: i64,
    }
}

/// Numbers of components with a period.
const COMPONENTS: [usize; 3] = [10, 100, 1_000];
const PERIOD: Duration = Duration::from_millis(100);
/// Length of a run.
const SPAN: Duration = Duration::from_secs(5);
const TURNS: usize = 3;
/// Numbers of pairs of a writer and a reader.
const PAIRS: [usize; 2] = [1, 8];

/// Times by which something was late.
type Delays = Arc<Mutex<Vec<Duration>>>;

/// Notes how late its cycles are, on the grid of its period.
struct Periodic {
    due: Duration,
    late: Vec<Duration>,
    delays: Delays,
}

impl Component for Periodic {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = Duration::from_nanos(cycle.now().nanos().unsigned_abs());
        // the first cycles come while the others start
        if cycle.number() == 5 {
            self.due = now;
        } else if cycle.number() > 5 {
            let passed = now.saturating_sub(self.due).as_nanos();
            self.late.push(Duration::from_nanos(
                u64::try_from(passed % PERIOD.as_nanos()).unwrap(),
            ));
        }
        Ok(())
    }

    fn stop(&mut self, _: &mut Cycle<'_>) {
        // relative to the earliest, because the first one can be late, too
        let half = PERIOD / 2;
        let signed = |late: &Duration| {
            late.as_secs_f64()
                - if *late > half {
                    PERIOD.as_secs_f64()
                } else {
                    0.0
                }
        };
        let least = self.late.iter().map(signed).fold(0.0, f64::min);
        let late = self
            .late
            .iter()
            .map(|it| Duration::from_secs_f64(signed(it) - least));
        self.delays.lock().unwrap().extend(late);
    }
}

struct Writer {
    out: Out<Stamped>,
    zero: Instant,
}

impl Component for Writer {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let nanos = i64::try_from(self.zero.elapsed().as_nanos()).unwrap();
        cycle.write(self.out, Stamped { nanos });
        Ok(())
    }
}

/// Notes the time from the write to its cycle.
struct Reader {
    input: In<Stamped>,
    zero: Instant,
    delays: Delays,
}

impl Component for Reader {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let now = self.zero.elapsed();
        if let Some(stamped) = cycle.read(self.input).new() {
            let written = Duration::from_nanos(stamped.nanos.unsigned_abs());
            self.delays
                .lock()
                .unwrap()
                .push(now.saturating_sub(written));
        }
        Ok(())
    }
}

/// What a run costs.
struct Cost {
    threads: usize,
    /// Share of a core.
    cpu: f64,
    delays: Vec<Duration>,
}

/// CPU time of this process.
fn cpu_time() -> Duration {
    let tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let of_task = |task: std::io::Result<std::fs::DirEntry>| {
        let statistics = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        statistics.split(' ').next()?.parse::<u64>().ok()
    };
    Duration::from_nanos(tasks.filter_map(of_task).sum())
}

fn measured(system: System, delays: &Delays) -> Cost {
    let mut run = system.live();
    run.run_for(Duration::from_millis(500));
    let (begun, at) = (cpu_time(), Instant::now());
    run.run_for(SPAN);
    let cpu = (cpu_time() - begun).as_secs_f64() / at.elapsed().as_secs_f64();
    let threads = std::fs::read_dir("/proc/self/task").unwrap().count();
    run.stop();
    drop(run);
    let mut delays = std::mem::take(&mut *delays.lock().unwrap());
    delays.sort_unstable();
    Cost {
        threads,
        cpu,
        delays,
    }
}

fn periodic(components: usize, thread: ThreadUse) -> Cost {
    let delays = Delays::default();
    let mut system = System::new();
    for number in 0..components {
        let delay = PERIOD * u32::try_from(number).unwrap() / u32::try_from(components).unwrap();
        let activity = Activity::periodic(PERIOD).delay(delay).thread(thread);
        let delays = Arc::clone(&delays);
        let made = move |_: &mut Interface| -> Box<dyn Component> {
            Box::new(Periodic {
                due: Duration::ZERO,
                late: Vec::new(),
                delays,
            })
        };
        system.add(&format!("C{number}"), activity, made).unwrap();
    }
    measured(system, &delays)
}

fn pairs(pairs: usize, thread: ThreadUse) -> Cost {
    let (delays, zero) = (Delays::default(), Instant::now());
    let mut system = System::new();
    for number in 0..pairs {
        let activity = Activity::periodic(Duration::from_millis(10)).thread(thread);
        let writer = move |interface: &mut Interface| -> Box<dyn Component> {
            let out = interface.output("out", "its readings");
            Box::new(Writer { out, zero })
        };
        let delays = Arc::clone(&delays);
        let reader = move |interface: &mut Interface| -> Box<dyn Component> {
            let input = interface.input("in", "those of the writer");
            Box::new(Reader {
                input,
                zero,
                delays,
            })
        };
        let [from, to] = ["Writer", "Reader"].map(|kind| format!("{kind}{number}"));
        system.add(&from, activity, writer).unwrap();
        system
            .add(&to, Activity::event().thread(thread), reader)
            .unwrap();
        let (from, to) = (format!("{from}.out"), format!("{to}.in"));
        system.connect(&from, &to, Policy::data()).unwrap();
    }
    measured(system, &delays)
}

fn row(what: &str, thread: ThreadUse, runs: &[Cost]) {
    let threads = runs.iter().map(|run| run.threads).max().unwrap_or(0);
    let mut cpu: Vec<f64> = runs.iter().map(|run| run.cpu * 100.0).collect();
    cpu.sort_by(f64::total_cmp);
    let mut delays: Vec<f64> = runs
        .iter()
        .flat_map(|run| &run.delays)
        .map(|delay| delay.as_secs_f64() * 1e6)
        .collect();
    delays.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let last = delays.len().saturating_sub(1) as f64;
        delays.get((last * share) as usize).copied().unwrap_or(0.0)
    };
    let (median, most, all) = (at(0.5), at(0.99), at(1.0));
    let thread = match thread {
        ThreadUse::Own => "one each",
        ThreadUse::Shared => "executor",
    };
    println!(
        "| {what} | {thread} | {threads} | {:.1} % | {median:.0} µs | {most:.0} µs | {all:.0} µs |",
        cpu[cpu.len() / 2]
    );
}

fn table(name: &str, late: &str, sizes: &[usize], run: fn(usize, ThreadUse) -> Cost) {
    println!(
        "| {name} | threads | of the process | CPU, of a core | {late}, median | 99 % | longest |"
    );
    println!("|---|---|---|---|---|---|---|");
    for size in sizes {
        let mut costs = [Vec::new(), Vec::new()];
        for _ in 0..TURNS {
            costs[0].push(run(*size, ThreadUse::Own));
            costs[1].push(run(*size, ThreadUse::Shared));
        }
        row(&size.to_string(), ThreadUse::Own, &costs[0]);
        row(&size.to_string(), ThreadUse::Shared, &costs[1]);
    }
    println!();
}

fn main() {
    table("components at 10 Hz", "late", &COMPONENTS, periodic);
    table(
        "writers at 100 Hz, each with a reader",
        "from write to cycle",
        &PAIRS,
        pairs,
    );
}
