//! Peers: Cyclone DDS in Python, and nodes of this crate. Each test has a domain of its own, on the loopback interface alone.

use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, LazyLock};
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Schema};
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceName};
use asmotion_ros2::{Node, NodeOptions};

pub const LONG: Duration = Duration::from_secs(20);

/// Cyclone DDS on the loopback interface, without multicast.
const CYCLONE: &str = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces>\
    <AllowMulticast>false</AllowMulticast></General><Discovery><Peers><Peer address=\"127.0.0.1\"/></Peers>\
    <ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>11</MaxAutoParticipantIndex></Discovery>\
    </Domain></CycloneDDS>";

/// Python with Cyclone DDS, which `./test` installs; `None`, with a notice, without it.
pub fn python() -> Option<PathBuf> {
    static PYTHON: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
        let python = root.join("target/cyclonedds/venv/bin/python");
        let tried = Command::new(&python)
            .args(["-c", "import cyclonedds"])
            .output();
        tried.is_ok_and(|it| it.status.success()).then_some(python)
    });
    if PYTHON.is_none() {
        asmotion_skip::CYCLONEDDS.skip();
    }
    PYTHON.clone()
}

/// A domain for a test. Ports of higher domains are those that systems give to outgoing connections.
pub fn domain() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let first = (std::process::id() % 95) as u16;
    1 + (first + NEXT.fetch_add(1, Ordering::Relaxed)) % 95
}

pub fn catalogue() -> Arc<Catalogue> {
    static JAZZY: LazyLock<Arc<Catalogue>> =
        LazyLock::new(|| Arc::new(Catalogue::included(Distribution::Ros2)));
    Arc::clone(&JAZZY)
}

pub fn node(name: &str, domain: u16) -> Node {
    let options = NodeOptions {
        domain,
        networks: vec![Ipv4Addr::LOCALHOST.into()],
        ..NodeOptions::named(name)
    };
    Node::start(options, catalogue()).unwrap()
}

pub fn named(name: &str) -> InterfaceName {
    name.parse().unwrap()
}

pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

pub fn json(value: &impl serde::Serialize) -> serde_json::Value {
    serde_json::to_value(value).unwrap()
}

/// A running peer. It ends when this is dropped.
pub struct Peer {
    child: Child,
    stdin: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Peer {
    pub fn start(python: &Path, role: &str, settings: &serde_json::Value) -> Self {
        let mut child = Command::new(python)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"))
            .args([role, &settings.to_string()])
            .env("CYCLONEDDS_URI", CYCLONE)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (sender, lines) = channel();
        let stdout = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || {
            for line in stdout.lines() {
                if sender.send(line.unwrap()).is_err() {
                    break;
                }
            }
        });
        Self {
            stdin: child.stdin.take(),
            child,
            lines,
        }
    }

    /// The next line of the peer's output.
    pub fn line(&self) -> String {
        self.lines.recv_timeout(LONG).expect("a line of the peer")
    }

    pub fn expect(&self, expected: &str) {
        assert_eq!(self.line(), expected);
    }

    /// The lines that come within a time.
    pub fn lines_for(&self, time: Duration) -> Vec<String> {
        let end = Instant::now() + time;
        let next = || {
            let left = end.saturating_duration_since(Instant::now());
            self.lines.recv_timeout(left).ok()
        };
        std::iter::from_fn(next).collect()
    }

    /// Ends the peer without a farewell.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.stdin.take());
        let end = Instant::now() + Duration::from_secs(3);
        while Instant::now() < end {
            if self.child.try_wait().unwrap().is_some() {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// Settings of a peer that publishes or subscribes.
pub fn topic_settings(domain: u16, topic: &str, of: &InterfaceName) -> serde_json::Value {
    let schema = catalogue().schema(of).unwrap();
    serde_json::json!({
        "domain": domain,
        "topic": format!("rt{topic}"),
        "type": format!("{}::msg::dds_::{}_", of.package(), of.name()),
        "schema": json(&schema),
    })
}

pub fn encode(message: &Datum, schema: &Schema) -> Vec<u8> {
    Codec::Cdr.encode(message, schema).unwrap()
}

pub fn text(content: &str) -> Datum {
    Datum::record([("data", Datum::text(content))])
}

/// Waits until a value is there.
pub fn wait<T>(what: &str, mut get: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + LONG;
    loop {
        if let Some(found) = get() {
            return found;
        }
        assert!(Instant::now() < end, "no {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
