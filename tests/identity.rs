//! `task.id` is the name of a component outside its composite: of its queues, in its messages, in logs and tools.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::processes::{Running, queues, run_any, through, tool};

/// Sends 100 numbers a second.
const SOURCE: &str = "asm source
import StandardLibrary
signature:
	out n: Integer
definitions:
	main rule r_Main = n := n + 1
default init s0:
	function n = 0
";

/// Takes one of them in each of ten steps a second.
const SINK: &str = "asm sink
import StandardLibrary
signature:
	monitored n: Integer
	controlled latest: Integer
definitions:
	main rule r_Main = if n > 0 then latest := n endif
default init s0:
	function latest = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "named"
[components.Source]
implementation = { asm = "source.asm" }
task = { id = "sender", period_ms = 10 }
publish = { n = "builtin_interfaces/Time" }
[components.Source.bind.out]
n = { topic = "n", field = "sec", publish = "on_update" }
[components.Sink]
implementation = { asm = "sink.asm" }
task = { id = "taker", period_ms = 100 }
subscribe = { n = "builtin_interfaces/Time" }
[components.Sink.bind.monitored]
n = { topic = "n", receive = "all", field = "sec", none = 0 }
[[connections]]
from = "topic:n"
to = "Sink.n"
policy = { type = "buffer", size = 1000, max_age_ms = 300, on_stale = "no_data" }
"#;

fn composite(folder: &Path) -> PathBuf {
    std::fs::write(folder.join("source.asm"), SOURCE).unwrap();
    std::fs::write(folder.join("sink.asm"), SINK).unwrap();
    let path = folder.join("named.composite.toml");
    std::fs::write(&path, COMPOSITE).unwrap();
    path
}

#[test]
fn t15_an_id_names_queues_messages_topics_and_the_component_for_tools() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let composite = composite(folder.path());
    let mut command = through(run_any(&composite), &broker, &vhost, None);
    let _running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
    queues(&vhost, "robots.services.named.control.");
    let names = vhost.queues().unwrap();
    assert!(
        names.iter().any(|name| name.contains(".named.taker.n.")),
        "{names:?}"
    );
    assert!(!names.iter().any(|name| name.contains("Sink")), "{names:?}");

    let tool = |arguments: &[&str]| tool(&broker, &vhost.url(), arguments);
    let (_, out, err) = tool(&["topic", "list"]);
    let topic = out.lines().find(|line| line.starts_with("named.n "));
    let topic = topic.unwrap_or_else(|| panic!("{out}{err}"));
    let words: Vec<_> = topic.split_whitespace().collect();
    assert_eq!(words[words.len() - 2..], ["sender", "taker"], "{topic}");
    let (code, out, err) = tool(&["topic", "echo", "named.n", "--count", "1"]);
    assert_eq!(code, Some(0), "{err}");
    let message: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(message["source"], "sender");

    for name in ["taker", "named.taker", "Sink"] {
        let (code, out, err) = tool(&["component", "info", name]);
        assert_eq!(code, Some(0), "{err}");
        assert!(out.contains("n: builtin_interfaces/Time"), "{out}");
        assert!(out.starts_with("Sink (taker): Running"), "{out}");
    }
}

#[test]
fn t15_an_id_names_the_component_in_logs() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite(folder.path()));
    let output = command.args(["--for", "2"]).output().unwrap();
    let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(
        said.contains("notice taker: messages for `n` waited"),
        "{said}"
    );
}
