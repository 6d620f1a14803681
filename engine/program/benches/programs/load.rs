//! Fifty components with a program each, at 200 Hz.

use std::path::Path;
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Component, Interface, Policy};
use asmotion_program::ProgramCommand;
use asmotion_runtime::{Run, System};

use crate::echo::sample_schema;
use crate::round_trip::{Kind, Source, add_echo};

const COMPONENTS: usize = 50;

const PERIOD: Duration = Duration::from_millis(5);

/// Time until the measurement begins, and its duration.
const WARM_UP: Duration = Duration::from_secs(2);
const MEASURED: Duration = Duration::from_secs(10);

/// Runs the system, in which each program receives and returns a sample in each cycle, and prints its load.
pub(crate) fn table(language: &str, command: &ProgramCommand) {
    let mut system = System::new();
    let make = |interface: &mut Interface| {
        let output = interface.output_of("out", sample_schema(), "");
        Box::new(Source { output, number: 0 }) as Box<dyn Component>
    };
    let activity = Activity::periodic(PERIOD);
    system.add("Source", activity.clone(), make).unwrap();
    let kind = Kind::Program(command.clone());
    let names: Vec<String> = (0..COMPONENTS).map(|it| format!("P{it}")).collect();
    for name in &names {
        add_echo(&mut system, name, &kind, activity.clone());
        let input = format!("{name}.in");
        system
            .connect("Source.out", &input, Policy::data())
            .unwrap();
    }
    let mut run = system.live();
    run.run_for(WARM_UP);
    let sum = |run: &dyn Fn(&str) -> u64| names.iter().map(|name| run(name)).sum::<u64>();
    let count = |run: &asmotion_runtime::Live| {
        let cycles = sum(&|name| run.cycles(name));
        let missed = sum(&|name| run.overruns(name));
        (cycles, missed)
    };
    let (cycles, missed) = count(&run);
    // reading the times takes a while on a busy machine, both times
    let begin = Instant::now();
    let (engine, programs) = processor_times();
    run.run_for(MEASURED.saturating_sub(begin.elapsed()));
    let took = begin.elapsed().as_secs_f64();
    let (later_engine, later_programs) = processor_times();
    let (later_cycles, later_missed) = count(&run);
    let share = |from: f64, to: f64| (to - from) / took * 100.0;
    let longest = names.iter().map(|name| run.cycle_time(name).longest);
    println!(
        "\n{COMPONENTS} programs in {language} at {} Hz, {took:.1} s: {} cycles, {} periods missed, longest cycle since the start {:.1?}\n\
         processor: engine {:.0} % of a core, programs {:.0} %",
        1.0 / PERIOD.as_secs_f64(),
        later_cycles - cycles,
        later_missed - missed,
        longest.max().unwrap_or_default(),
        share(engine, later_engine),
        share(programs, later_programs),
    );
    run.stop();
}

/// Processor time of this process and of its children so far (s), as the scheduler counts it.
fn processor_times() -> (f64, f64) {
    let own = std::process::id();
    let mut times = (0.0, 0.0);
    for process in std::fs::read_dir("/proc").unwrap().flatten() {
        // `self` is one of them
        if process
            .file_name()
            .to_string_lossy()
            .parse::<u32>()
            .is_err()
        {
            continue;
        }
        // a process may end meanwhile
        let Ok(text) = std::fs::read_to_string(process.path().join("stat")) else {
            continue;
        };
        let (head, rest) = text.rsplit_once(')').unwrap();
        let parent = rest.split(' ').nth(2);
        if head.starts_with(&format!("{own} ")) {
            times.0 += time_of_threads(&process.path());
        } else if parent == Some(&own.to_string()) {
            times.1 += time_of_threads(&process.path());
        }
    }
    times
}

fn time_of_threads(process: &Path) -> f64 {
    let threads = std::fs::read_dir(process.join("task"))
        .into_iter()
        .flatten();
    let times = threads.flatten().map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).unwrap_or_default();
        let nanos = text.split(' ').next().and_then(|it| it.parse::<f64>().ok());
        nanos.unwrap_or_default() * 1e-9
    });
    times.sum()
}
