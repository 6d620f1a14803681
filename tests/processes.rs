//! Missions over a real broker, in one process and in several: the coordinator goes through the same control states.

use asmotion_broker::{SharedBroker, TestBroker, Vhost};
use asmotion_bus::{Bus, Payload, PublishOptions, Publisher, SenderId};
use asmotion_datum::{Datum, Schema};
use asmotion_remote::{PRESENCE, Presence, presence_topic};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A goal near the start of the rover.
const GOAL: &str = "3.4,4.7";
/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(30);

pub(super) fn navigation() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation")
}

/// `asmotion run` of a composite.
pub(super) fn run_any(composite: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite);
    command.args(["--json", "--for", "600"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A short mission of the rover.
fn run(composite: &Path) -> Command {
    let mut command = run_any(composite);
    command.args(["--goal", GOAL]);
    command
}

/// The same over the broker of a test, as the process with this name or all in one.
pub(super) fn over(
    composite: &Path,
    broker: &TestBroker,
    vhost: &Vhost<'_>,
    process: Option<&str>,
) -> Command {
    through(run(composite), broker, vhost, process)
}

/// Adds the broker of a test to a command.
pub(super) fn through(
    mut command: Command,
    broker: &TestBroker,
    vhost: &Vhost<'_>,
    process: Option<&str>,
) -> Command {
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    command.args(["--bus", &url]);
    command.env("ASMOTION_PASSWORD", broker.password());
    command.args(process.iter().flat_map(|name| ["--process", name]));
    command
}

/// A process that is killed at the end of the test.
pub(super) struct Running(Option<Child>);

impl Running {
    pub(super) fn start(command: &mut Command) -> Self {
        Self(Some(command.spawn().unwrap()))
    }

    /// Waits until its gateway is open. Returns its address: `http://127.0.0.1:40123/services`.
    pub(super) fn listening(&mut self) -> String {
        let child = self.0.as_mut().unwrap();
        let lines = BufReader::new(child.stderr.as_mut().unwrap()).lines();
        let mut lines = lines.map(Result::unwrap);
        let line = lines.find(|line| line.contains("Listening")).unwrap();
        let url = line
            .split_whitespace()
            .find(|word| word.starts_with("http"));
        url.unwrap().to_owned()
    }

    /// Waits for its end.
    pub(super) fn end(mut self) -> Output {
        self.0.take().unwrap().wait_with_output().unwrap()
    }

    /// Interrupts it like Ctrl-C.
    pub(super) fn interrupt(self) -> Output {
        self.signal("-INT");
        self.end()
    }

    pub(super) fn signal(&self, signal: &str) {
        let pid = self.0.as_ref().unwrap().id().to_string();
        let status = Command::new("kill").args([signal, &pid]).status();
        assert!(status.unwrap().success());
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The control states of a run, and its exit code.
pub(super) fn modes(output: &Output) -> (Vec<String>, Option<i32>) {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    let mut modes = Vec::new();
    for line in text.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let updates = line["step"]["updates"].as_array().into_iter().flatten();
        let to = updates.filter(|update| update["location"] == "mode");
        modes.extend(to.map(|update| update["after"].as_str().unwrap().to_owned()));
    }
    assert!(
        output.status.success(),
        "{modes:?}\n{text}\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
    (modes, output.status.code())
}

/// Waits until a process of the navigation has declared its queues; the queue of orders is the last.
#[track_caller]
pub(super) fn wait_until_present(vhost: &Vhost<'_>, process: &str) {
    queues(
        vhost,
        &format!("robots.services.navigation.control.{process}"),
    );
}

/// Waits until there are queues with this prefix.
#[track_caller]
pub(super) fn queues(vhost: &Vhost<'_>, prefix: &str) {
    let until = Instant::now() + LONG;
    while !vhost
        .queues()
        .unwrap()
        .iter()
        .any(|queue| queue.starts_with(prefix))
    {
        let known = vhost.queues();
        assert!(
            Instant::now() < until,
            "no queue is called `{prefix}…`: {known:?}"
        );
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// The result with the local bus in virtual time.
pub(super) fn expected() -> (Vec<String>, Option<i32>) {
    let output = run(&navigation().join("navigation.composite.toml"))
        .output()
        .unwrap();
    let (modes, code) = modes(&output);
    assert_eq!(modes.last().map(String::as_str), Some("ARRIVED"));
    (modes, code)
}

#[test]
fn in_one_process_with_everything_over_the_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let output = over(&composite, &broker, &vhost, None).output().unwrap();
    assert_eq!(modes(&output), expected());
}

#[test]
fn in_two_processes_of_which_the_one_on_board_runs_until_it_is_told_to_end() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let supervisor = over(&composite, &broker, &vhost, Some("supervisor"))
        .output()
        .unwrap();
    assert_eq!(modes(&supervisor), expected());
    assert_eq!(modes(&onboard.interrupt()), (Vec::new(), Some(0)));
    assert_eq!(vhost.connections().unwrap(), 0);
}

/// Copies the files that the composite needs. Returns its text.
fn copied(folder: &Path) -> String {
    for name in ["navigate.asm", "maps/office.geojson"] {
        let to = folder.join(name);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(navigation().join(name), to).unwrap();
    }
    let composite = navigation().join("navigation.composite.toml");
    std::fs::read_to_string(composite).unwrap()
}

/// The composite with its planner in a separate process.
pub(super) fn three_processes(folder: &Path) -> PathBuf {
    let text = copied(folder);
    let apart = text.replace(
        r#", "TrajectoryPlanner"] },"#,
        "] },\n  { name = \"planning\", components = [\"TrajectoryPlanner\"] },",
    );
    assert_ne!(text, apart);
    let composite = folder.join("apart.composite.toml");
    std::fs::write(&composite, apart).unwrap();
    composite
}

/// The composite with a broker whose address is in the environment.
fn with_broker(folder: &Path, url: &str) -> Command {
    with_broker_and(folder, url, "")
}

/// The same with additional settings of the broker and text after it.
fn with_broker_and(folder: &Path, url: &str, more: &str) -> Command {
    let broker = format!("[brokers.main]\nurl = \"${{NAVIGATION_BROKER}}\"\n{more}");
    let composite = folder.join("named.composite.toml");
    std::fs::write(&composite, format!("{}\n{broker}", copied(folder))).unwrap();
    let mut command = run(&composite);
    command.env("NAVIGATION_BROKER", url);
    command
}

#[test]
fn over_the_broker_that_the_composite_names_unless_the_bus_is_local() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let over = with_broker(folder.path(), &vhost.url()).output().unwrap();
    assert_eq!(modes(&over), expected());
    let said = String::from_utf8(over.stderr).unwrap();
    assert!(said.contains("wall clock"), "{said}");
    assert!(!said.contains(broker.password()), "{said}");
    let mut local = with_broker(folder.path(), &vhost.url());
    let local = local.args(["--bus", "local"]).output().unwrap();
    assert_eq!(modes(&local), expected());
    let said = String::from_utf8(local.stderr).unwrap();
    assert!(said.contains("virtual clock"), "{said}");
}

#[test]
fn messages_go_by_the_codec_of_the_broker_or_of_their_topic() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let more = "codec = \"cdr\"\n[topics.event]\ncodec = \"json\"\n";
    let spy = asmotion_amqp::AmqpBus::connect(
        asmotion_amqp::AmqpSettings::parse(&vhost.url()).unwrap(),
        LONG,
    )
    .unwrap();
    let size = 100_000;
    let queue = asmotion_bus::QueuePolicy::All {
        size,
        overflow: asmotion_bus::Overflow::DropNewest,
    };
    let notifier = std::sync::Arc::new(asmotion_bus::Notifier::new());
    let seen = asmotion_bus::Bus::subscribe(
        &spy,
        "spy",
        &asmotion_bus::Pattern::new("navigation.#"),
        queue,
        notifier,
    );
    let seen = seen.unwrap();
    let mut over = with_broker_and(folder.path(), &vhost.url(), more);
    let output = over.output().unwrap();
    assert_eq!(modes(&output), expected(), "{output:?}");
    let mut codecs = std::collections::BTreeMap::new();
    while let Some(envelope) = seen.next_within(Duration::from_millis(500)) {
        if let asmotion_bus::Payload::Bytes { codec, .. } = envelope.payload {
            codecs.insert(envelope.topic.to_string(), codec);
        }
    }
    let codec = |topic: &str| codecs.get(&format!("navigation.{topic}")).copied();
    assert_eq!(
        codec("event"),
        Some(asmotion_datum::Codec::Json),
        "{codecs:?}"
    );
    for topic in ["goal", "plan", "odom"] {
        assert_eq!(
            codec(topic),
            Some(asmotion_datum::Codec::Cdr),
            "{topic}: {codecs:?}"
        );
    }
}

#[test]
fn a_broker_that_is_not_there_is_named_with_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let url = "amqp://guest:guest@127.0.0.1:1/cell";
    let output = with_broker(folder.path(), url).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("broker at 127.0.0.1:1/cell"), "{said}");
    assert!(
        said.contains("`--bus local` runs without a broker"),
        "{said}"
    );
}

#[test]
fn in_three_processes_with_a_service_in_another_one() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let start = |process| Running::start(&mut over(&composite, &broker, &vhost, Some(process)));
    let others = [start("onboard"), start("planning")];
    wait_until_present(&vhost, "onboard");
    wait_until_present(&vhost, "planning");
    let supervisor = start("supervisor").end();
    assert_eq!(modes(&supervisor), expected());
    for other in others {
        assert_eq!(modes(&other.interrupt()), (Vec::new(), Some(0)));
    }
}

#[test]
fn c17_in_four_processes_the_coordinator_goes_through_the_same_states() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let text = std::fs::read_to_string(&composite).unwrap();
    let apart = text.replace(
        r#", "LaserDriver", "RoverDriver", "World"] },"#,
        "] },\n  { name = \"world\", components = [\"LaserDriver\", \"RoverDriver\", \"World\"] },",
    );
    assert_ne!(text, apart);
    std::fs::write(&composite, apart).unwrap();
    let start = |process| Running::start(&mut over(&composite, &broker, &vhost, Some(process)));
    let names = ["world", "onboard", "planning"];
    let others = names.map(start);
    names
        .iter()
        .for_each(|name| wait_until_present(&vhost, name));
    let supervisor = start("supervisor").end();
    assert_eq!(modes(&supervisor), expected());
    for other in others {
        assert_eq!(modes(&other.interrupt()), (Vec::new(), Some(0)));
    }
}

#[test]
fn without_its_partner_a_process_goes_on_and_its_calls_fail() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let alone = over(&composite, &broker, &vhost, Some("supervisor"))
        .output()
        .unwrap();
    let text = String::from_utf8(alone.stdout).unwrap();
    assert!(text.contains(r#""error":"unavailable""#), "{text}");
    assert!(text.contains(r#""after":"FAILED""#), "{text}");
    assert_eq!(alone.status.code(), Some(1));
    assert!(onboard.interrupt().status.success());
}

/// Runs a tool. Returns exit code, standard output and standard error.
pub(super) fn tool(
    broker: &SharedBroker,
    url: &str,
    arguments: &[&str],
) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.args(arguments).env("ASMOTION_BUS", url);
    command.env("ASMOTION_PASSWORD", broker.password());
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

#[test]
fn tools_see_who_is_there_and_take_part() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let tool = |arguments: &[&str]| tool(&broker, &url, arguments);
    let composite = navigation().join("navigation.composite.toml");
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");

    let (code, out, err) = tool(&["component", "list"]);
    let driver = out.lines().find(|line| line.starts_with("RoverDriver"));
    let driver = driver.unwrap_or_else(|| panic!("{out}{err}"));
    assert!(driver.contains("navigation  onboard  Running"), "{driver}");
    assert_eq!((code, out.lines().count()), (Some(0), 7), "{out}{err}");

    let (code, out, err) = tool(&["component", "info", "RoverDriver"]);
    assert_eq!(code, Some(0), "{err}");
    assert!(
        out.contains("input       twist: geometry_msgs/Twist"),
        "{out}"
    );
    let (code, _, err) = tool(&["component", "info", "RoverDrive"]);
    assert_eq!(code, Some(2));
    assert!(err.contains("did you mean `RoverDriver`?"), "{err}");

    let state = |component: &str| {
        let (_, out, _) = tool(&["component", "info", component]);
        out
    };
    let (code, _, err) = tool(&["component", "stop", "LaserDriver"]);
    assert_eq!(code, Some(0), "{err}");
    assert!(state("LaserDriver").contains("Stopped"));
    let (code, _, err) = tool(&["component", "start", "navigation.LaserDriver"]);
    assert_eq!(code, Some(0), "{err}");
    assert!(state("LaserDriver").contains("Running"));
    let set = |value| tool(&["component", "set", "TrajectoryFollower", value]);
    let (code, _, err) = set("max_speed=0.25");
    assert_eq!(code, Some(0), "{err}");
    let follower = state("TrajectoryFollower");
    assert!(follower.contains("max_speed = 0.25"), "{follower}");
    let (code, _, err) = set("max_sped=0.25");
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("did you mean `max_speed`?"), "{err}");

    let (_, out, err) = tool(&["topic", "list"]);
    let odom = out
        .lines()
        .find(|line| line.starts_with("navigation.odom "));
    let odom = odom.unwrap_or_else(|| panic!("{out}{err}"));
    assert!(odom.contains("nav_msgs/Odometry"), "{odom}");

    let (code, out, err) = tool(&["topic", "hz", "navigation.odom", "--for", "2"]);
    assert_eq!(code, Some(0), "{out}{err}");
    let (code, out, err) = tool(&["topic", "echo", "navigation.odom", "--count", "1"]);
    assert_eq!(code, Some(0), "{err}");
    let message: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(message["source"], "RoverDriver");
    assert_eq!(message["content"]["header"]["frame_id"], "map");
    assert!(onboard.interrupt().status.success());

    let (code, _, err) = tool(&["topic", "pub", "navigation.estop", r#"{"data":true}"#]);
    assert_eq!(code, Some(0), "{err}");
    assert!(
        err.contains("`navigation.estop` has no subscriber"),
        "{err}"
    );
    // without the goal of the script, which fails without the rover and ends the process
    let mut supervisor = through(run_any(&composite), &broker, &vhost, Some("supervisor"));
    supervisor.args(["--set", "Operator.script=[]"]);
    let supervisor = Running::start(&mut supervisor);
    wait_until_present(&vhost, "supervisor");
    // a process announces itself before its subscriptions are made
    let published = || tool(&["topic", "pub", "navigation.estop", r#"{"data":true}"#]);
    let mut attempts = (0..20).map(|_| published());
    let heard = attempts.find(|(code, _, err)| (*code, err.as_str()) == (Some(0), ""));
    assert!(heard.is_some(), "{:?}", published());

    // a message that a reader cannot read is refused, unless it is sent on purpose
    for (message, reason) in [(r#"{"data":5}"#, "`data`"), (r#"{"dat":true}"#, "`dat`")] {
        let (code, _, err) = tool(&["topic", "pub", "navigation.estop", message]);
        assert_eq!(code, Some(2), "{err}");
        let reader = "`navigation.ASMCoordinator.estop` takes std_msgs/Bool";
        assert!(err.contains(reader) && err.contains(reason), "{err}");
        // so is one to a port of the specification alone, which would only count it
        let write = ["port", "write", "ASMCoordinator.estop", message];
        let (code, out, err) = tool(&write);
        assert_eq!((code, &*out), (Some(2), ""), "{err}");
        let port = "`ASMCoordinator.estop` takes std_msgs/Bool";
        assert!(err.contains(port) && err.contains(reason), "{err}");
        let unchecked = ["topic", "pub", "navigation.estop", message, "--unchecked"];
        assert_eq!(tool(&unchecked).0, Some(0));
    }
    let (code, _, err) = tool(&["topic", "echo", "navigation.estpo", "--for", "2"]);
    assert_eq!(code, Some(1));
    assert!(
        err.contains("no running process has a topic `navigation.estpo`"),
        "{err}"
    );
    assert!(err.contains("did you mean `navigation.estop`?"), "{err}");

    // the name of a topic begins with the robot
    let (_, _, err) = tool(&["topic", "pub", "estop", r#"{"data":true}"#]);
    assert!(err.contains("`estop` has no subscriber"), "{err}");
    assert!(err.contains("did you mean `navigation.estop`?"), "{err}");

    // the state of the coordinator is visible
    let coordinator = state("ASMCoordinator");
    assert!(
        coordinator.contains("  state       command = "),
        "{coordinator}"
    );
    assert!(coordinator.contains("mode = IDLE"), "{coordinator}");
    assert!(coordinator.contains("estop = true"), "{coordinator}");
    let (_, out, _) = tool(&["component", "list"]);
    let row = out.lines().find(|line| line.starts_with("ASMCoordinator"));
    assert!(row.unwrap().contains("mode = IDLE"), "{out}");

    let map = "navigation.MapServer.maps.getMap";
    let (code, out, err) = tool(&["call", map, r#"{"name":"office"}"#]);
    assert_eq!(code, Some(0), "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    assert!(answer.to_string().contains("resolution"), "{answer}");
    let (code, _, err) = tool(&["call", map, r#"{"name":"nowhere"}"#]);
    assert_eq!(code, Some(1), "{err}");
    let (code, _, err) = tool(&["call", "navigation.MapServer.maps.getMop"]);
    assert_eq!(code, Some(1));
    assert!(err.contains(&format!("did you mean `{map}`?")), "{err}");
    drop(supervisor);
}

#[test]
fn the_doctor_says_what_is_wrong_and_how_to_mend_it() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let at = |who: &str, vhost: &str| format!("amqp://{who}@{address}/{vhost}");
    let doctor = |url: &str| {
        let (code, out, err) = tool(&broker, url, &["doctor"]);
        let hidden = out.replace(&address.to_string(), "HOST");
        let hidden = hidden.replace(vhost.name(), "VHOST");
        // the queue's name contains the id of the process' run
        let words = hidden.split(' ').map(|word| {
            if word.contains(".asmotion.doctor.") {
                "'QUEUE'"
            } else {
                word
            }
        });
        (code, words.collect::<Vec<_>>().join(" ") + &err)
    };
    let (code, said) = doctor(&at(user, vhost.name()));
    assert_eq!(code, Some(0), "{said}");
    insta::assert_snapshot!("doctor_well", said);

    let may_not_write = format!("{}-mute", vhost.name());
    broker.add_user(&may_not_write, broker.password()).unwrap();
    let (code, stranger) = doctor(&at(&may_not_write, vhost.name()));
    assert_eq!(code, Some(1), "{stranger}");
    let write = |names| vhost.permit(&may_not_write, ".*", names, ".*").unwrap();
    write("nothing");
    let (code, deaf) = doctor(&at(&may_not_write, vhost.name()));
    assert_eq!(code, Some(1), "{deaf}");
    write("asmotion-tool.*");
    let (code, mute) = doctor(&at(&may_not_write, vhost.name()));
    assert_eq!(code, Some(1), "{mute}");
    let (code, password) = doctor(&at(&format!("{user}:wrong"), vhost.name()));
    assert_eq!(code, Some(1), "{password}");
    assert!(!password.contains("wrong "), "{password}");
    let (code, missing) = doctor(&at(user, "nowhere"));
    assert_eq!(code, Some(1), "{missing}");
    let (code, closed) = doctor("amqp://127.0.0.1:1/x");
    assert_eq!(code, Some(1), "{closed}");
    insta::assert_snapshot!(
        "doctor_ill",
        [stranger, deaf, mute, password, missing, closed].join("\n")
    );
}

#[test]
fn the_doctor_compares_the_clocks_of_running_processes() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let settings = asmotion_amqp::AmqpSettings::parse(&vhost.url()).unwrap();
    let bus = asmotion_amqp::AmqpBus::connect(settings, LONG).unwrap();
    let url = vhost.url();
    // two processes, the clock of one of which is wrong by this many seconds
    let doctor = |seconds: i32| {
        let mut processes = [("onboard", 0), ("station", seconds)]
            .map(|(process, ahead)| (presence_publisher(&bus, process), presence(process), ahead));
        let mut child = Command::new(env!("CARGO_BIN_EXE_asmotion"))
            .args(["doctor", "--bus", &url])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        while child.try_wait().unwrap().is_none() {
            publish_presences(&mut processes);
            std::thread::sleep(Duration::from_millis(100));
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        (output.status.code(), said)
    };
    let (code, said) = doctor(0);
    assert_eq!(code, Some(0), "{said}");
    let agree = "the clocks of 2 processes agree with that of this machine";
    assert!(said.contains(agree), "{said}");
    for (seconds, direction) in [(10, "ahead of"), (-7, "behind")] {
        let (code, said) = doctor(seconds);
        assert_eq!(code, Some(1), "{said}");
        let of_station = "the clock of process `rover1.station` is ";
        let (_, rest) = said.split_once(of_station).expect(&said);
        let (difference, rest) = rest.split_once(" s ").unwrap();
        // less by the time that the fastest message takes
        let wrong = (difference.parse::<f64>().unwrap() - f64::from(seconds.abs())).abs();
        assert!(wrong <= 0.4, "{said}");
        assert!(
            rest.starts_with(&format!("{direction} that of this machine")),
            "{said}"
        );
        assert!(!said.contains("onboard"), "{said}");
        assert!(said.contains("timedatectl"), "{said}");
    }
}

/// A run compares its clock with those of the other processes, and reports each difference once.
#[test]
fn a_run_reports_the_clock_of_another_process_that_is_ahead_or_behind() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    for (seconds, direction) in [(10, "ahead of"), (-7, "behind")] {
        let vhost = broker.vhost().unwrap();
        let settings = asmotion_amqp::AmqpSettings::parse(&vhost.url()).unwrap();
        let bus = asmotion_amqp::AmqpBus::connect(settings, LONG).unwrap();
        let composite = navigation().join("navigation.composite.toml");
        let mut command = run_any(&composite);
        command.args(["--bus", &vhost.url(), "--robot", "rover1"]);
        let mut child = command.stdout(Stdio::null()).spawn().unwrap();
        let stderr = child.stderr.take().unwrap();
        let lines = BufReader::new(stderr).lines().map_while(Result::ok);
        let reader = std::thread::spawn(move || lines.collect::<Vec<_>>());
        let mut processes = [("onboard", 0), ("station", seconds)]
            .map(|(process, ahead)| (presence_publisher(&bus, process), presence(process), ahead));
        for _ in 0..50 {
            publish_presences(&mut processes);
            std::thread::sleep(Duration::from_millis(200));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let lines = reader.join().unwrap();
        let reports = lines
            .iter()
            .filter(|line| line.contains("the clock of process"));
        let reports: Vec<&String> = reports.collect();
        let [report] = reports[..] else {
            panic!("{lines:?}");
        };
        assert!(report.contains("process `station`"), "{report}");
        let what = format!("{direction} that of this machine: synchronise");
        assert!(report.contains(&what), "{report}");
    }
}

type PublishedPresence = (Box<dyn Publisher>, Datum, i32);

/// Publishes the presence of processes whose clocks are ahead by some seconds.
fn publish_presences(processes: &mut [PublishedPresence]) {
    for (publisher, presence, ahead) in processes {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let stamp = now.as_nanos() as i64 + i64::from(*ahead) * 1_000_000_000;
        publisher
            .publish(stamp, Payload::of(presence.clone()))
            .unwrap();
    }
}

fn presence(process: &str) -> Datum {
    Datum::of(&Presence {
        process: process.to_owned(),
        ..Presence::default()
    })
    .unwrap()
}

fn presence_publisher(bus: &dyn Bus, process: &str) -> Box<dyn Publisher> {
    let topic = format!("rover1.{}", presence_topic(process));
    bus.publisher(
        &topic,
        &SenderId::new(process, 1),
        &Schema::opaque(PRESENCE),
        PublishOptions::state(),
    )
    .unwrap()
}

#[test]
fn the_doctor_names_an_exchange_of_another_type() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (code, said, _) = tool(&broker, &vhost.url(), &["doctor"]);
    assert_eq!(code, Some(0), "{said}");
    vhost.replace_exchange("robots", "fanout").unwrap();
    let (code, said, _) = tool(&broker, &vhost.url(), &["doctor"]);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.contains("bad  no connection: exchange `robots`: PRECONDITION_FAILED"),
        "{said}"
    );
    assert!(said.contains("delete exchange name=robots`"), "{said}");
}

#[test]
fn the_doctor_sees_an_alarm() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let url = vhost.url();
    broker.raise_alarm().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command.args(["doctor", "--bus", &url]).output().unwrap();
    broker.clear_alarm().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("rabbitmq-diagnostics alarms"), "{said}");
    assert!(!said.contains(broker.password()), "{said}");
}

#[test]
fn a_process_of_several_needs_a_broker_and_a_name_that_exists() {
    let composite = navigation().join("navigation.composite.toml");
    let said = |arguments: &[&str]| {
        let output = run(&composite).args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let without = said(&["--process", "onboard"]);
    assert!(without.contains("add `--bus amqp://"), "{without}");
    let misspelt = said(&["--process", "onbord"]);
    assert!(misspelt.contains("did you mean `onboard`?"), "{misspelt}");
    let clock = said(&["--bus", "amqp://a:b@h", "--clock", "virtual"]);
    assert!(clock.contains("uses the wall clock"), "{clock}");
}

/// A message of one specification is a request to the other, in whichever process that runs.
#[test]
fn two_specifications_talk_over_a_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/courier/courier.composite.toml");
    let two_jobs = || {
        let mut command = run_any(&composite);
        command.args(["--until", "jobs=2"]);
        command
    };
    // a run goes on for a while after its end condition
    let first = |output: &Output| {
        let (mut modes, code) = modes(output);
        modes.truncate(4);
        (modes, code)
    };
    let local = first(&two_jobs().output().unwrap());
    assert_eq!(local.0, ["UNDERWAY", "ASKING", "UNDERWAY", "ASKING"]);
    let together = through(two_jobs(), &broker, &vhost, None).output();
    assert_eq!(first(&together.unwrap()), local);
    let mut office = through(run_any(&composite), &broker, &vhost, Some("office"));
    let office = Running::start(&mut office);
    queues(&vhost, "robots.services.courier.Dispatcher.");
    let street = through(two_jobs(), &broker, &vhost, Some("street")).output();
    assert_eq!(first(&street.unwrap()), local);
    office.interrupt();
}
