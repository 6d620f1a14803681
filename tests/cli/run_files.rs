//! The trace and the table that a run writes: opened before it, and complete up to the last second if its process is killed.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{NAVIGATION, run};

/// Sends counts from the first step on, and alarms from its 40th step on, so that a column appears late.
const COUNTER: &str = "asm counter
import StandardLibrary
signature:
	controlled n: Integer
	out count: Integer
	out alarm: Boolean
definitions:
	main rule r_Main = par n := n + 1 count := n if n > 40 then alarm := true endif endpar
default init s0:
	function n = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "counted"
[components.Counter]
implementation = { asm = "counter.asm" }
activity = { period_ms = 50 }
publish = { count = "std_msgs/Int32", alarm = "std_msgs/Bool" }
[components.Counter.bind.out]
count = { topic = "count", field = "data", publish = "every_step" }
alarm = { topic = "alarm", field = "data", publish = "on_update" }
"#;

fn composite(folder: &Path) -> String {
    std::fs::write(folder.join("counter.asm"), COUNTER).unwrap();
    let composite = folder.join("counted.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    composite.display().to_string()
}

/// The rows of a table, each of which has a cell for each column.
fn rows(table: &str) -> Vec<Vec<&str>> {
    let rows: Vec<Vec<&str>> = table.lines().map(|row| row.split(',').collect()).collect();
    for row in &rows {
        assert_eq!(row.len(), rows[0].len(), "{table}");
    }
    rows
}

#[test]
fn a_process_that_is_killed_leaves_its_trace_and_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let composite = composite(folder.path());
    let (trace, table) = (folder.path().join("run.txt"), folder.path().join("run.csv"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(["run", &composite, "--clock", "wall", "--trace"]);
    command.arg(&trace).arg("--record").arg(&table);
    let mut process = command.stderr(Stdio::null()).spawn().unwrap();
    let text = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    let until = Instant::now() + Duration::from_secs(60);
    while !text(&table).contains("true") || !text(&trace).contains("alarm") {
        assert!(Instant::now() < until, "{}", text(&table));
        std::thread::sleep(Duration::from_millis(50));
    }
    // Rust's `kill` is SIGKILL
    process.kill().unwrap();
    process.wait().unwrap();
    let (trace, table) = (text(&trace), text(&table));
    assert!(trace.ends_with('\n'), "{trace}");
    assert!(
        trace.matches("report Counter asm/Step ").count() > 40,
        "{trace}"
    );
    let rows = rows(&table);
    assert_eq!(
        rows[0],
        ["time_s", "Counter.count.data", "Counter.alarm.data"]
    );
    // the first row is there once, with an empty cell in the later column
    assert_eq!(rows[1][1..], ["0", ""], "{table}");
    let counts = rows[1..].iter().map(|row| row[1].parse().unwrap());
    let counts: Vec<usize> = counts.collect();
    assert_eq!(counts, Vec::from_iter(0..counts.len()), "{table}");
}

#[test]
fn a_run_in_real_time_writes_all_its_events() {
    let folder = tempfile::tempdir().unwrap();
    let composite = composite(folder.path());
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (trace, table) = (path("run.txt"), path("run.csv"));
    let files = ["--trace", &trace, "--record", &table];
    let timed = ["run", &composite, "--clock", "wall", "--for", "3"];
    let (code, out, err) = run(&[&timed[..], &files].concat());
    assert_eq!(code, 0, "{out}{err}");
    let trace = std::fs::read_to_string(trace).unwrap();
    let table = std::fs::read_to_string(table).unwrap();
    let sent = trace.matches(" publish Counter.count ").count();
    assert!(sent > 45, "{trace}");
    assert_eq!(rows(&table).len(), sent + 1, "{table}");
}

#[test]
fn a_file_that_cannot_be_written_is_reported_before_the_run() {
    for option in ["--trace", "--record"] {
        let (code, out, err) = run(&["run", NAVIGATION, option, "/nowhere/run.csv"]);
        assert_eq!((code, &*out), (2, ""), "{err}");
        assert!(err.contains("cannot write `/nowhere/run.csv`"), "{err}");
        assert!(!err.contains("Running"), "{err}");
    }
    // a disk that is full later ends neither the run nor its other output
    let (code, out, err) = run(&["run", NAVIGATION, "--trace", "/dev/full", "--quiet"]);
    assert_eq!(code, 2, "{out}{err}");
    assert!(err.contains("cannot write `/dev/full`"), "{err}");
}

#[test]
fn a_run_that_is_refused_leaves_files_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (old, new, wrong) = (path("old.csv"), path("new.txt"), path("w.composite.toml"));
    std::fs::write(&old, "time_s\n").unwrap();
    std::fs::write(&wrong, "schema = \"composite/1\"\n").unwrap();
    let (code, _, err) = run(&["run", &wrong, "--record", &old, "--trace", &new]);
    assert_eq!(code, 1, "{err}");
    assert_eq!(std::fs::read_to_string(&old).unwrap(), "time_s\n");
    assert!(!Path::new(&new).exists());
}
