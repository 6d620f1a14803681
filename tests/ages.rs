//! Limits of a connection that a composite sets (`size`, `max_age_ms`, `data`), as a run shows them: how old a command is when
//! it has an effect, and that each one which has none is counted and reported. In virtual time, live, and over a broker.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::faults::Heard;
use crate::processes::{Running, queues, through};

/// Number of commands sent, one each 5 ms.
const SENT: u64 = 200;

/// A command is its number, and the time in ms at which it was given.
const SOURCE: &str = "asm source
import StandardLibrary
import TimeLibrary
signature:
	controlled n: Integer
	out command: Integer
definitions:
	main rule r_Main = if n < 200 then par n := n + 1 command := (n + 1) * 100000 + mCurrTimeMillisecs endpar endif
default init s0:
	function n = 0
";

const SINK: &str = "asm sink
import StandardLibrary
signature:
	enum domain Mode = {COUNTING | ARRIVED}
	monitored command: Integer
	monitored given: Integer
	monitored lost: Integer
	controlled latest: Integer
	controlled seen: Integer
	controlled missed: Integer
	controlled mode: Mode
definitions:
	main rule r_Main =
		par
			if command > 0 and command != latest and given = 0 then par seen := seen + 1 latest := command endpar endif
			if lost > 0 then missed := missed + lost endif
			if seen + missed >= 200 then mode := ARRIVED endif
		endpar
default init s0:
	function latest = 0
	function seen = 0
	function missed = 0
	function mode = COUNTING
";

/// A source and a sink with this period and binding, joined by these ends under a policy.
fn composite(
    folder: &Path,
    period: u64,
    receive: &str,
    [from, to]: [&str; 2],
    policy: &str,
) -> PathBuf {
    std::fs::write(folder.join("source.asm"), SOURCE).unwrap();
    std::fs::write(folder.join("sink.asm"), SINK).unwrap();
    let text = format!(
        r#"schema = "composite/1"
[composite]
name = "ages"
[components.Source]
implementation = {{ asm = "source.asm" }}
activity = {{ period_ms = 5 }}
ports.out = {{ command = "builtin_interfaces/Time" }}
[components.Source.bind.out]
command = {{ topic = "command", field = "sec", publish = "on_update" }}
[components.Sink]
implementation = {{ asm = "sink.asm" }}
activity = {{ period_ms = {period} }}
ports.in = {{ command = "builtin_interfaces/Time" }}
[components.Sink.bind.monitored]
command = {{ topic = "command", receive = "{receive}", field = "sec", none = 0 }}
given = {{ topic = "command", receive = "{receive}", field = "nanosec", none = 0 }}
lost = {{ lost = "command" }}
[[connections]]
from = "{from}"
to = "{to}"
policy = {{ {policy} }}
[deploy]
processes = [ {{ name = "office", components = ["Source"] }}, {{ name = "onboard", components = ["Sink"] }} ]
"#
    );
    let path = folder.join("ages.composite.toml");
    std::fs::write(&path, text).unwrap();
    path
}

const DIRECT: [&str; 2] = ["Source.command", "Sink.command"];

/// A command that the sink has read.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Read {
    number: u64,
    /// Its age at that time, in ms.
    age: i64,
}

/// What a run shows of the commands.
#[derive(Debug, Default)]
struct Outcome {
    read: Vec<Read>,
    /// Commands lost according to the specification, and according to the summary.
    missed: u64,
    lost: u64,
    /// Reasons of the commands that did not reach the component, each once.
    reasons: Vec<String>,
    outcome: String,
}

impl Outcome {
    fn of(lines: &[Value]) -> Self {
        let mut this = Self::default();
        for line in lines {
            let updates = line["step"]["updates"].as_array().into_iter().flatten();
            for update in updates {
                let value = || update["after"].as_str().unwrap().parse().unwrap();
                if update["location"] == "latest" {
                    let (command, now): (u64, _) = (value(), line["t"].as_f64().unwrap() * 1e3);
                    this.read.push(Read {
                        number: command / 100_000,
                        age: now.round() as i64 - (command % 100_000) as i64,
                    });
                } else if update["location"] == "missed" {
                    this.missed = value();
                }
            }
            if line["type"] == "dropped" {
                let reason = line["reason"].as_str().unwrap_or("full").to_owned();
                this.reasons.push(reason);
            }
            for input in line["lost"].as_array().into_iter().flatten() {
                assert_eq!(input["input"], "Sink.command");
                this.lost += input["count"].as_u64().unwrap();
            }
            this.outcome = line["outcome"].as_str().unwrap_or_default().to_owned();
        }
        this
    }

    fn oldest(&self) -> i64 {
        self.read.iter().map(|read| read.age).max().unwrap()
    }

    fn numbers(&self) -> Vec<u64> {
        self.read.iter().map(|read| read.number).collect()
    }

    /// Checks that each command was read once, in order, or counted as lost everywhere.
    #[track_caller]
    fn assert_complete(&self) {
        assert!(
            self.numbers().is_sorted_by(|one, next| one < next),
            "{self:?}"
        );
        assert_eq!(self.outcome, "reached", "{self:?}");
        assert_eq!(self.read.len() as u64 + self.missed, SENT, "{self:?}");
        assert_eq!(self.missed, self.lost, "{self:?}");
    }
}

/// `asmotion run` of a composite for at most so many seconds.
fn run(composite: &Path, seconds: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args(["--json", "--for", seconds]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn lines(command: &mut Command) -> Vec<Value> {
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.stdout.is_empty(), "{errors}");
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .map(|it| serde_json::from_str(it).unwrap())
        .collect()
}

/// Runs in virtual time and live.
fn in_both_clocks(composite: &Path, seconds: &str, check: impl Fn(&Outcome, &str)) {
    for clock in ["virtual", "wall"] {
        let outcome = Outcome::of(&lines(run(composite, seconds).args(["--clock", clock])));
        check(&outcome, clock);
    }
}

#[test]
fn a_command_that_waited_too_long_for_its_step_is_discarded_counted_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    for (on_stale, limited) in [("no_data", true), ("zero", true), ("hold", false)] {
        // one of four commands is read, so that the others wait longer and longer
        let policy =
            format!("type = \"buffer\", size = 1000, max_age_ms = 100, on_stale = \"{on_stale}\"");
        let composite = composite(folder.path(), 20, "all", DIRECT, &policy);
        in_both_clocks(&composite, "30", |outcome, clock| {
            outcome.assert_complete();
            let oldest = outcome.oldest();
            // the time in a command is cut off to milliseconds
            assert_eq!(oldest <= 101, limited, "{on_stale}, {clock}: {outcome:?}");
            assert_eq!(
                outcome.missed > 0,
                limited,
                "{on_stale}, {clock}: {outcome:?}"
            );
        });
        let mut said = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let said = said.arg("run").arg(&composite).output().unwrap();
        let said =
            String::from_utf8(said.stderr).unwrap() + &String::from_utf8(said.stdout).unwrap();
        let notice = "messages for `command` waited for a step for longer than the `max_age_ms` of their connection";
        assert_eq!(said.matches(notice).count(), usize::from(limited), "{said}");
    }
}

#[test]
fn a_command_that_waited_too_long_for_its_cycle_is_discarded_counted_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    for (on_stale, limited) in [("no_data", true), ("zero", true), ("hold", false)] {
        // twenty commands arrive between two cycles
        let policy =
            format!("type = \"buffer\", size = 1000, max_age_ms = 30, on_stale = \"{on_stale}\"");
        let composite = composite(folder.path(), 100, "all", DIRECT, &policy);
        let lines = lines(run(&composite, "30").args(["--clock", "virtual"]));
        let outcome = Outcome::of(&lines);
        if limited {
            outcome.assert_complete();
            assert!(outcome.oldest() <= 31, "{outcome:?}");
            // the reasons name the limit
            let limit = "the limit of its connection is 30ms";
            assert!(
                outcome.reasons.iter().any(|it| it.contains(limit)),
                "{outcome:?}"
            );
        } else {
            assert!(outcome.oldest() > 1000, "{outcome:?}");
            assert!(outcome.reasons.is_empty(), "{outcome:?}");
        }
    }
}

#[test]
fn a_value_that_is_not_renewed_is_forgotten_by_the_specification_too() {
    let folder = tempfile::tempdir().unwrap();
    let sink = "asm sink
import StandardLibrary
signature:
	monitored command: Integer
	monitored given: Integer
	monitored lost: Integer
	controlled now: Integer
definitions:
	main rule r_Main = if command != now then now := command endif
default init s0:
	function now = -1
";
    for (on_stale, expected) in [("no_data", "7"), ("zero", "0"), ("hold", "200")] {
        let policy = format!("type = \"data\", max_age_ms = 100, on_stale = \"{on_stale}\"");
        let composite = composite(folder.path(), 20, "last", DIRECT, &policy);
        std::fs::write(folder.path().join("sink.asm"), sink).unwrap();
        let text = std::fs::read_to_string(&composite).unwrap();
        std::fs::write(&composite, text.replace("none = 0", "none = 7")).unwrap();
        for clock in ["virtual", "wall"] {
            let lines = lines(run(&composite, "3").args(["--clock", clock]));
            let updates = lines.iter().filter(|line| line["component"] == "Sink");
            let last = updates
                .flat_map(|line| line["step"]["updates"].as_array().into_iter().flatten())
                .filter_map(|update| update["after"].as_str())
                .next_back()
                .map(|value| value.parse::<u64>().unwrap());
            let last = last.map(|value| {
                if value < 100_000 {
                    value
                } else {
                    value / 100_000
                }
            });
            assert_eq!(last, Some(expected.parse().unwrap()), "{on_stale}, {clock}");
        }
    }
}

#[test]
fn the_size_of_a_queue_decides_which_commands_are_read() {
    let folder = tempfile::tempdir().unwrap();
    // numbers of the first commands that are read in virtual time: the sink reads one each 40 ms, in which eight are sent
    for (policy, receive, first, complete) in [
        ("type = \"buffer\", size = 4", "all", [1, 2, 3, 4], true),
        (
            "type = \"circular_buffer\", size = 4",
            "all",
            [1, 6, 14, 22],
            true,
        ),
        ("type = \"data\"", "last", [1, 9, 17, 25], false),
    ] {
        let composite = composite(folder.path(), 40, receive, DIRECT, policy);
        let seconds = if complete { "30" } else { "4" };
        in_both_clocks(&composite, seconds, |outcome, clock| {
            let numbers = outcome.numbers();
            assert!(
                numbers.is_sorted_by(|one, next| one < next),
                "{policy}: {numbers:?}"
            );
            if complete {
                outcome.assert_complete();
                assert!(outcome.missed > 100, "{policy}, {clock}: {outcome:?}");
            } else {
                // a newer value replaces an older one, which is no loss
                assert_eq!(outcome.lost, 0, "{policy}, {clock}: {outcome:?}");
                assert_eq!(
                    numbers.last(),
                    Some(&SENT),
                    "{policy}, {clock}: {outcome:?}"
                );
            }
            if clock == "virtual" {
                assert_eq!(numbers[..4], first, "{policy}: {outcome:?}");
            }
        });
    }
}

/// A driver that was stopped for longer than its commands are valid.
#[test]
fn commands_that_waited_at_the_broker_are_discarded_counted_and_reported() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for [from, to] in [DIRECT, ["topic:command", "Sink.command"]] {
        let vhost = broker.vhost().unwrap();
        let policy = "type = \"buffer\", size = 1000, max_age_ms = 500, on_stale = \"no_data\"";
        let composite = composite(folder.path(), 5, "all", [from, to], policy);
        if from.starts_with("topic:") {
            let text = std::fs::read_to_string(&composite).unwrap();
            let text = text.replace("ports.out =", "publish =");
            std::fs::write(&composite, text).unwrap();
        }
        let mut onboard = through(run(&composite, "60"), &broker, &vhost, Some("onboard"));
        let (mut heard, mut lines) = (Heard::start(&mut onboard), Vec::new());
        queues(&vhost, "robots.services.ages.control.onboard");
        let mut office = through(run(&composite, "60"), &broker, &vhost, Some("office"));
        let office = Running::start(&mut office);
        let is_tenth = |line: &Value| {
            Outcome::of(std::slice::from_ref(line))
                .read
                .iter()
                .any(|it| it.number >= 10)
        };
        heard.until(&mut lines, is_tenth).expect("commands arrive");
        heard.signal("-STOP");
        std::thread::sleep(std::time::Duration::from_secs(2));
        heard.signal("-CONT");
        let summary = heard.until(&mut lines, |line| line["type"] == "summary");
        assert!(summary.is_some(), "{:?}", Outcome::of(&lines));
        let outcome = Outcome::of(&lines);
        outcome.assert_complete();
        assert!(outcome.missed > 0 && outcome.missed < SENT, "{outcome:?}");
        drop(office);
    }
}
