//! The queues on the way from a topic to a specification, and the losses that a run reports.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::faults::{Heard, enters};
use crate::processes::{queues, run_any, through, tool};

/// Number of messages sent.
const SENT: u64 = 1000;

const SOURCE: &str = "asm source
import StandardLibrary
signature:
	out n: Integer
definitions:
	main rule r_Main = if n < 1000 then n := n + 1 endif
default init s0:
	function n = 0
";

const SINK: &str = "asm sink
import StandardLibrary
signature:
	enum domain Mode = {COUNTING | ARRIVED}
	monitored tick: Integer
	monitored lost: Integer
	controlled seen: Integer
	controlled missed: Integer
	controlled mode: Mode
definitions:
	main rule r_Main =
		par
			if tick > 0 then seen := seen + 1 endif
			if lost > 0 then missed := missed + lost endif
			if seen + missed >= 1000 then mode := ARRIVED endif
		endpar
default init s0:
	function seen = 0
	function missed = 0
	function mode = COUNTING
";

/// A composite whose source sends 200 messages a second, and whose sink takes 50 a second from a queue of this size.
pub(super) fn counting(folder: &Path, size: u64) -> PathBuf {
    std::fs::write(folder.join("source.asm"), SOURCE).unwrap();
    std::fs::write(folder.join("sink.asm"), SINK).unwrap();
    let text = format!(
        r#"schema = "composite/1"
[composite]
name = "counting"
[components.Source]
implementation = {{ asm = "source.asm" }}
activity = {{ period_ms = 5 }}
publish = {{ tick = "builtin_interfaces/Time" }}
[components.Source.bind.out]
n = {{ topic = "tick", field = "sec", publish = "on_update" }}
[components.Sink]
implementation = {{ asm = "sink.asm" }}
activity = {{ period_ms = 20 }}
ports.in = {{ tick = "builtin_interfaces/Time" }}
[components.Sink.bind.monitored]
tick = {{ topic = "tick", receive = "all", field = "sec", none = 0 }}
lost = {{ lost = "tick" }}
[[connections]]
from = "topic:tick"
to = "Sink.tick"
policy = {{ type = "buffer", size = {size} }}
[topics.tick]
confirm = true
outage = "queue"
size = 100000
"#
    );
    let path = folder.join("counting.composite.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// The last value of a location in the steps of a run; 0 if it was never written.
fn value(lines: &[Value], location: &str) -> u64 {
    let steps = lines.iter().filter(|line| line["type"] == "step");
    let mut updates = steps.flat_map(|line| line["step"]["updates"].as_array().unwrap());
    let last = updates.rfind(|update| update["location"] == location);
    last.map_or(0, |update| {
        update["after"].as_str().unwrap().parse().unwrap()
    })
}

#[test]
fn every_loss_reaches_the_specification_the_summary_and_the_json() {
    let folder = tempfile::tempdir().unwrap();
    for (size, loses) in [(2000, false), (100, true)] {
        let composite = counting(folder.path(), size);
        let output = run_any(&composite).output().unwrap();
        let out = String::from_utf8(output.stdout).unwrap();
        let lines: Vec<Value> = out
            .lines()
            .map(|it| serde_json::from_str(it).unwrap())
            .collect();
        let (seen, missed) = (value(&lines, "seen"), value(&lines, "missed"));
        assert_eq!((seen + missed, missed > 0), (SENT, loses), "{size}");
        let summary = lines.last().unwrap();
        assert_eq!(summary["outcome"], "reached");
        let inputs = summary["lost"].as_array().unwrap();
        let lost = inputs
            .iter()
            .map(|it| (it["input"].as_str().unwrap(), it["count"].as_u64().unwrap()));
        let expected: &[_] = if loses { &[("Sink.tick", missed)] } else { &[] };
        assert_eq!(lost.collect::<Vec<_>>(), expected);
        // the queue of the coordinator is the one that overflows here
        let reported = lines.iter().rfind(|line| line["type"] == "losses");
        let reported = reported.map_or(0, |line| line["dropped"].as_u64().unwrap());
        assert_eq!(reported, missed);
        let text = Command::new(env!("CARGO_BIN_EXE_asmotion"))
            .args(["run", "-q"])
            .arg(&composite)
            .stderr(Stdio::null())
            .output()
            .unwrap();
        let text = String::from_utf8(text.stdout).unwrap();
        let line = format!("lost       {missed} messages to Sink.tick");
        assert_eq!(text.contains(&line), loses, "{text}");
    }
}

#[test]
fn a_loss_is_shown_per_input_by_component_info_and_counted_once() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut command = run_any(&counting(folder.path(), 100));
    // runs on after the last message
    command.args(["--until", "seen=1000000"]);
    let mut command = through(command, &broker, &vhost, None);
    command.stderr(Stdio::null());
    let (mut heard, mut lines) = (Heard::start(&mut command), Vec::new());
    queues(&vhost, "robots.services.counting.control.");
    let last = heard.until(&mut lines, enters("ARRIVED"));
    assert!(last.is_some());
    let missed = value(&lines, "missed");
    assert_eq!(value(&lines, "seen") + missed, SENT);
    assert!(missed > 0);
    let shown = format!("tick: builtin_interfaces/Time, {missed} messages lost");
    let until = Instant::now() + Duration::from_secs(20);
    loop {
        let (_, info, said) = tool(&broker, &vhost.url(), &["component", "info", "Sink"]);
        if info.contains(&shown) {
            break;
        }
        assert!(Instant::now() < until, "{shown}: {info}{said}");
    }
    heard.signal("-INT");
    let summary = heard.until(&mut lines, |line| line["type"] == "summary");
    let input = &summary.unwrap()["lost"][0];
    assert_eq!(
        (&input["input"], &input["count"]),
        (&"Sink.tick".into(), &missed.into())
    );
}

#[test]
fn nothing_is_lost_through_an_outage_with_a_written_queue() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = counting(folder.path(), 2000);
    let mut command = through(run_any(&composite), &broker, &vhost, None);
    command.stderr(Stdio::null());
    let (mut heard, mut lines) = (Heard::start(&mut command), Vec::new());
    heard
        .until(&mut lines, |line| {
            value(std::slice::from_ref(line), "seen") >= 10
        })
        .unwrap();
    broker.kill().unwrap();
    // more messages than any default holds
    std::thread::sleep(Duration::from_secs(3));
    broker.revive().unwrap();
    let summary = heard.until(&mut lines, |line| line["type"] == "summary");
    let summary = summary.unwrap();
    assert_eq!(summary["outcome"], "reached");
    assert_eq!((value(&lines, "seen"), value(&lines, "missed")), (SENT, 0));
    assert_eq!(summary["lost"], serde_json::json!([]));
}
