//! Runs on a terminal: what the monitor shows at the end, and that a run stops in order when its terminal is closed.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::stranger::python;

/// Runs a command on a terminal, which is closed once each text has been shown as often as its number says. Returns the lines of
/// `terminal.py`.
fn on_a_terminal(arguments: &[&str], texts: &[(&str, usize)]) -> Vec<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/terminal/terminal.py");
    let mut command = Command::new(python().expect("Python"));
    command.arg(script).arg("60");
    command.arg(env!("CARGO_BIN_EXE_asmotion")).args(arguments);
    command.env("TERM", "xterm").env("CI", "");
    let mut running = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = running.stdin.take().unwrap();
    for (text, times) in texts {
        writeln!(input, "{text} {times}").unwrap();
    }
    drop(input);
    let output = running.wait_with_output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// The last line about a command whose summary could not be written.
const ENDED: &str = "ended 2";

#[test]
fn a_run_that_has_ended_shows_its_last_control_state() {
    // once in the headline, and once in the row of the coordinator
    let texts = [("ended: reached in ARRIVED", 1), ("ARRIVED", 2)];
    let lines = on_a_terminal(&["demo", "--top", "--speed", "0"], &texts);
    assert_eq!(lines, ["shown 1", "shown 2", ENDED]);
}

#[test]
fn a_run_stops_in_order_when_its_terminal_is_closed() {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation");
    let composite = specs.join("navigation.composite.toml");
    let composite = composite.to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    for more in [["--goal", "26.4,4.2"].as_slice(), &["--top"]] {
        let trace = folder.path().join("run.trace");
        let trace = trace.to_str().unwrap();
        let arguments = ["run", composite, "--clock", "wall", "--trace", trace];
        // a part of FOLLOWING: letters that were there before are not written again
        let lines = on_a_terminal(&[&arguments, more].concat(), &[("LOWING", 1)]);
        assert_eq!(lines.last().map(String::as_str), Some(ENDED), "{lines:?}");
        let trace = std::fs::read_to_string(trace).unwrap();
        for component in ["ASMCoordinator", "RoverDriver"] {
            let stopped = format!(" life {component} Running Stopped\n");
            assert!(trace.contains(&stopped), "{more:?}: {component}");
        }
    }
}
