//! Routing over several brokers: components on their own brokers, wires that leave and re-enter a process, several
//! promotions of a service, and callbacks to several listeners.

use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_broker::{SharedBroker, Vhost};
use asmotion_bus::{Bus, Notifier, Pattern, QueuePolicy};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::gateway::post;
use crate::processes::{Running, queues};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

fn write(folder: &Path, files: &[(&str, &str)]) -> PathBuf {
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    folder.join("main.composite.toml")
}

fn run(composite: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.arg("--json").args(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The values that a run wrote to a location, each with its component.
fn written(output: &[u8], location: &str) -> BTreeSet<(String, String)> {
    let mut found = BTreeSet::new();
    for line in std::str::from_utf8(output).unwrap().lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let component = line["component"].as_str().unwrap_or_default();
        for update in line["step"]["updates"].as_array().into_iter().flatten() {
            if update["location"] == location {
                let after = update["after"].as_str().unwrap_or_default();
                found.insert((component.to_owned(), after.to_owned()));
            }
        }
    }
    found
}

const SPEAKER: &str = "asm speaker
import StandardLibrary
signature:
	out word: String
definitions:
	main rule r_Main = word := \"here\"
";

const HEARER: &str = "asm hearer
import StandardLibrary
signature:
	enum domain Mode = {WAITING | ARRIVED}
	monitored left: String
	monitored right: String
	monitored quiet: String
	controlled mode: Mode
definitions:
	main rule r_Main =
		if left = \"here\" and right = \"here\" and quiet = \"here\" then mode := ARRIVED endif
default init s0:
	function mode = WAITING
";

/// Publishers on two brokers and on none, and a component that subscribes to all three.
const SPEAKERS: &str = r#"
schema = "composite/1"
[composite]
name = "speakers"

[brokers.west]
url = "${WEST}"
[brokers.east]
url = "${EAST}"

[components.Left]
implementation = { asm = "speaker.asm" }
task = { period_ms = 20, broker = "west" }
publish = { left = "std_msgs/String" }
bind.out.word = { topic = "left", publish = "every_step" }

[components.Right]
implementation = { asm = "speaker.asm" }
task = { period_ms = 20, broker = "east" }
publish = { right = "std_msgs/String" }
bind.out.word = { topic = "right", publish = "every_step" }

[components.Quiet]
implementation = { asm = "speaker.asm" }
task = { period_ms = 20 }
publish = { quiet = "std_msgs/String" }
bind.out.word = { topic = "quiet", publish = "every_step" }

[components.Hearer]
implementation = { asm = "hearer.asm" }
task = { period_ms = 20, delay_ms = 1000 }
subscribe = { left = "std_msgs/String", right = "std_msgs/String", quiet = "std_msgs/String" }
bind.monitored.left = { topic = "left", receive = "last", none = "" }
bind.monitored.right = { topic = "right", receive = "last", none = "" }
bind.monitored.quiet = { topic = "quiet", receive = "last", none = "" }
"#;

/// Subscribes to the topics of the composite on a broker until a run has ended.
struct Ear(asmotion_bus::Subscription, AmqpBus);

impl Ear {
    fn new(vhost: &Vhost<'_>) -> Self {
        let bus = AmqpBus::connect(AmqpSettings::parse(&vhost.url()).unwrap(), LONG).unwrap();
        let queue = QueuePolicy::All {
            size: 4096,
            overflow: asmotion_bus::Overflow::DropOldest,
        };
        let subscription =
            bus.subscribe("ear", &Pattern::new("#"), queue, Arc::new(Notifier::new()));
        Self(subscription.unwrap(), bus)
    }

    fn topics(self) -> BTreeSet<String> {
        assert!(self.1.drain(LONG));
        let received = std::iter::from_fn(|| self.0.next_within(Duration::from_millis(200)));
        let topics = received.map(|envelope| envelope.topic.to_string());
        topics.filter(|topic| !topic.contains("presence")).collect()
    }
}

#[test]
fn t20_each_component_speaks_on_its_own_broker_and_one_without_stays_inside() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (west, east) = (broker.vhost().unwrap(), broker.vhost().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("speaker.asm", SPEAKER),
        ("hearer.asm", HEARER),
        ("main.composite.toml", SPEAKERS),
    ];
    let composite = write(folder.path(), &files);
    let spoken = |arguments: &[&str]| {
        let (at_west, at_east) = (Ear::new(&west), Ear::new(&east));
        let mut command = run(&composite, arguments);
        let command = command.env("WEST", west.url()).env("EAST", east.url());
        let output = command.env("ASMOTION_PASSWORD", broker.password()).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{output:?}");
        assert_eq!(written(&output.stdout, "mode").len(), 1);
        [at_west.topics(), at_east.topics()].map(|it| it.into_iter().collect::<Vec<_>>().join(" "))
    };
    assert_eq!(spoken(&[]), ["speakers.left", "speakers.right"]);
    assert_eq!(spoken(&["--bus", "local"]), ["", ""]);
    let (user, address) = (broker.user(), broker.address());
    let one = format!("amqp://{user}@{address}/{}", east.name());
    let all = "speakers.left speakers.quiet speakers.right";
    assert_eq!(spoken(&["--bus", &one]), ["", all]);
}

/// The courier composite with a second courier on the broker, and an additional promotion of the service.
fn three_doors(folder: &Path) -> PathBuf {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/courier");
    for file in std::fs::read_dir(&specs).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.join(file.file_name())).unwrap();
    }
    let text = std::fs::read_to_string(specs.join("courier.composite.toml")).unwrap();
    let (text, _) = text.split_once("# ---- deployment").unwrap();
    let more = r#"
[brokers.main]
url = "${CELL}"

[gateways.main]
listen = "127.0.0.1:0"

[components.Far]
implementation = { asm = "courier.asm", main = "r_Main" }
task       = { period_ms = 50 }
references = { dispatcher = "courier/Dispatch" }

[[wires]]
reference  = "Far.dispatcher"
service    = "Dispatcher.dispatch"
binding    = "amqp"
timeout_ms = 500

[[promote]]
service = "Dispatcher.dispatch"
as = "jobs"
binding = ["amqp", "http"]
"#;
    write(folder, &[("main.composite.toml", &format!("{text}{more}"))])
}

/// Calls an operation until it has a provider.
fn call(broker: &SharedBroker, vhost: &Vhost<'_>, operation: &str, argument: &str) -> String {
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let until = Instant::now() + LONG;
    loop {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(["call", operation, argument, "--bus", &url]);
        let output = command.env("ASMOTION_PASSWORD", broker.password()).output();
        let output = output.unwrap();
        if output.status.success() {
            return String::from_utf8(output.stdout).unwrap().trim().to_owned();
        }
        assert!(Instant::now() < until, "{output:?}");
    }
}

#[test]
fn c4_a_service_is_called_through_three_doors() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_doors(folder.path());
    let mut command = run(&composite, &[]);
    let mut running = Running::start(command.env("CELL", vhost.url()));
    let services = running.listening();
    // by its promoted name, and by its own
    assert_eq!(call(&broker, &vhost, "courier.jobs.job", "4"), "7");
    let own = "courier.Dispatcher.dispatch.job";
    assert_eq!(call(&broker, &vhost, own, "5"), "8");
    // also without the robot
    assert_eq!(call(&broker, &vhost, "jobs.job", "6"), "9");
    // from outside of all buses: the same reply, and none if there is no provider
    let job = format!("{services}/jobs/job");
    assert_eq!(post(&job, "4"), (200, json!(7)));
    assert_eq!(post(&job, "\"four\"").0, 400);
    assert_eq!(
        post(&format!("{services}/jobs/done"), "4"),
        (202, Value::Null)
    );
    std::thread::sleep(Duration::from_secs(1));
    let output = running.interrupt();
    let got: BTreeSet<String> = written(&output.stdout, "jobs")
        .into_iter()
        .map(|(component, _)| component)
        .collect();
    assert_eq!(
        got.len(),
        2,
        "who asks inside, and who asks over the broker: {output:?}"
    );
    // only the traffic between processes needs the broker: without it, all connections are direct
    let inside = ["--bus", "local", "--http", "off", "--until", "jobs=3"];
    let mut command = run(&composite, &inside);
    let output = command.env("CELL", vhost.url()).output().unwrap();
    assert!(output.status.success(), "{output:?}");
}

const TELLER: &str = "asm teller
import StandardLibrary
import CommonBehavior
signature:
	domain Listeners subsetof Agent
	static listeners: Listeners
	out hear: Prod(Listeners, Integer) -> Rule
definitions:
	main rule r_Main = r_wsend[listeners, \"hear\", 7]
";

const LISTENER: &str = "asm listener
import StandardLibrary
import CommonBehavior
signature:
	controlled heard: Integer
	out hear: Prod(Agent, Integer) -> Rule
definitions:
	main rule r_Main =
		if nextRequest(self) = \"hear\" then r_wreceive[undef, \"hear\", heard] endif
default init s0:
	function heard = 0
";

const TOLD: &str = r#"
schema = "composite/1"
[composite]
name = "told"
[components.Teller]
implementation = { asm = "teller.asm" }
task = { period_ms = 50 }
references = { listeners = "test/Listener" }
[components.Near]
implementation = { asm = "listener.asm" }
task = { period_ms = 20 }
services = { notifying = "test/Listener" }
[components.Far]
implementation = { asm = "listener.asm" }
task = { period_ms = 20 }
services = { notifying = "test/Listener" }
[[wires]]
reference = "Teller.listeners"
service = ["Near.notifying", "Far.notifying"]
[deploy]
processes = [
  { name = "here", components = ["Teller", "Near"] },
  { name = "there", components = ["Far"] },
]
"#;

#[test]
fn y10_a_callback_reaches_every_listener_inside_over_the_bus_and_in_another_process() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("teller.asm", TELLER),
        ("listener.asm", LISTENER),
        ("main.composite.toml", TOLD),
    ];
    let composite = write(folder.path(), &files);
    let url = format!(
        "amqp://{}@{}/{}",
        broker.user(),
        broker.address(),
        vhost.name()
    );
    let start = |arguments: &[&str]| {
        let mut command = run(&composite, arguments);
        command.env("ASMOTION_PASSWORD", broker.password());
        Running::start(&mut command)
    };
    let received = |output: &std::process::Output| written(&output.stdout, "heard");
    let of = |component: &str| (component.to_owned(), "7".to_owned());
    let all = BTreeSet::from([of("Far"), of("Near")]);
    for (bus, limit) in [("local", "2"), (url.as_str(), "3")] {
        let limit = ["--bus", bus, "--for", limit];
        let output = start(&limit).end();
        assert_eq!(received(&output), all, "{bus}: {output:?}");
    }
    let far = start(&["--bus", &url, "--process", "there", "--until", "heard=7"]);
    queues(&vhost, "robots.services.told.Far");
    let onboard = start(&["--bus", &url, "--process", "here"]);
    assert_eq!(received(&far.end()), BTreeSet::from([of("Far")]));
    assert_eq!(received(&onboard.interrupt()), BTreeSet::from([of("Near")]));
}

const BELL: &str = "asm bell
import StandardLibrary
signature:
	controlled n: Integer
	out rung: Boolean
definitions:
	main rule r_Main = if n < 5 then par n := n + 1 rung := true endpar endif
default init s0:
	function n = 0
";

const GUEST: &str = "asm guest
import StandardLibrary
signature:
	monitored rung: Boolean
	controlled n: Integer
definitions:
	main rule r_Main = if rung then n := n + 1 endif
default init s0:
	function n = 0
";

const RUNG: &str = r#"
schema = "composite/1"
[composite]
name = "rung"
[components.Bell]
implementation = { asm = "bell.asm" }
activity = { period_ms = 100 }
publish = { bell = "std_msgs/Bool" }
[components.Bell.bind.out]
rung = { topic = "bell" }
[components.Guest]
implementation = { asm = "guest.asm" }
subscribe = { bell = "std_msgs/Bool" }
[components.Guest.bind.monitored]
rung = { topic = "bell", receive = "all", none = false }
"#;

/// A message that leaves by the broker and comes back is one message, from its sender.
#[test]
fn a_message_over_the_broker_is_reported_once() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("bell.asm", BELL),
        ("guest.asm", GUEST),
        ("main.composite.toml", RUNG),
    ];
    let composite = write(folder.path(), &files);
    let url = vhost.url();
    for bus in ["local", &url] {
        let output = |format: &[&str]| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
            command.arg("run").arg(&composite).args(["--bus", bus]);
            command.args(["--for", "2", "--clock", "wall"]).args(format);
            command.env("ASMOTION_PASSWORD", broker.password());
            let output = command.output().unwrap();
            assert!(output.status.success(), "{output:?}");
            let text = |bytes| String::from_utf8(bytes).unwrap();
            (text(output.stdout), text(output.stderr))
        };
        let (summary, story) = output(&[]);
        let text = story + &summary;
        assert!(text.contains("  received   bell ×5"), "{bus}: {text}");
        let messages = text.lines().filter(|line| line.contains("bell  true"));
        assert_eq!(messages.count(), 5, "{bus}: {text}");
        assert!(!text.contains("outside"), "{bus}: {text}");
        let (json, _) = output(&["--json"]);
        let summary: Value = serde_json::from_str(json.lines().last().unwrap()).unwrap();
        assert_eq!(
            summary["heard"],
            json!([{ "count": 5, "name": "bell" }]),
            "{bus}"
        );
    }
}
