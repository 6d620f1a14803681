//! C18: components with topics, services and wires over a broker are added to running processes and removed from them.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use asmotion_broker::{SharedBroker, Vhost};
use serde_json::Value;

use crate::hostile::Peer;
use crate::processes::{Running, queues, run_any, through, tool};
use crate::stranger::python;

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(60);

const SOURCE: &str = "asm source
import StandardLibrary
signature:
	out n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

const SINK: &str = "asm sink
import StandardLibrary
signature:
	monitored echo: Integer
	controlled seen: Integer
	controlled newest: Integer
definitions:
	main rule r_Main =
		if echo != 0 then
			par
				seen := seen + 1
				newest := echo
			endpar
		endif
default init s0:
	function seen = 0
	function newest = 0
";

const ECHO: &str = "asm echo
import StandardLibrary
signature:
	monitored tick: Integer
	out heard: Integer
definitions:
	main rule r_Main = if tick > 0 then heard := tick endif
default init s0:
	function heard = 0
";

pub(super) const ADDER: &str = "asm adder
import StandardLibrary
import CommonBehavior
signature:
	controlled argument: Integer
	out double: Prod(Agent, Integer) -> Integer
definitions:
	main rule r_Main =
		if nextRequest(self) = \"double\" then
			seq
				r_wreceive[undef, \"double\", argument]
				r_wreply[undef, \"double\", argument + argument]
			endseq
		endif
default init s0:
	function argument = 0
";

/// Asks again and again; a fault ends a call.
pub(super) const ASKER: &str = "asm asker
import StandardLibrary
import CommonBehavior
signature:
	enum domain Mode = {ASKING | ANSWERED | LOST}
	domain Services subsetof Agent
	static sums: Services
	controlled mode: Mode
	controlled answer: Integer
	out double: Prod(Services, Integer) -> Integer
definitions:
	main rule r_Main =
		if isDef(callFault(self, \"double\")) then
			par
				mode := LOST
				r_wcancel[sums, \"double\"]
			endpar
		else
			if isDef(answer) then
				par
					if answer = 8 then mode := ANSWERED endif
					answer := undef
				endpar
			else
				r_wcall[sums, \"double\", 4, 2000, answer]
			endif
		endif
default init s0:
	function mode = ASKING
";

/// What both versions have.
const KEPT: &str = r#"
schema = "composite/1"
[composite]
name = "relayed"
[components.Source]
implementation = { asm = "source.asm" }
activity = { period_ms = 20 }
publish = { tick = "builtin_interfaces/Time" }
bind.out.n = { topic = "tick", field = "sec", publish = "on_update" }
[components.Sink]
implementation = { asm = "sink.asm" }
activity = { period_ms = 20 }
subscribe = { echo = "builtin_interfaces/Time" }
bind.monitored.echo = { topic = "echo", receive = "all", field = "sec", none = 0 }
[components.Asker]
implementation = { asm = "asker.asm" }
task = { period_ms = 20 }
references = { sums = { interface = "test/Adds", optional = true } }
"#;

/// The components that are added and removed, and the wire between the processes.
const ADDED: &str = r#"
[components.Echo]
implementation = { asm = "echo.asm" }
task = { id = "repeater", period_ms = 20 }
subscribe = { tick = "builtin_interfaces/Time" }
publish = { echo = "builtin_interfaces/Time" }
bind.monitored.tick = { topic = "tick", receive = "all", field = "sec", none = 0 }
bind.out.heard = { topic = "echo", field = "sec", publish = "on_update" }
lifecycle = { safe = { echo = { sec = -1 } } }
[components.Adder]
implementation = { asm = "adder.asm" }
task = { period_ms = 20 }
services = { adding = "test/Adds" }
[[wires]]
reference = "Asker.sums"
service = "Adder.adding"
timeout_ms = 2000
"#;

const APART: &str = r#"
[deploy]
processes = [
  { name = "near", components = ["Source", "Asker"] },
  { name = "far", components = ["Sink", "Echo", "Adder"] },
]
"#;

/// A composite that changes while its processes run.
struct Relayed<'b> {
    broker: &'b SharedBroker,
    vhost: &'b Vhost<'b>,
    path: PathBuf,
    processes: &'static str,
}

impl<'b> Relayed<'b> {
    fn new(
        folder: &Path,
        broker: &'b SharedBroker,
        vhost: &'b Vhost<'b>,
        processes: &'static str,
    ) -> Self {
        for (name, text) in [
            ("source", SOURCE),
            ("sink", SINK),
            ("echo", ECHO),
            ("adder", ADDER),
            ("asker", ASKER),
        ] {
            std::fs::write(folder.join(format!("{name}.asm")), text).unwrap();
        }
        let path = folder.join("relayed.composite.toml");
        Self {
            broker,
            vhost,
            path,
            processes,
        }
    }

    fn write(&self, added: &str) {
        let processes = match added {
            "" => self.processes.replace(", \"Echo\", \"Adder\"", ""),
            _ => self.processes.to_owned(),
        };
        std::fs::write(&self.path, format!("{KEPT}{added}{processes}")).unwrap();
    }

    fn run(&self, process: Option<&str>) -> Command {
        let mut command = through(run_any(&self.path), self.broker, self.vhost, process);
        command.stdout(std::process::Stdio::null());
        command
    }

    fn tool(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let (user, address) = (self.broker.user(), self.broker.address());
        let url = format!("amqp://{user}@{address}/{}", self.vhost.name());
        tool(self.broker, &url, arguments)
    }

    /// Changes the running processes to a version. Returns the changes.
    #[track_caller]
    fn becomes(&self, added: &str) -> String {
        self.write(added);
        let (code, out, err) = self.tool(&["reconfigure", self.path.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{out}{err}");
        out
    }

    /// Waits until `component info` contains a text. Returns it.
    #[track_caller]
    fn shows(&self, component: &str, is_shown: impl Fn(&str) -> bool) -> String {
        let until = Instant::now() + LONG;
        loop {
            let (_, out, err) = self.tool(&["component", "info", component]);
            if is_shown(&out) {
                return out;
            }
            assert!(Instant::now() < until, "{component}: {out}{err}");
        }
    }

    /// Waits until no queue of the broker contains a text.
    #[track_caller]
    fn no_queue(&self, text: &str) {
        let until = Instant::now() + LONG;
        loop {
            let queues = self.vhost.queues().unwrap();
            if !queues.iter().any(|queue| queue.contains(text)) {
                return;
            }
            assert!(Instant::now() < until, "{text}: {queues:?}");
        }
    }
}

/// The number that the last step with updates has written to a location.
fn written(shown: &str, location: &str) -> i64 {
    let after = shown.split_once(&format!("{location} := "));
    let number = after.and_then(|(_, rest)| rest.split([',', ' ', '\n']).next()?.parse().ok());
    number.unwrap_or_default()
}

/// The numbers that a peer has heard on a topic.
fn seconds(messages: &[Value]) -> Vec<i64> {
    let contents = messages.iter().map(|it| &it["content"]["sec"]);
    contents.map(|it| it.as_i64().unwrap()).collect()
}

/// The components are added, used and removed as often as `rounds` says, while a foreign program takes part.
fn is_added_and_removed(relayed: &Relayed<'_>, processes: &[Option<&str>], rounds: usize) {
    let python = python().unwrap();
    let vhost = relayed.vhost;
    relayed.write("");
    let recording = |process: &Option<&str>| {
        let name = format!("{}.mcap", process.unwrap_or("relayed"));
        relayed.path.with_file_name(name)
    };
    let start = |process: &Option<&str>| {
        let mut command = relayed.run(*process);
        Running::start(command.arg("--record").arg(recording(process)))
    };
    let running: Vec<Running> = processes.iter().map(start).collect();
    for process in processes {
        let name = process.unwrap_or("relayed");
        queues(vhost, &format!("robots.services.relayed.control.{name}"));
    }
    let mut peer = Peer::start(python, &vhost.url(), &["relayed.echo"]);
    relayed.shows("Asker", |it| it.contains("mode = LOST"));
    let mut seen = 0;
    let mut foreign = 1_000_000;
    for _ in 0..rounds {
        let changes = relayed.becomes(ADDED);
        for change in [
            "`Echo` is added and runs `echo.asm`",
            "`Adder` is added and runs `adder.asm`",
            "`Asker.sums` is wired to `Adder.adding`",
        ] {
            assert!(changes.contains(change), "{change}: {changes}");
        }
        // its queues have its name outside
        queues(vhost, "robots.services.relayed.Adder.adding.double");
        let has_queue = |queue: &String| queue.contains("repeater");
        assert!(vhost.queues().unwrap().iter().any(has_queue));
        // topics from and to another process, and a call across
        let before = seen;
        let shown = relayed.shows("Sink", |it| written(it, "seen") > before);
        assert!(shown.contains("Running"), "{shown}");
        relayed.shows("Asker", |it| it.contains("mode = ANSWERED"));
        // a stranger publishes and hears
        foreign += 1;
        let message = serde_json::json!({ "sec": foreign, "nanosec": 0 }).to_string();
        peer.send(&serde_json::json!({ "key": "relayed.tick", "body": message }));
        peer.wait_for("relayed.echo", |heard| seconds(heard).contains(&foreign));
        let (_, topics, err) = relayed.tool(&["topic", "list"]);
        let row = topics
            .lines()
            .find(|it| it.contains("echo"))
            .unwrap_or_default();
        assert!(
            row.contains("repeater") && row.contains("Sink"),
            "{topics}{err}"
        );
        let (_, out, err) = relayed.tool(&["component", "info", "Echo"]);
        assert!(out.contains("Running"), "{out}{err}");

        let changes = relayed.becomes("");
        assert!(changes.contains("`Echo` is removed"), "{changes}");
        assert!(
            changes.contains("`Asker.sums` is unwired from `Adder.adding`"),
            "{changes}"
        );
        // the safe value is the last one
        let heard = peer.wait_for("relayed.echo", |heard| seconds(heard).last() == Some(&-1));
        let shown = relayed.shows("Sink", |it| written(it, "newest") == -1);
        seen = written(&shown, "seen");
        assert_eq!(
            heard.len() as i64,
            seen,
            "nothing is lost, and nothing comes twice"
        );
        relayed.no_queue("repeater");
        relayed.no_queue("robots.services.relayed.Adder.");
        let (_, out, err) = relayed.tool(&["component", "list"]);
        assert!(!out.contains("Echo") && out.contains("Sink"), "{out}{err}");
        relayed.shows("Asker", |it| it.contains("mode = LOST"));
    }
    for process in running {
        let output = process.interrupt();
        assert!(output.status.success() || processes == [None], "{output:?}");
    }
    for process in processes {
        let recorded = recording(process);
        let (code, out, err) = relayed.tool(&["replay", recorded.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{out}{err}");
        assert!(
            process == &Some("near") || out.contains("Echo"),
            "{out}{err}"
        );
    }
}

#[test]
fn c18_a_component_with_topics_and_services_of_a_broker_is_added_removed_and_added_again() {
    let (Some(broker), Some(_)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let relayed = Relayed::new(folder.path(), &broker, &vhost, APART);
    is_added_and_removed(&relayed, &[Some("near"), Some("far")], 2);
}

#[test]
fn c18_a_process_with_everything_over_the_broker_gets_and_loses_components() {
    let (Some(broker), Some(_)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let relayed = Relayed::new(folder.path(), &broker, &vhost, "");
    is_added_and_removed(&relayed, &[None], 1);
}
