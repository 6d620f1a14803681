//! What a foreign driver receives of the commands of one of our components after either side, the link or the broker comes back.
//! The driver is written in pika from docs/wire.md alone: it judges the age of a command by its headers. The test judges it by
//! the time in the command itself.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_broker::Line;
use serde_json::Value;

use crate::processes::{Running, run_any};
use crate::stranger::python;

/// Time for everything to come back on a loaded machine.
const LONG: Duration = Duration::from_secs(60);
/// Age in ms that no command may have that the driver obeys: its limit, and the time that a loaded machine takes.
const OLDEST: i64 = 500 + 1000;
/// Duration of an interruption, in which commands get much older than that.
const INTERRUPTION: Duration = Duration::from_secs(4);

/// A command is its number and the time in ms at which it was given.
const COMMANDER: &str = "asm commander
import StandardLibrary
import TimeLibrary
signature:
	controlled n: Integer
	out command: Integer
definitions:
	main rule r_Main = par n := n + 1 command := (n + 1) * 1000000 + mCurrTimeMillisecs endpar
default init s0:
	function n = 0
";

const COMPOSITE: &str = r#"schema = "composite/1"
[composite]
name = "driven"
[components.Commander]
implementation = { asm = "commander.asm" }
activity = { period_ms = 20 }
publish = { command = "std_msgs/Int64" }
[components.Commander.bind.out]
command = { topic = "command", field = "data", publish = "every_step" }
[topics.command]
codec = "json"
outage = "queue"
size = 10000
[[promote]]
topic = "command"
as = "command"
"#;

/// A command that the driver has received.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Received {
    /// Whether the driver obeys it; otherwise it has found that it is too old.
    is_obeyed: bool,
    incarnation: i64,
    sequence: i64,
    number: i64,
    /// Time of arrival by the clock of the driver, minus the time in the command, in ms.
    transit: i64,
}

/// The foreign driver, and what it has printed.
struct ForeignDriver {
    child: Child,
    received: Arc<Mutex<Vec<Received>>>,
    purged: Arc<Mutex<Option<i64>>>,
}

impl ForeignDriver {
    fn start(python: &Path, url: &str) -> Self {
        let peer = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/returns/peer.py");
        let mut command = Command::new(python);
        command.arg(peer).args(["take", url, "driven.command"]);
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let received = Arc::<Mutex<Vec<_>>>::default();
        let purged = Arc::<Mutex<Option<i64>>>::default();
        let (to, discarded) = (Arc::clone(&received), Arc::clone(&purged));
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let line: Value = serde_json::from_str(&line).unwrap();
                let number = |at: usize| line[at].as_i64().unwrap();
                if line[0] == "purged" {
                    *discarded.lock().unwrap() = Some(number(1));
                    continue;
                }
                to.lock().unwrap().push(Received {
                    is_obeyed: line[0] == "took",
                    incarnation: number(1),
                    sequence: number(2),
                    number: number(3) / 1_000_000,
                    transit: number(4) - number(3) % 1_000_000,
                });
            }
        });
        let this = Self {
            child,
            received,
            purged,
        };
        this.eventually("its queue", |_| this.purged.lock().unwrap().is_some());
        this
    }

    fn received(&self) -> Vec<Received> {
        self.received.lock().unwrap().clone()
    }

    #[track_caller]
    fn eventually(&self, what: &str, is_so: impl Fn(&[Received]) -> bool) {
        let until = Instant::now() + LONG;
        while !is_so(&self.received()) {
            assert!(Instant::now() < until, "{what}: {:?}", self.received());
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until it has obeyed so many commands beyond the first `known` that it has received.
    #[track_caller]
    fn wait_for(&self, count: usize, known: usize) {
        self.eventually("commands", |received| {
            let new = received.iter().skip(known);
            new.filter(|it| it.is_obeyed).count() >= count
        });
    }

    fn signal(&self, signal: &str) {
        let pid = self.child.id().to_string();
        let sent = Command::new("kill").args([signal, &pid]).status();
        assert!(sent.unwrap().success());
    }
}

impl Drop for ForeignDriver {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Checks that the commands which the driver obeys are young and in order, each once, and that the others are old.
#[track_caller]
fn assert_good(received: &[Received]) {
    let mut fastest = BTreeMap::new();
    for it in received {
        let known = fastest.entry(it.incarnation).or_insert(it.transit);
        *known = it.transit.min(*known);
    }
    for it in received {
        let age = it.transit - fastest[&it.incarnation];
        if it.is_obeyed {
            assert!(age <= OLDEST, "{age} ms: {it:?} of {received:?}");
        } else {
            assert!(age > 250, "{age} ms: {it:?} of {received:?}");
        }
    }
    let order = |one: &Received, next: &Received| {
        (one.incarnation, one.sequence, one.number) < (next.incarnation, next.sequence, next.number)
    };
    assert!(received.is_sorted_by(order), "{received:?}");
}

/// Checks that no command between the first and the last is missing.
#[track_caller]
fn assert_complete(received: &[Received]) {
    let next = |pair: &[Received]| pair[0].sequence + 1 == pair[1].sequence;
    let of_one = |pair: &[Received]| pair[0].incarnation == pair[1].incarnation;
    let mut pairs = received.windows(2);
    assert!(pairs.all(|pair| next(pair) && of_one(pair)), "{received:?}");
}

fn start_commander(folder: &Path, url: &str, password: &str) -> Running {
    std::fs::write(folder.join("commander.asm"), COMMANDER).unwrap();
    let composite = folder.join("driven.composite.toml");
    std::fs::write(&composite, COMPOSITE).unwrap();
    let mut command = run_any(&composite);
    command.args(["--bus", url]);
    command.env("ASMOTION_PASSWORD", password);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Running::start(&mut command)
}

#[test]
fn a_foreign_driver_obeys_only_new_commands_after_either_side_comes_back() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
    let ours = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let driver = ForeignDriver::start(python, &vhost.url());
    let commander = start_commander(folder.path(), &ours, broker.password());
    driver.wait_for(10, 0);
    // the commander is killed and starts again: its first command is the first that arrives
    drop(commander);
    std::thread::sleep(Duration::from_secs(1));
    let known = driver.received().len();
    let _commander = start_commander(folder.path(), &ours, broker.password());
    driver.wait_for(10, known);
    let received = driver.received();
    assert_good(&received);
    assert!(received.iter().all(|it| it.is_obeyed), "{received:?}");
    assert_complete(&received[..known]);
    assert_complete(&received[known..]);
    let first = received[known];
    assert_eq!((first.sequence, first.number), (1, 1), "{received:?}");
    // the driver does not run for a while
    driver.signal("-STOP");
    std::thread::sleep(INTERRUPTION);
    driver.signal("-CONT");
    let paused = driver.received().len();
    driver.wait_for(50, paused);
    let received = driver.received();
    assert_good(&received);
    assert_complete(&received[known..]);
    let discarded = received.iter().filter(|it| !it.is_obeyed).count();
    assert!(discarded > 50, "{discarded}: {received:?}");
    // the driver is killed and starts again
    let last = received.last().unwrap().number;
    drop(driver);
    std::thread::sleep(INTERRUPTION);
    let driver = ForeignDriver::start(python, &vhost.url());
    driver.wait_for(20, 0);
    let received = driver.received();
    assert_good(&received);
    assert_complete(&received);
    let purged = driver.purged.lock().unwrap().unwrap();
    assert!(purged > 50, "{purged}");
    assert!(received[0].number > last + 50, "{last}: {received:?}");
}

#[test]
fn a_foreign_driver_obeys_only_new_commands_after_the_link_of_the_commander_comes_back() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    for cut in [Duration::from_secs(3), Duration::from_secs(8)] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let line = Line::to(broker.address()).unwrap();
        let (user, port, vhost_name) = (broker.user(), line.port(), vhost.name());
        let ours = format!("amqp://{user}@127.0.0.1:{port}/{vhost_name}");
        let driver = ForeignDriver::start(python, &vhost.url());
        let _commander = start_commander(folder.path(), &ours, broker.password());
        driver.wait_for(10, 0);
        line.cut(true);
        std::thread::sleep(cut);
        let known = driver.received().len();
        line.cut(false);
        driver.wait_for(50, known);
        let received = driver.received();
        assert_good(&received);
        assert_complete(&received);
        let discarded = received.iter().filter(|it| !it.is_obeyed).count();
        assert!(discarded > 50, "{cut:?}, {discarded}: {received:?}");
    }
}

#[test]
fn a_foreign_driver_obeys_only_new_commands_after_the_broker_comes_back() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let Some(python) = python() else {
        return;
    };
    for kill in [false, true] {
        let (vhost, folder) = (broker.vhost().unwrap(), tempfile::tempdir().unwrap());
        let ours = format!(
            "amqp://{}@{}/{}",
            broker.user(),
            broker.address(),
            vhost.name()
        );
        let driver = ForeignDriver::start(python, &vhost.url());
        let _commander = start_commander(folder.path(), &ours, broker.password());
        driver.wait_for(10, 0);
        if kill {
            broker.kill().unwrap();
            std::thread::sleep(INTERRUPTION);
            broker.revive().unwrap();
        } else {
            broker.stop_app().unwrap();
            std::thread::sleep(INTERRUPTION);
            broker.start_app().unwrap();
        }
        let known = driver.received().len();
        driver.wait_for(50, known);
        let received = driver.received();
        assert_good(&received);
        assert_complete(&received);
        let discarded = received.iter().filter(|it| !it.is_obeyed).count();
        assert!(discarded > 50, "{kill}, {discarded}: {received:?}");
    }
}
