//! Measures the CPU time that a recording costs: the navigation in real time with a coordinator that makes 1000 steps a second, with
//! and without a recording in turns.
//!
//! `cargo bench --bench recording` prints the table of `docs/benchmarks.md`. It fails if a message is lost, or if the recording costs
//! more than a tenth of a core.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a bench fails by panicking and prints its figures"
)]

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use asmotion::mission::{Mission, MissionClock, MissionEnd, RecordingRequest};
use asmotion_recording::{RecordingItem, RunReader};

/// Greatest cost of a recording, as a share of a core.
const LIMIT: f64 = 0.1;

/// Unit of CPU times in `/proc/self/stat`, in s: `USER_HZ` is 100 on every platform with Linux's usual ABI.
const TICK: f64 = 0.01;

/// Total cost of the runs of one kind.
#[derive(Default)]
struct Total {
    cpu_s: f64,
    wall_s: f64,
    steps: u64,
    bytes: u64,
}

/// CPU time of this process and its threads so far, in s.
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    // the name of the program, in parentheses, may contain blanks
    let fields = stat.rsplit_once(')').unwrap().1.split_whitespace();
    let times = fields
        .skip(11)
        .take(2)
        .map(|ticks| ticks.parse::<f64>().unwrap());
    times.sum::<f64>() * TICK
}

/// Runs the mission for a time. Returns its end and what it took.
fn run(composite: &Path, seconds: u64, file: Option<&Path>, total: &mut Total) -> MissionEnd {
    let mut mission = Mission::new(composite.to_string_lossy());
    mission.clock = MissionClock::Wall;
    mission.limit = Some(Duration::from_secs(seconds));
    mission.notice = |_| {};
    mission.recording = RecordingRequest {
        file: file.map(|file| file.to_string_lossy().into_owned()),
        ..RecordingRequest::default()
    };
    let before = cpu_s();
    let end = mission.run(|_, _| {}, |_, _, _| {}, &AtomicBool::new(false));
    let end = end.unwrap_or_else(|error| panic!("{error}"));
    total.cpu_s += cpu_s() - before;
    total.wall_s += end.wall.as_secs_f64();
    total.bytes += end
        .recording
        .as_ref()
        .map_or(0, |recording| recording.bytes);
    end
}

/// Number of steps in a recording, all of them intact.
fn steps(file: &Path) -> u64 {
    let steps = RunReader::open(file).unwrap().filter(|item| match item {
        RecordingItem::Step { step, .. } => step.is_intact,
        RecordingItem::Text { .. } | RecordingItem::Message { .. } | RecordingItem::End(_) => false,
        RecordingItem::Cut(reason) => panic!("{reason}"),
    });
    steps.count() as u64
}

fn main() {
    // `cargo test` runs it once, for a moment, and without a limit: it may have much else to do
    let is_bench = std::env::args().any(|argument| argument == "--bench");
    let (rounds, seconds) = if is_bench { (6, 10) } else { (1, 1) };
    let folder = tempfile::tempdir().unwrap();
    let base =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation/navigation.composite.toml");
    let composite = folder.path().join("fast.composite.toml");
    let text = format!(
        "schema = \"composite/1\"\nbase = \"{}\"\n[components.ASMCoordinator]\ntask = {{ period_ms = 1 }}\n",
        base.display()
    );
    std::fs::write(&composite, text).unwrap();
    let (mut without, mut with) = (Total::default(), Total::default());
    let mut lost = 0;
    for round in 0..rounds {
        run(&composite, seconds, None, &mut without);
        let file = folder.path().join(format!("{round}.mcap"));
        let recording = run(&composite, seconds, Some(&file), &mut with)
            .recording
            .unwrap();
        lost += recording.lost;
        assert!(recording.is_complete(), "{recording:?}");
        with.steps += steps(&file);
        std::fs::remove_file(&file).unwrap();
    }
    let share = |total: &Total| total.cpu_s / total.wall_s;
    let cost = share(&with) - share(&without);
    println!("| | without | with | cost |\n|---|---|---|---|");
    println!(
        "| CPU, % of a core | {:.1} | {:.1} | {:.1} |",
        100.0 * share(&without),
        100.0 * share(&with),
        100.0 * cost
    );
    let rate = |total: u64| total as f64 / with.wall_s;
    let (steps, bytes) = (rate(with.steps), rate(with.bytes) / 1e3);
    println!("\n{steps:.0} steps/s, {bytes:.0} kB/s, {lost} messages lost");
    assert!(
        !is_bench || steps > 950.0,
        "{steps} steps/s: the machine is overloaded"
    );
    assert!(
        !is_bench || cost <= LIMIT,
        "recording costs {cost:.3} of a core"
    );
}
