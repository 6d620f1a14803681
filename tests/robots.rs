//! Robots that call services of each other: separate composites in separate processes, on one broker.

use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_broker::{TestBroker, Vhost};
use asmotion_bus::{Bus, Notifier, Overflow, Pattern, Payload, QueuePolicy, Subscription};
use asmotion_datum::Datum;
use asmotion_messages::OccupancyGrid;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::processes::{Running, modes, queues, run_any};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

/// A specification that gets a map and publishes it.
const FETCH: &str = "asm fetch
import StandardLibrary
signature:
	enum domain Mode = {IDLE | ASKING | ARRIVED | FAILED}
	enum domain Command = {NONE | GET_MAP | SHARE}
	enum domain Event = {NOTHING | MAP_OK | NO_MAP}
	monitored event: Event
	controlled mode: Mode
	out command: Command
definitions:
	main rule r_Main =
		if mode = IDLE then
			par
				mode := ASKING
				command := GET_MAP
			endpar
		else
			if event = MAP_OK then
				par
					mode := ARRIVED
					command := SHARE
				endpar
			else
				if event = NO_MAP then mode := FAILED endif
			endif
		endif
default init s0:
	function mode = IDLE
	function command = NONE
";

const ROVER: &str = r#"
schema = "composite/1"
[composite]
name = "rover"

[brokers.main]
url = "${BROKER}"

[components.Coordinator]
implementation = { asm = "fetch.asm" }
task           = { period_ms = 20 }
references     = { maps = "nav/MapService" }
subscribe      = { event = "nav/Event" }
publish        = { map = "nav_msgs/OccupancyGrid" }
bind.monitored.event = { topic = "event", receive = "all", map = "code", none = "NOTHING" }
[components.Coordinator.bind.out.command]
GET_MAP = { call = "maps.getMap", with = { name = "office" }, keep = "map", ok = "MAP_OK", failed = "NO_MAP", event = "event" }
SHARE   = { publish = "map", value = "@map" }

[[wires]]
reference  = "Coordinator.maps"
binding    = "amqp"
url        = "robot://depot/MapServer.maps"
timeout_ms = 20000
"#;

const DEPOT: &str = r#"
schema = "composite/1"
[composite]
name = "depot"

[brokers.main]
url = "${BROKER}"

[components.MapServer]
implementation = { rust = "nav::MapServer" }
task           = { id = "map-server", period_ms = 50 }
services       = { maps = "nav/MapService" }
properties     = { source = "${MAPS}" }

[[promote]]
service = "MapServer.maps"
as      = "maps"
binding = "amqp"
"#;

/// Composites of the depot and the rovers.
struct Site<'b> {
    folder: tempfile::TempDir,
    broker: &'b TestBroker,
    vhost: &'b Vhost<'b>,
}

impl<'b> Site<'b> {
    fn new(broker: &'b TestBroker, vhost: &'b Vhost<'b>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("fetch.asm"), FETCH).unwrap();
        Self {
            folder,
            broker,
            vhost,
        }
    }

    fn composite(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(format!("{name}.composite.toml"));
        std::fs::write(&path, text).unwrap();
        path
    }

    fn run(&self, composite: &Path, arguments: &[&str]) -> Command {
        let mut command = run_any(composite);
        let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation/maps");
        command.args(arguments).env("MAPS", maps);
        command.env("BROKER", self.vhost.url());
        command.env("ASMOTION_PASSWORD", self.broker.password());
        command
    }

    /// Starts the depot, and waits until it offers its service.
    fn depot(&self) -> Running {
        self.robot("depot", DEPOT, "robots.services.depot.MapServer.maps")
    }

    /// Starts a robot, and waits until there is a queue.
    fn robot(&self, name: &str, text: &str, queue: &str) -> Running {
        let composite = self.composite(name, text);
        let running = Running::start(&mut self.run(&composite, &[]));
        queues(self.vhost, queue);
        running
    }

    /// Starts a rover, and waits until it is on the broker.
    fn rover(&self, name: &str) -> Running {
        let composite = self.composite("rover", ROVER);
        let rover = Running::start(&mut self.run(&composite, &["--robot", name]));
        queues(self.vhost, &format!("robots.services.{name}.control.rover"));
        rover
    }

    /// Subscribes to a topic of all robots.
    fn all(&self, topic: &str) -> (AmqpBus, Subscription) {
        let bus = AmqpBus::connect(AmqpSettings::parse(&self.vhost.url()).unwrap(), LONG).unwrap();
        let queue = QueuePolicy::All {
            size: 16,
            overflow: Overflow::DropOldest,
        };
        let pattern = Pattern::new(format!("#.{topic}"));
        let subscription = bus.subscribe("ear", &pattern, queue, Arc::new(Notifier::new()));
        let subscription = subscription.unwrap();
        (bus, subscription)
    }
}

/// The next map of a robot.
fn next_map(maps: &Subscription) -> (String, OccupancyGrid) {
    let envelope = maps.next_within(LONG).expect("a map");
    let map = envelope.payload.read::<OccupancyGrid>().unwrap();
    (envelope.topic.to_string(), map)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn n12_two_robots_share_a_map_server_and_a_third_calls_while_it_restarts() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&broker, &vhost);
    let (_bus, maps) = site.all("map");
    let depot = site.depot();
    let rovers = ["rover1", "rover2"].map(|name| site.rover(name));
    for rover in rovers {
        assert_eq!(modes(&rover.end()).0, ["ASKING", "ARRIVED"]);
    }
    let mut received = [next_map(&maps), next_map(&maps)];
    received.sort_by(|one, other| one.0.cmp(&other.0));
    let [(first, one), (second, other)] = received;
    assert_eq!((&*first, &*second), ("rover1.map", "rover2.map"));
    assert!(!one.data.is_empty());
    assert_eq!(one.info.map_load_time, other.info.map_load_time);
    assert_eq!(one.data, other.data);

    // the third one calls while there is no provider, and waits for it
    drop(depot.interrupt());
    let rover = site.rover("rover3");
    std::thread::sleep(Duration::from_millis(500));
    let depot = site.depot();
    assert_eq!(modes(&rover.end()).0, ["ASKING", "ARRIVED"]);
    let (topic, newer) = next_map(&maps);
    assert_eq!(topic, "rover3.map");
    assert_ne!(newer.info.map_load_time, one.info.map_load_time);
    assert_eq!(newer.data, one.data);
    drop(depot);
}

#[test]
fn n12_a_robot_has_one_provider_of_a_service() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&broker, &vhost);
    let depot = site.depot();
    let composite = site.composite("second", DEPOT);
    let second = site.run(&composite, &[]).output().unwrap();
    assert_eq!(second.status.code(), Some(2), "{second:?}");
    let said = text(&second.stderr);
    assert!(said.contains("is already served"), "{said}");
    assert!(
        said.contains("of this name") && said.contains("--robot NAME"),
        "{said}"
    );
    // the first one is not disturbed, and its promoted name is an address too
    let promoted = ROVER.replace("depot/MapServer.maps", "depot/maps");
    let composite = site.composite("promoted", &promoted);
    let rover = site.run(&composite, &["--robot", "rover1"]).output();
    assert_eq!(modes(&rover.unwrap()).0, ["ASKING", "ARRIVED"]);
    drop(depot);
}

/// Runs a rover whose call must fail. Returns its standard output.
fn failed(output: &Output) -> String {
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(said.contains(r#""after":"FAILED""#), "{said}");
    said
}

#[test]
fn n12_a_call_that_does_not_fit_the_announced_service_ends_with_a_fault_that_names_both() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&broker, &vhost);
    let depot = site.depot();
    for (from, to, fault) in [
        (
            "depot/MapServer.maps",
            "depot/MapServer.mops",
            "NO_SERVICE: robot `depot` has no service `MapServer.mops`, which `Coordinator.maps` calls",
        ),
        (
            "depot/MapServer.maps",
            "depot/map-server.maps",
            "NO_SERVICE: `map-server.maps` of robot `depot`, which `Coordinator.maps` calls, begins with the `task.id` of a \
             component: its address is `robot://depot/MapServer.maps`",
        ),
        (
            "nav/MapService",
            "test/Maps",
            "OTHER_INTERFACE: `MapServer.maps` of robot `depot` has the interface `nav/MapService`, but \
             `Coordinator.maps` expects `test/Maps`",
        ),
    ] {
        let composite = site.composite("rover", &ROVER.replace(from, to));
        let began = Instant::now();
        // the first call is made before the announcement arrives
        let output = site.run(&composite, &["--robot", "rover1"]).output();
        let said = failed(&output.unwrap());
        let (code, detail) = fault.split_once(": ").unwrap();
        assert!(said.contains(code) && said.contains(detail), "{said}");
        assert!(began.elapsed() < Duration::from_secs(15), "not at once");
    }
    drop(depot);
}

#[test]
fn n12_a_component_that_a_running_robot_does_not_have_is_named_with_the_nearest_one() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&broker, &vhost);
    let depot = site.depot();
    let short = ROVER.replace("timeout_ms = 20000", "timeout_ms = 4000");
    for (name, problem) in [
        (
            "MapSrver.maps",
            "`Coordinator.maps` calls `robot://depot/MapSrver.maps`: robot `depot` runs (`depot`), but has no component \
             `MapSrver`; did you mean `MapServer`?",
        ),
        (
            "mops",
            "`Coordinator.maps` calls `robot://depot/mops`: robot `depot` runs (`depot`), but has no promoted service \
             `mops`; did you mean `maps`?",
        ),
    ] {
        let composite = site.composite("rover", &short.replace("MapServer.maps", name));
        let output = site.run(&composite, &["--robot", "rover1"]).output();
        let output = output.unwrap();
        failed(&output);
        let said = text(&output.stderr);
        assert_eq!(said.matches(problem).count(), 1, "{said}");
    }
    drop(depot);
}

#[test]
fn n12_a_stranger_that_answers_in_the_name_of_a_robot_brings_no_caller_down() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&broker, &vhost);
    let (bus, maps) = site.all("map");
    let notifier = Arc::new(Notifier::new());
    let address = "depot.MapServer.maps.getMap";
    let served = bus.serve(address, 4, Arc::clone(&notifier)).unwrap();
    let rover = site.rover("rover1");
    let until = Instant::now() + LONG;
    let call = loop {
        if let Some(call) = served.try_next() {
            break call;
        }
        assert!(Instant::now() < until, "no call");
        notifier.wait(Duration::from_millis(50));
    };
    call.reply(Ok(Payload::of(Datum::text("here is no map"))));
    let output = rover.end();
    let said = failed(&output);
    let fault = "reply of `MapServer.maps.getMap` of robot `depot`";
    assert!(said.contains("BAD_REPLY") && said.contains(fault), "{said}");
    assert!(!text(&output.stderr).contains("panicked"), "{output:?}");
    let published = maps.next_within(Duration::from_secs(1));
    assert!(published.is_none(), "{published:?}");
    // the robot itself cannot serve the address until the stranger leaves it
    let composite = site.composite("depot", DEPOT);
    let depot = site.run(&composite, &[]).output().unwrap();
    assert!(
        text(&depot.stderr).contains("is already served"),
        "{depot:?}"
    );
}

#[test]
fn n12_a_wire_to_another_robot_says_what_it_needs() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("fetch.asm"), FETCH).unwrap();
    let composite = folder.path().join("rover.composite.toml");
    std::fs::write(&composite, ROVER).unwrap();
    let ends = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(arguments).arg(&composite);
        command.env("BROKER", "amqp://a:b@127.0.0.1:1/x");
        let output = command.output().unwrap();
        (
            output.status.code(),
            text(&output.stdout) + &text(&output.stderr),
        )
    };
    for arguments in [
        &["run", "--bus", "local"][..],
        &["run", "--bus", "local", "--clock", "wall"],
    ] {
        let (code, said) = ends(arguments);
        assert_eq!(code, Some(2), "{said}");
        let needs = "`robot://depot/MapServer.maps` is a service of another robot, which is called over a broker";
        assert!(
            said.contains(needs) && said.contains("--bus amqp://"),
            "{said}"
        );
    }
    let (code, said) = ends(&["run", "--robot", "depot"]);
    assert_eq!(code, Some(2), "{said}");
    let own =
        "is a service of this robot, which is called `depot`: write `service = \"MapServer.maps\"`";
    assert!(said.contains(own), "{said}");
    let (code, said) = ends(&["check", "--connections"]);
    assert_eq!(code, Some(0), "{said}");
    let route = said
        .lines()
        .find(|line| line.contains("robot://depot/MapServer.maps"));
    assert!(route.unwrap().contains("over the broker `main`"), "{said}");
    // what `expand` writes has the same wire
    let (code, expanded) = ends(&["expand"]);
    assert_eq!(code, Some(0), "{expanded}");
    assert!(
        expanded.contains("url = \"robot://depot/MapServer.maps\""),
        "{expanded}"
    );
}
