//! C18: specifications that stay are bound to further topics of a broker, in processes of their own or in one.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use asmotion_broker::{SharedBroker, Vhost};
use serde_json::{Value, json};

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
	monitored tick: Integer
	controlled seen: Integer
	controlled newest: Integer
definitions:
	main rule r_Main =
		if tick > 0 then
			par
				seen := seen + 1
				newest := tick
			endpar
		endif
default init s0:
	function seen = 0
	function newest = 0
";

const COMPOSITE: &str = r#"
schema = "composite/1"
[composite]
name = "bound"
[components.Source]
implementation = { asm = "source.asm" }
activity = { period_ms = 20 }
publish = { tick = "builtin_interfaces/Time" }
bind.out.n = { topic = "tick", field = "sec", publish = "on_update" }
[components.Sink]
implementation = { asm = "sink.asm" }
activity = { period_ms = 10 }
subscribe = { tick = "builtin_interfaces/Time" }
bind.monitored.tick = { topic = "tick", receive = "all", field = "sec", none = 0 }
"#;

const APART: &str = r#"
[deploy]
processes = [{ name = "near", components = ["Source"] }, { name = "far", components = ["Sink"] }]
"#;

/// The source publishes on a second topic, and the sink passes it on, on a third one.
const FURTHER: [(&str, &str); 3] = [
    (
        "publish = { tick = \"builtin_interfaces/Time\" }",
        "publish = { more = \"builtin_interfaces/Time\", tick = \"builtin_interfaces/Time\" }\n\
         bind.out.more = { topic = \"more\", field = \"sec\", publish = \"on_update\" }",
    ),
    (
        "subscribe = { tick = \"builtin_interfaces/Time\" }",
        "subscribe = { more = \"builtin_interfaces/Time\", tick = \"builtin_interfaces/Time\" }\n\
         publish = { heard = \"builtin_interfaces/Time\" }\n\
         bind.monitored.more = { topic = \"more\", receive = \"all\", field = \"sec\", none = 0 }\n\
         bind.out.heard = { topic = \"heard\", field = \"sec\", publish = \"on_update\" }",
    ),
    (
        "[components.Sink]",
        "[[promote]]\ntopic = \"heard\"\nas = \"heard\"\n[components.Sink]",
    ),
];

const FURTHER_SOURCE: [(&str, &str); 2] = [
    ("out n: Integer", "out n: Integer\n\tout more: Integer"),
    (
        "main rule r_Main = n := n + 1",
        "main rule r_Main = par n := n + 1 more := n + 1000001 endpar",
    ),
];

const FURTHER_SINK: [(&str, &str); 2] = [
    (
        "monitored tick: Integer",
        "monitored tick: Integer\n\tmonitored more: Integer\n\tout heard: Integer",
    ),
    (
        "\t\tif tick > 0 then",
        "\t\tpar\n\t\tif more > 0 then heard := more endif\n\t\tif tick > 0 then",
    ),
];

fn replaced(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

/// A composite that changes while its processes run.
struct Bound<'b> {
    broker: &'b SharedBroker,
    vhost: &'b Vhost<'b>,
    path: PathBuf,
    processes: &'static str,
}

impl Bound<'_> {
    /// Writes the composite and its specifications, with the further topics if `has_more`.
    fn write(&self, has_more: bool) {
        let sink = replaced(SINK, &FURTHER_SINK);
        let sink = sink.replacen("\t\tendif\ndefault", "\t\tendif\n\t\tendpar\ndefault", 1);
        let (composite, source, sink) = if has_more {
            let composite = replaced(COMPOSITE, &FURTHER);
            (composite, replaced(SOURCE, &FURTHER_SOURCE), sink)
        } else {
            (COMPOSITE.to_owned(), SOURCE.to_owned(), SINK.to_owned())
        };
        std::fs::write(&self.path, composite + self.processes).unwrap();
        let file = |name: &str| self.path.with_file_name(name);
        std::fs::write(file("source.asm"), source).unwrap();
        std::fs::write(file("sink.asm"), sink).unwrap();
    }

    fn tool(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let (user, address) = (self.broker.user(), self.broker.address());
        let url = format!("amqp://{user}@{address}/{}", self.vhost.name());
        tool(self.broker, &url, arguments)
    }

    #[track_caller]
    fn becomes(&self, has_more: bool) -> String {
        self.write(has_more);
        let (code, out, err) = self.tool(&["reconfigure", self.path.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{out}{err}");
        out
    }

    /// How many numbers the sink has seen, and how many are missing before the newest one, once it has seen more than `known`.
    #[track_caller]
    fn seen(&self, known: i64) -> (i64, i64) {
        let until = Instant::now() + LONG;
        loop {
            let (_, out, err) = self.tool(&["component", "info", "Sink"]);
            let value = |location: &str| {
                let after = out.split_once(&format!("{location} := "));
                let number = after.and_then(|(_, it)| it.split([',', ' ', '\n']).next());
                number.and_then(|it| it.parse().ok()).unwrap_or_default()
            };
            let (newest, seen) = (value("newest"), value("seen"));
            if seen > known {
                return (seen, newest - seen);
            }
            assert!(Instant::now() < until, "{out}{err}");
        }
    }
}

fn is_bound_to_further_topics(folder: &Path, processes: &[Option<&str>], apart: &'static str) {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bound = Bound {
        broker: &broker,
        vhost: &vhost,
        path: folder.join("bound.composite.toml"),
        processes: apart,
    };
    bound.write(false);
    let start = |process: &Option<&str>| {
        let mut command = through(run_any(&bound.path), &broker, &vhost, *process);
        command.stdout(std::process::Stdio::null());
        Running::start(&mut command)
    };
    let running: Vec<Running> = processes.iter().map(start).collect();
    for process in processes {
        let name = process.unwrap_or("bound");
        queues(&vhost, &format!("robots.services.bound.control.{name}"));
    }
    let mut peer = Peer::start(python, &vhost.url(), &["bound.heard"]);
    let numbers = |heard: &[Value]| -> Vec<i64> {
        let seconds = heard
            .iter()
            .map(|it| it["content"]["sec"].as_i64().unwrap());
        seconds.collect()
    };
    // those before the start of the sink
    let (mut known, missing) = bound.seen(10);
    let mut foreign = 5_000_000;
    for _ in 0..2 {
        let changes = bound.becomes(true);
        for change in [
            "`Source` runs another version of `source.asm`",
            "`Source.more` is published on topic `more`",
            "`Sink.more` subscribes to topic `more`",
            "`Sink.heard` is published on topic `heard`",
        ] {
            assert!(changes.contains(change), "{change}: {changes}");
        }
        let before = peer.heard("bound.heard").len();
        let is_passed = |heard: &[Value]| heard.len() > before + 10;
        let heard = numbers(&peer.wait_for("bound.heard", is_passed));
        let passed = &heard[before..];
        assert!(passed.is_sorted() && passed[0] > 1_000_000, "{passed:?}");
        // a stranger publishes on the new topic
        foreign += 1;
        let message = json!({ "sec": foreign, "nanosec": 0 }).to_string();
        peer.send(&json!({ "key": "bound.more", "body": message }));
        peer.wait_for("bound.heard", |heard| numbers(heard).contains(&foreign));
        let (_, topics, err) = bound.tool(&["topic", "list"]);
        let row = topics.lines().find(|it| it.contains("more"));
        let row = row.unwrap_or_default();
        assert!(
            row.contains("Source") && row.contains("Sink"),
            "{topics}{err}"
        );
        let found = bound.seen(known);
        assert_eq!(found.1, missing, "no tick is lost, and none comes twice");

        let changes = bound.becomes(false);
        for change in [
            "`Source.more` is no longer published on topic `more`",
            "`Sink.more` no longer subscribes to topic `more`",
        ] {
            assert!(changes.contains(change), "{change}: {changes}");
        }
        let now_missing;
        (known, now_missing) = bound.seen(found.0 + 20);
        assert_eq!(
            now_missing, missing,
            "no tick is lost, and none comes twice"
        );
        let after = peer.heard("bound.heard").len();
        std::thread::sleep(Duration::from_millis(500));
        assert_eq!(
            peer.heard("bound.heard").len(),
            after,
            "nothing is passed on"
        );
    }
    for process in running {
        let output = process.interrupt();
        assert!(output.status.success() || processes == [None], "{output:?}");
    }
}

#[test]
fn c18_specifications_of_two_processes_are_bound_to_further_topics_of_a_broker() {
    let folder = tempfile::tempdir().unwrap();
    is_bound_to_further_topics(folder.path(), &[Some("near"), Some("far")], APART);
}

#[test]
fn c18_specifications_of_one_process_are_bound_to_further_topics_of_a_broker() {
    let folder = tempfile::tempdir().unwrap();
    is_bound_to_further_topics(folder.path(), &[None], "");
}
