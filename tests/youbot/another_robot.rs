//! A proxy configures itself for a robot that it does not know, from what the robot announces on a broker.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_broker::Vhost;
use asmotion_bus::{Bus, Payload, PublishOptions, SenderId};
use asmotion_datum::{Datum, Schema};
use asmotion_remote::{PRESENCE, Presence, PresentComponent, Remote, RemoteError, presence_topic};

use crate::processes::{Running, queues};

/// Timeout for a loaded machine.
pub(super) const LONG: Duration = Duration::from_secs(30);

/// A robot with the driver of an arm. It knows nothing about proxies.
const ARM: &str = r#"
schema = "composite/1"
[composite]
name = "arm"
[components.Driver]
implementation = { rust = "youbot::DummyDriver" }
activity   = { period_ms = 20 }
properties = { joints = 6, speed = 10.0 }
[[promote]]
port = "Driver.commands"
as   = "commands"
[[promote]]
port = "Driver.period"
as   = "period"
"#;

/// A robot whose component of the same name has no arm.
const ROVER: &str = r#"
schema = "composite/1"
[composite]
name = "arm"
[components.Driver]
implementation = { rust = "nav::Operator" }
activity   = { period_ms = 100 }
"#;

/// A proxy that lists its services only.
pub(super) const STATION: &str = r#"
schema = "composite/1"
promote = [
  { service = "Facade.sending", as = "sending" },
  { service = "Facade.reading", as = "reading" },
  { service = "Facade.pacing", as = "pacing" },
]
[composite]
name = "station"
[components.Arm]
implementation = { builtin = "remote", target = "robot://arm/Driver" }
[components.Facade]
implementation = { builtin = "port-proxy", target = "Arm" }
activity = { period_ms = 20 }
services = { sending = "youbot/SendingCommands", reading = "youbot/RetrievingStatus", pacing = "youbot/SettingPeriod" }
references = { notifying = { interface = "youbot/Notifying", optional = true } }
notify = { reference = "notifying", idle = { within = 0.01, of = "commands.position", on = "jointStatus.position" } }
"#;

/// A folder with composites, and the virtual host where they run.
pub(super) struct Site<'v> {
    folder: tempfile::TempDir,
    vhost: &'v Vhost<'v>,
}

impl<'v> Site<'v> {
    pub(super) fn new(vhost: &'v Vhost<'v>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder, vhost }
    }

    pub(super) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(format!("{name}.composite.toml"));
        std::fs::write(&path, text).unwrap();
        path
    }

    pub(super) fn run(&self, composite: &Path, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(composite).args(["--for", "120"]);
        command.args(["--bus", &self.vhost.url()]).args(arguments);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Starts the robot with this number of joints, and waits until it takes orders.
    pub(super) fn arm(&self, joints: u32) -> Running {
        let text = ARM.replace("joints = 6", &format!("joints = {joints}"));
        let composite = self.write("arm", &text);
        let arm = self.robot(&composite, &[]);
        queues(self.vhost, "robots.services.arm.control.arm");
        arm
    }

    /// Starts a robot.
    pub(super) fn robot(&self, composite: &Path, arguments: &[&str]) -> Running {
        let mut command = self.run(composite, arguments);
        Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()))
    }

    pub(super) fn station(&self) -> Station {
        let composite = self.write("station", STATION);
        Station::start(&mut self.run(&composite, &[]))
    }

    /// Runs a tool on the broker.
    pub(super) fn tool(&self, arguments: &[&str]) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.args(arguments).args(["--bus", &self.vhost.url()]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    }
}

/// The process with the proxy, and what it says.
pub(super) struct Station {
    process: std::process::Child,
    said: Receiver<String>,
    lines: Vec<String>,
}

impl Station {
    pub(super) fn start(command: &mut Command) -> Self {
        let mut process = command.spawn().unwrap();
        let (sender, said) = channel();
        let out: Box<dyn Read + Send> = Box::new(process.stdout.take().unwrap());
        let errors: Box<dyn Read + Send> = Box::new(process.stderr.take().unwrap());
        for output in [out, errors] {
            let sender = sender.clone();
            let lines = BufReader::new(output).lines();
            std::thread::spawn(move || {
                for line in lines.map_while(Result::ok) {
                    let _ = sender.send(line);
                }
            });
        }
        Self {
            process,
            said,
            lines: Vec::new(),
        }
    }

    /// Waits until it says something with this text.
    #[track_caller]
    pub(super) fn says(&mut self, text: &str) {
        let until = Instant::now() + LONG;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match self.said.recv_timeout(left) {
                Ok(line) => {
                    self.lines.push(line);
                    if self.lines.last().is_some_and(|line| line.contains(text)) {
                        return;
                    }
                }
                Err(_) => panic!("`{text}` is not said: {:#?}", self.lines),
            }
        }
    }

    /// Waits for its end. Returns all that it has said.
    pub(super) fn end(mut self) -> (Option<i32>, String) {
        let code = self.process.wait().unwrap().code();
        self.lines.extend(self.said.iter());
        (code, self.lines.join("\n"))
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A program that publishes the presence of a process `second` of the robot, with a driver.
struct Impostor {
    is_ending: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Impostor {
    fn start(vhost: &Vhost<'_>) -> Self {
        let mut settings = AmqpSettings::parse(&vhost.url()).unwrap();
        settings.robot = Some("arm".to_owned());
        let bus = AmqpBus::connect(settings, LONG).unwrap();
        let topic = presence_topic("second");
        let (origin, schema) = (SenderId::new("second", 1), Schema::opaque(PRESENCE));
        let publisher = bus.publisher(&topic, &origin, &schema, PublishOptions::state());
        let mut publisher = publisher.unwrap();
        let presence = Presence {
            process: "second".to_owned(),
            components: vec![PresentComponent {
                name: "Driver".to_owned(),
                ..PresentComponent::default()
            }],
            ..Presence::default()
        };
        let presence = Payload::of(Datum::of(&presence).unwrap());
        let is_ending = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&is_ending);
        let thread = std::thread::spawn(move || {
            while !ends.load(Ordering::Relaxed) {
                publisher.publish(0, presence.clone()).unwrap();
                std::thread::sleep(Duration::from_millis(200));
            }
            drop(bus);
        });
        Self {
            is_ending,
            thread: Some(thread),
        }
    }
}

impl Drop for Impostor {
    fn drop(&mut self) {
        self.is_ending.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Moves the joints and reads them, over the services of the proxy.
pub(super) struct Client(Remote);

impl Client {
    pub(super) fn new(vhost: &Vhost<'_>) -> Self {
        queues(vhost, "robots.services.station.control.station");
        Self(Remote::connect(&vhost.url(), Some("station")).unwrap())
    }

    pub(super) fn call(
        &self,
        service: &str,
        operation: &str,
        argument: Datum,
    ) -> Result<Datum, RemoteError> {
        let facade = self.0.component("Facade").unwrap();
        let service = facade.service(service).unwrap();
        service.call(operation, argument, Duration::from_secs(5))
    }

    pub(super) fn command(&self, position: &[f64]) -> Result<Datum, RemoteError> {
        let position = position.iter().copied().map(Datum::Float).collect();
        let argument = Datum::record([("position", Datum::List(position))]);
        self.call("sending", "setJointsPositions", argument)
    }

    fn position(&self) -> Option<Vec<f64>> {
        let read = self.call("reading", "getJointsPositions", Datum::Record(Vec::new()));
        read.ok()?.get("position")?.to().ok()
    }

    /// Waits until the joints have these positions.
    #[track_caller]
    pub(super) fn reaches(&self, expected: &[f64]) {
        let until = Instant::now() + LONG;
        loop {
            let position = self.position();
            let is_there = position.as_ref().is_some_and(|it| {
                let near = it
                    .iter()
                    .zip(expected)
                    .all(|(is, shall)| (is - shall).abs() < 0.01);
                near && it.len() == expected.len()
            });
            if is_there {
                return;
            }
            assert!(Instant::now() < until, "{position:?}, not {expected:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

#[test]
fn j17_over_a_broker_a_proxy_adapts_to_what_a_robot_announces_which_starts_later() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let mut station = site.station();
    station.says("waiting for `robot://arm/Driver`: robot `arm` is not on the broker");
    let arm = site.arm(6);
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    let goal = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
    client.command(&goal).unwrap();
    client.reaches(&goal);
    let refused = client.command(&[0.1; 5]).unwrap_err().to_string();
    assert!(
        refused.contains("expected a list of 6, found one of 5"),
        "{refused}"
    );
    // the tools show the interface that was announced
    let facade = site.tool(&["component", "info", "station.Facade"]);
    for shown in [
        "setJointsPositions",
        "youbot/JointPositions",
        "youbot/Period",
        "jointStatus",
        "commands",
        "period",
    ] {
        assert!(facade.contains(shown), "{shown}: {facade}");
    }
    let stand_in = site.tool(&["component", "info", "station.Arm"]);
    for shown in [
        "youbot/JointStatus",
        "youbot/JointCommand",
        "std_msgs/Float64",
    ] {
        assert!(stand_in.contains(shown), "{shown}: {stand_in}");
    }

    // back with another number of joints: neither restarted nor configured
    drop(arm.interrupt());
    station.says("`Driver` of robot `arm` has left: commands are dropped until it is back");
    let _arm = site.arm(5);
    client.reaches(&[0.0; 5]);
    client.command(&[0.2; 5]).unwrap();
    client.reaches(&[0.2; 5]);
    let refused = client.command(&goal).unwrap_err().to_string();
    assert!(
        refused.contains("expected a list of 5, found one of 6"),
        "{refused}"
    );
}

#[test]
fn j17_a_robot_without_a_required_port_is_an_error_with_its_place() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let rover = site.write("rover", ROVER);
    let rover = site.robot(&rover, &[]);
    queues(&vhost, "robots.services.arm.control.arm");
    let (code, said) = site.station().end();
    assert_eq!(code, Some(1), "{said}");
    for expected in [
        "error[C150]: no port of `Arm` fits `reading.getJointsPositions`",
        "error[C150]: no port of `Arm` fits `pacing.setPeriod`",
        "station.composite.toml:15",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
    // the robot is there, and has another component only
    let wrong = STATION.replace("arm/Driver", "arm/Drive");
    let mut wrong = Station::start(&mut site.run(&site.write("wrong", &wrong), &[]));
    wrong.says("robot `arm` has no component `Drive`, only `Driver`");
    drop(rover);
}

#[test]
fn j17_a_robot_that_returns_with_another_interface_is_a_fault() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let arm = site.arm(6);
    let station = site.station();
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    drop(arm.interrupt());
    let rover = site.write("rover", ROVER);
    let _rover = site.robot(&rover, &[]);
    let mut station = station;
    station.says("OTHER_INTERFACE: `Driver` of robot `arm` has restarted with no ");
}

#[test]
fn j17_a_second_robot_of_the_name_is_reported_and_changes_nothing() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let _arm = site.arm(6);
    let mut station = site.station();
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    // the name is taken
    let second = site.write("second", &ARM.replace("joints = 6", "joints = 3"));
    let second = Station::start(&mut site.run(&second, &[])).end();
    assert_eq!(second.0, Some(2), "{}", second.1);
    assert!(second.1.contains("is already served"), "{}", second.1);
    // a program that only says so
    let _second = Impostor::start(&vhost);
    station.says("the processes `arm` and `second` of robot `arm` both have a component `Driver`");
    client.command(&[0.3; 6]).unwrap();
    client.reaches(&[0.3; 6]);
    // a proxy that starts now cannot know which one is meant
    let other = STATION.replace("name = \"station\"", "name = \"other\"");
    let other = Station::start(&mut site.run(&site.write("other", &other), &[]));
    let (code, said) = other.end();
    assert_eq!(code, Some(1), "{said}");
    let expected = "the processes `arm` and `second` of robot `arm` all have a component `Driver`";
    assert!(
        said.contains("error[C158]") && said.contains(expected),
        "{said}"
    );
}

#[test]
fn j17_without_a_broker_nothing_is_believed_about_another_robot() {
    let folder = tempfile::tempdir().unwrap();
    let composite = folder.path().join("station.composite.toml");
    std::fs::write(&composite, STATION).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        let output = command.args(arguments).arg(&composite).output().unwrap();
        let said = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(said).unwrap())
    };
    let (code, said) = run(&["check"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("warning[C159]: `robot://arm/Driver` is not verified"),
        "{said}"
    );
    let (code, said) = run(&["run"]);
    assert_eq!(code, Some(2), "{said}");
    let reason = "`robot://arm/Driver` is a component of another robot, which is reached over a broker: add `--bus ";
    assert!(said.contains(reason), "{said}");
    let wrong = STATION.replace("robot://arm/Driver", "robot://arm/Driver.sending");
    std::fs::write(&composite, wrong).unwrap();
    let (code, said) = run(&["check"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("error[C158]") && said.contains("names a service"),
        "{said}"
    );
}

#[test]
fn over_a_broker_a_command_of_another_length_is_refused_without_idle_and_reported_without_a_proxy()
{
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let composite = site.write("arm", ARM);
    let mut arm = Station::start(&mut site.run(&composite, &["--json"]));
    queues(&vhost, "robots.services.arm.control.arm");
    let begin = STATION.find("notify = ").unwrap();
    let station = site.write("station", &STATION[..begin]);
    let mut station = Station::start(&mut site.run(&station, &[]));
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    let refused = client.command(&[0.1; 5]).unwrap_err().to_string();
    let expected = "BAD_ARGUMENT: `position`: expected a list of 6, found one of 5";
    assert!(refused.contains(expected), "{refused}");

    // past the proxy, twice: the robot counts both, and reports the reason once
    for _ in 0..2 {
        site.tool(&[
            "port",
            "write",
            "arm.Driver.commands",
            "{\"position\": [0.1, 0.2]}",
        ]);
    }
    arm.says("\"text\":\"`commands` refuses a message: 2 positions for 6 joints\"");

    // back with another number of joints
    drop(arm);
    station.says("`Driver` of robot `arm`");
    let _arm = site.arm(5);
    client.reaches(&[0.0; 5]);
    let refused = client.command(&[0.1; 6]).unwrap_err().to_string();
    let expected = "BAD_ARGUMENT: `position`: expected a list of 5, found one of 6";
    assert!(refused.contains(expected), "{refused}");
}

/// A driver of its own with a proxy.
const DESK: &str = r#"
schema = "composite/1"
[composite]
name = "station"
[components.Own]
implementation = { rust = "youbot::DummyDriver" }
activity = { period_ms = 20 }
[components.Facade]
implementation = { builtin = "port-proxy", target = "Own" }
activity = { period_ms = 20 }
services = { sending = "youbot/SendingCommands", reading = "youbot/RetrievingStatus", pacing = "youbot/SettingPeriod" }
"#;

#[test]
fn an_argument_that_does_not_fit_is_refused_in_the_words_of_the_operation() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let _station = Station::start(&mut site.run(&site.write("station", DESK), &[]));
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 5]);
    for (service, operation, argument, expected) in [
        (
            "sending",
            "setJointsPositions",
            r#"{"position": [0.1, 0.1, 0.1, 0.1, 0.1], "zz": 1}"#,
            "unknown field `zz`, expected `position`",
        ),
        (
            "pacing",
            "setPeriod",
            r#"{"period_ms": 5}"#,
            "unknown field `period_ms`, expected `period`",
        ),
        (
            "pacing",
            "setPeriod",
            r#"{"period": "5"}"#,
            "`period`: expected `float64`, found a string",
        ),
    ] {
        let argument: Datum = serde_json::from_str(argument).unwrap();
        let refused = client.call(service, operation, argument).unwrap_err();
        let refused = refused.to_string();
        let expected = format!("BAD_ARGUMENT: {expected}");
        assert!(refused.contains(&expected), "{expected}: {refused}");
    }
    // the value of the only field may stand for the record
    client
        .call("pacing", "setPeriod", Datum::Float(0.05))
        .unwrap();
}

/// Sends commands until one is refused, and checks that it is because the robot is not there.
#[track_caller]
fn is_refused(client: &Client, goal: &[f64]) {
    let until = Instant::now() + LONG;
    loop {
        match client.command(goal) {
            Ok(_) => assert!(Instant::now() < until, "commands are accepted"),
            Err(refused) => {
                let refused = refused.to_string();
                let expected = "UNAVAILABLE: what `Arm` stands for cannot be reached";
                return assert!(refused.contains(expected), "{refused}");
            }
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_proxy_of_a_robot_that_is_stopped_or_silent_refuses_commands_and_readings() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let site = Site::new(&vhost);
    let arm = site.arm(6);
    let mut station = site.station();
    let client = Client::new(&vhost);
    client.reaches(&[0.0; 6]);
    let info = || site.tool(&["component", "info", "station.Arm"]);
    assert!(info().contains("present"), "{}", info());

    site.tool(&["component", "stop", "arm.Driver"]);
    is_refused(&client, &[0.9; 6]);
    assert_eq!(client.position(), None, "it would be an old one");
    assert!(
        info().contains("robot `arm` has stopped the component"),
        "{}",
        info()
    );
    site.tool(&["component", "start", "arm.Driver"]);
    client.reaches(&[0.0; 6]);
    client.command(&[0.1; 6]).unwrap();
    client.reaches(&[0.1; 6]);

    // killed: it does not say that it leaves
    drop(arm);
    station.says("commands are dropped until it is back");
    is_refused(&client, &[0.9; 6]);
    assert_eq!(client.position(), None, "it would be an old one");
    assert!(info().contains("robot `arm` "), "{}", info());
    let _arm = site.arm(6);
    client.reaches(&[0.0; 6]);
}
