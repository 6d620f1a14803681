//! Cost against size: what a unit of work costs while the specification, the system or the fleet grows.
//!
//! `cargo bench --bench growth` prints a table with four sizes for each row: the instructions and the CPU time of a unit of work, and
//! the slope, which is the exponent `k` of a cost that grows as size to the power of `k`. It fails if the slope of the instructions
//! exceeds its limit. Callgrind counts the instructions: they are the same in every run and under any load; the CPU time is not, and
//! has no limit. With names after `--`, only these rows; `--few` leaves out the largest size of each row and the CPU times.

#![allow(
    clippy::disallowed_methods,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a bench fails by panicking and prints its figures"
)]

#[path = "../engine/runtime/benches/robots/mod.rs"]
mod robots;
#[path = "../engine/assembly/benches/rovers/mod.rs"]
mod rovers;
#[path = "../asm-lang/native/benches/specifications/mod.rs"]
mod specifications;

use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asmotion::mission::Mission;
use asmotion_assembly::{CoordinatorOptions, Standard};
use asmotion_component::Time;
use asmotion_composite::{AsmFiles, Context, EmptyEnvironment, NoPrograms};
use asmotion_coordinator::{STEP_REPORT, StepRecord};
use asmotion_drawing::Instances;
use asmotion_lang::simulate::Seeded;
use asmotion_lang::{BackEnd, Machine, MemoryFiles, NoInputs, Specification};
use asmotion_plan::Opened;
use asmotion_runtime::{Event, Observer, ReportInterest, Run, Simulation};

/// A row of the table.
struct Row {
    name: &'static str,
    /// Unit of work whose cost the row shows.
    unit: &'static str,
    /// Ascending.
    sizes: [u64; 4],
    /// Greatest slope.
    limit: f64,
    /// Does the work of a size so many times, after what is done once.
    work: fn(size: u64, times: u64),
    /// Number of units in the work of a size.
    units: fn(size: u64) -> u64,
}

const ROWS: &[Row] = &[
    Row {
        name: "locations",
        unit: "step, for each agent that is a number",
        sizes: [1_000, 10_000, 100_000, 1_000_000],
        limit: 0.05,
        work: |size, times| drop(stepped(&specifications::numbered(size), times)),
        units: |size| size,
    },
    Row {
        name: "created",
        unit: "step, for each agent created by `extend`",
        sizes: [100, 1_000, 5_000, 16_000],
        limit: 0.05,
        work: |size, times| drop(stepped(&specifications::agents(size, true), times)),
        units: |size| size,
    },
    Row {
        name: "initial",
        unit: "initial state, for each agent listed in a map",
        sizes: [100, 1_000, 3_000, 10_000],
        limit: 0.1,
        work: initial,
        units: |size| size,
    },
    Row {
        name: "choose",
        unit: "step, for each robot chosen by an equation in `forall`",
        sizes: [500, 1_000, 10_000, 50_000],
        limit: 0.1,
        work: |size, times| drop(stepped(&specifications::chosen(size, size / 5), times)),
        units: |size| size,
    },
    Row {
        name: "compilation",
        unit: "native code, for each agent's rule",
        sizes: [10, 50, 100, 300],
        limit: 0.15,
        work: compiled,
        units: |size| size,
    },
    Row {
        name: "reading",
        unit: "parse, check and lower, for each agent's declaration and rule",
        sizes: [100, 300, 1_000, 3_000],
        limit: 0.05,
        work: |size, times| (0..times).for_each(|_| drop(open(&rules(size)))),
        units: |size| size,
    },
    Row {
        name: "records",
        unit: "record of a step, for each rule with two updates",
        sizes: [100, 300, 1_000, 3_000],
        // updates are sorted by location
        limit: 0.1,
        work: recorded,
        units: |size| size,
    },
    Row {
        name: "components",
        unit: "cycle in virtual time",
        sizes: [10, 100, 1_000, 10_000],
        // systems of 64 components or more prefetch, which takes instructions and saves time
        limit: 0.1,
        work: cycled,
        // of each component in ten periods
        units: |size| 10 * size,
    },
    Row {
        name: "coordinators",
        unit: "cycle of a coordinator without observers in virtual time",
        sizes: [10, 100, 1_000, 10_000],
        limit: 0.05,
        work: coordinated,
        // of each coordinator in a second
        units: |size| 10 * size,
    },
    Row {
        name: "observed",
        unit: "cycle of a coordinator with an observer in virtual time",
        sizes: [10, 100, 1_000, 10_000],
        limit: 0.05,
        work: observed,
        units: |size| 10 * size,
    },
    Row {
        name: "brief",
        unit: "cycle of a coordinator in virtual time whose steps an observer counts",
        sizes: [10, 100, 1_000, 10_000],
        limit: 0.05,
        work: counted,
        units: |size| 10 * size,
    },
    Row {
        name: "quiet",
        unit: "cycle of a coordinator in `asmotion run --quiet`",
        sizes: [10, 100, 1_000, 10_000],
        limit: 0.05,
        work: |size, times| mission(size, times, false),
        units: |size| 10 * size,
    },
    Row {
        name: "story",
        unit: "cycle of a coordinator in `asmotion run`",
        sizes: [10, 100, 1_000, 10_000],
        limit: 0.05,
        work: |size, times| mission(size, times, true),
        units: |size| 10 * size,
    },
    Row {
        name: "start",
        unit: "start of a coordinator, from the composite to the tenth cycle",
        sizes: [10, 30, 100, 300],
        // negative, because the specification is read and compiled once for all of them
        limit: -0.2,
        work: begun,
        units: |size| size,
    },
    Row {
        name: "connected",
        unit: "start of two coordinators that are connected to each other, with their first cycle",
        sizes: [100, 300, 1_000, 3_000],
        // the specification is read and compiled once for all of them
        limit: 0.0,
        work: |size, times| {
            let composite = || pairs(size);
            (0..times).for_each(|_| drop(started(composite())));
        },
        units: |size| size,
    },
    Row {
        name: "shown",
        unit: "expansion, picture, routes and threads of two coordinators that are connected to each other, in two processes",
        sizes: [100, 300, 1_000, 3_000],
        // maps by name grow with the logarithm of the size
        limit: 0.1,
        work: shown,
        units: |size| size,
    },
];

fn open(text: &str) -> Specification {
    let mut files = MemoryFiles::new();
    files.add("growth.asm", text);
    asmotion_lang::open("growth.asm", &files).unwrap_or_else(|failure| panic!("{failure}"))
}

/// A machine after so many steps in native code, and those in which locations get their first values.
fn stepped(text: &str, times: u64) -> Machine {
    let mut machine = open(text).machine().unwrap();
    machine.set_back_end(BackEnd::Native).unwrap();
    for now_ns in 0..4 + times as i64 {
        let chooser = &mut Seeded::new(7);
        machine.step(&mut NoInputs, chooser, now_ns).unwrap();
    }
    machine
}

fn initial(size: u64, times: u64) {
    let specification = open(&specifications::listed(size));
    (0..times).for_each(|_| drop(specification.machine().unwrap()));
}

/// A specification with a rule for each of so many agents, all of them different.
fn rules(size: u64) -> String {
    let each = |text: fn(u64) -> String| (0..size).map(text).collect::<String>();
    let declared =
        each(|it| format!("  controlled count{it}: Integer\n  controlled load{it}: Integer\n"));
    let rules = each(|it| {
        format!(
            "  rule r_work{it} = par
    count{it} := (count{it} * 3 + {it}) mod 1009
    if count{it} > 500 then load{it} := load{it} + 1 else load{it} := 0 endif
  endpar
"
        )
    });
    let calls = each(|it| format!("    r_work{it}[]\n"));
    let initial = each(|it| format!("  function count{it} = 1\n  function load{it} = 0\n"));
    format!(
        "asm growth\nimport StandardLibrary\nsignature:\n{declared}definitions:\n{rules}  main rule r_Main = par\n{calls}  endpar\n\
         default init s0:\n{initial}"
    )
}

/// Records a step in which the rules of so many agents make updates.
fn recorded(size: u64, times: u64) {
    let specification = open(&rules(size));
    let mut machine = specification.machine().unwrap();
    let chooser = &mut Seeded::new(7);
    machine.step(&mut NoInputs, chooser, 0).unwrap();
    for _ in 0..times {
        drop(StepRecord::of(
            &specification,
            &machine,
            &machine.last_step(),
        ));
    }
}

fn compiled(size: u64, times: u64) {
    let specification = open(&rules(size));
    for _ in 0..times {
        let mut machine = specification.machine().unwrap();
        machine.set_back_end(BackEnd::Native).unwrap();
    }
}

fn cycled(size: u64, times: u64) {
    // two components each
    let mut run = robots::started(usize::try_from(size / 2).unwrap());
    run.run_for(robots::PERIOD * u32::try_from(10 * times).unwrap());
}

fn begun(size: u64, times: u64) {
    (0..times).for_each(|_| drop(roving(size)));
}

fn coordinated(size: u64, times: u64) {
    let mut run = roving(size);
    (0..times).for_each(|_| run.run_for(Duration::from_millis(1000)));
}

fn observed(size: u64, times: u64) {
    let mut run = roving(size);
    run.observe(|_: Time, _: &Event<'_>| {});
    (0..times).for_each(|_| run.run_for(Duration::from_millis(1000)));
}

/// Runs coordinators as `asmotion run --quiet` does.
fn counted(size: u64, times: u64) {
    let mut run = roving(size);
    let observer = |_: Time, _: &Event<'_>| {};
    run.observe(observer.using(ReportInterest::Except(&[STEP_REPORT])));
    (0..times).for_each(|_| run.run_for(Duration::from_millis(1000)));
}

/// Runs a mission of so many coordinators for a second of their time after the first.
fn mission(size: u64, times: u64, tells_steps: bool) {
    let folder = tempfile::tempdir().unwrap();
    let composite = rovers::composite(usize::try_from(size).unwrap());
    // messages of the standard build
    let composite = composite.replace("bench/Flag", "std_msgs/Bool");
    let composite = composite.replace("bench/Mode", "std_msgs/String");
    std::fs::write(folder.path().join("rover.asm"), rovers::SPECIFICATION).unwrap();
    let path = folder.path().join("fleet.composite.toml");
    std::fs::write(&path, composite).unwrap();
    let mut mission = Mission::new(path.to_string_lossy());
    mission.limit = Some(Duration::from_secs(1 + times));
    mission.tells_steps = tells_steps;
    let ignored = |_: Time, _: &Event<'_>, _: Option<&str>| {};
    let end = mission.run(|_, _| (), ignored, &AtomicBool::new(false));
    assert!(end.unwrap().summary.steps >= 10 * size * times);
}

/// A composite of so many pairs of coordinators, each of which is connected to the other.
fn pairs(pairs: u64) -> String {
    let coordinators = ["Rover", "Driver"].map(|name| {
        format!(
            "[components.{name}]
for = \"$n in 1..{pairs}\"
implementation = {{ asm = \"rover.asm\" }}
task = {{ period_ms = 100 }}
ports.in = {{ arrived = \"bench/Flag\" }}
ports.out = {{ command = \"bench/Mode\", resting = \"bench/Flag\" }}
bind.monitored = {{ arrived = {{ topic = \"arrived\", map = \"data\", none = false }} }}
bind.out = {{ command = {{ topic = \"command\", field = \"data\" }}, resting = {{ topic = \"resting\", field = \"data\" }} }}
"
        )
    });
    let connections = [("Rover", "Driver"), ("Driver", "Rover")].map(|(from, to)| {
        format!(
            "[[connections]]
for = \"$n in 1..{pairs}\"
from = \"{from}$n.resting\"
to = \"{to}$n.arrived\"
"
        )
    });
    format!(
        "schema = \"composite/1\"\n[composite]\nname = \"pairs\"\n{}{}",
        coordinators.concat(),
        connections.concat()
    )
}

/// Starts so many coordinators, and runs each of them for ten cycles.
fn roving(size: u64) -> Simulation {
    let mut run = started(rovers::composite(usize::try_from(size).unwrap()));
    run.run_for(Duration::from_millis(1000));
    run
}

/// Describes pairs of coordinators, all rovers in one process and all drivers in another, as the commands do that show a composite.
fn shown(size: u64, times: u64) {
    let processes = [("rovers", "Rover"), ("drivers", "Driver")].map(|(name, component)| {
        let components = (1..=size).map(|it| format!("\"{component}{it}\""));
        let components = components.collect::<Vec<_>>().join(", ");
        format!("{{ name = \"{name}\", components = [{components}] }}")
    });
    let deploy = format!(
        "[brokers.main]\nurl = \"amqp://localhost\"\n[deploy]\nprocesses = [{}]\n",
        processes.join(", ")
    );
    let opened = planned(&files(pairs(size) + &deploy));
    let plan = opened.plan(None).unwrap();
    for _ in 0..times {
        drop(asmotion_plan::expand(&opened, plan));
        drop(asmotion_drawing::svg(plan, Instances::Folded));
        drop(plan.connection_routes());
        assert_eq!(plan.threads().count(), plan.components.len());
    }
}

/// The files of a composite of rovers.
fn files(composite: String) -> MemoryFiles {
    let mut files = MemoryFiles::new();
    files.add("main.toml", composite);
    files.add("rover.asm", rovers::SPECIFICATION);
    files
}

fn planned(files: &MemoryFiles) -> Opened {
    let specifications = AsmFiles::new(files);
    let context = Context {
        loader: files,
        environment: &EmptyEnvironment,
        catalogue: &rovers::BUILD,
        specifications: &specifications,
        programs: &NoPrograms,
        settings: &[],
    };
    asmotion_plan::open("main.toml", &context)
}

/// Starts a composite, whose components have their first cycle.
fn started(composite: String) -> Simulation {
    let files = files(composite);
    let opened = planned(&files);
    let options = CoordinatorOptions::seeded(1);
    let mut workshop = Standard::new(&rovers::BUILD, &files, options);
    let system = asmotion_assembly::start(opened.plan(None).unwrap(), &mut workshop);
    let mut run = system.unwrap().simulate();
    run.run_for(Duration::ZERO);
    run
}

/// Returns the number of instructions of a process that does the work so many times.
fn instructions(row: &Row, size: u64, times: u64) -> f64 {
    let itself = std::env::current_exe().unwrap();
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(itself)
        .args(["run", row.name, &size.to_string(), &times.to_string()])
        .output()
        .expect("callgrind is part of valgrind");
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    let line = text.lines().find(|line| line.contains("Collected :"));
    let count = line.and_then(|line| line.rsplit(' ').next());
    count.unwrap_or_default().parse().expect(&text)
}

/// CPU time of this thread in nanoseconds, which does not contain the time of other processes.
fn cpu_time() -> f64 {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    let nanoseconds: u64 = statistics.split(' ').next().unwrap().parse().unwrap();
    nanoseconds as f64
}

/// Returns the CPU time of doing the work so many times, the least of a few turns.
fn time(row: &Row, size: u64, times: u64) -> f64 {
    let turns = (0..3).map(|_| {
        let begun = cpu_time();
        (row.work)(size, times);
        cpu_time() - begun
    });
    turns.fold(f64::INFINITY, f64::min)
}

/// Returns the cost of a unit of work from that of doing it once and four times.
fn of_a_unit(row: &Row, size: u64, cost: impl Fn(u64) -> f64) -> f64 {
    (cost(4) - cost(1)) / (3 * (row.units)(size)) as f64
}

/// The slope of the line through the logarithms of sizes and costs, by least squares.
fn slope(sizes: &[u64], costs: &[f64]) -> f64 {
    let points = || {
        let logarithms = sizes.iter().map(|size| (*size as f64).ln());
        logarithms.zip(costs.iter().map(|cost| cost.ln()))
    };
    let count = sizes.len() as f64;
    let (x, y) = points().fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
    let (x, y) = (x / count, y / count);
    let above: f64 = points().map(|point| (point.0 - x) * (point.1 - y)).sum();
    let below: f64 = points().map(|point| (point.0 - x).powi(2)).sum();
    above / below
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, name, size, times] = arguments.as_slice()
        && first == "run"
    {
        let row = ROWS.iter().find(|row| row.name == name).unwrap();
        return (row.work)(size.parse().unwrap(), times.parse().unwrap());
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("valgrind is missing: nothing was measured (Debian: apt install valgrind)");
        return;
    }
    let is_few = arguments.iter().any(|it| it == "--few");
    let selected: Vec<&String> = arguments.iter().filter(|it| !it.starts_with('-')).collect();
    println!("| row | cost of a | size | instructions | CPU time | slope | at most |");
    println!("|---|---|---|---|---|---|---|");
    let mut missed = Vec::new();
    for row in ROWS {
        if !selected.is_empty() && !selected.iter().any(|name| *name == row.name) {
            continue;
        }
        let sizes = if is_few { &row.sizes[..3] } else { &row.sizes };
        let mut costs = Vec::new();
        for size in sizes {
            let cost = of_a_unit(row, *size, |times| instructions(row, *size, times));
            costs.push(cost);
            let time = if is_few {
                String::new()
            } else {
                let time = of_a_unit(row, *size, |times| time(row, *size, times));
                format!("{time:.0} ns")
            };
            let (slope, limit) = if costs.len() == sizes.len() {
                let slope = slope(sizes, &costs);
                if slope > row.limit {
                    missed.push(row.name);
                }
                (format!("{slope:.3}"), row.limit.to_string())
            } else {
                (String::new(), String::new())
            };
            println!(
                "| {} | {} | {size} | {cost:.0} | {time} | {slope} | {limit} |",
                row.name, row.unit
            );
        }
    }
    assert!(missed.is_empty(), "the cost grows too fast: {missed:?}");
}
