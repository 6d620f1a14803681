//! The case study in several processes over a real broker: the locomotor goes through the same control states, and
//! outdated data are never shown as current when the link is cut.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion::top::{Board, Silence};
use asmotion_amqp::{AmqpBus, AmqpSettings};
use asmotion_broker::Vhost;
use asmotion_bus::{Bus, LinkState, Notifier, Overflow, Pattern, QueuePolicy, Subscription};
use serde_json::Value;

use crate::faults::{Heard, entered, enters};
use crate::processes::{Running, modes, queues, run_any};

fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/youbot/youbot.composite.toml")
}

/// A command that runs one of its processes.
fn process(composite: &Path, vhost: &Vhost<'_>, name: &str) -> Command {
    let mut command = run_any(composite);
    command.args(["--bus", &vhost.url(), "--process", name]);
    command
}

/// Starts a process that may lack listeners, and waits until it takes orders, which means that all its queues are
/// declared.
fn started(composite: &Path, vhost: &Vhost<'_>, name: &str) -> Running {
    let mut process = process(composite, vhost, name);
    let running = Running::start(process.stdout(Stdio::null()));
    queues(vhost, &format!("robots.services.youbot.control.{name}"));
    running
}

/// Two goals without a broker, in virtual time.
fn expected() -> Vec<String> {
    let mut command = run_any(&shipped());
    let output = command.args(["--until", "mode=IDLE"]).output().unwrap();
    let (first, _) = modes(&output);
    assert_eq!(first[..2], ["BUSY", "IDLE"]);
    [&first[..2], &first[..2]].concat()
}

/// The first `count` control states of the process with the locomotor.
fn first_modes(locomotor: &mut Command, count: usize) -> Vec<String> {
    let mut monitor = Heard::start(locomotor);
    let (mut told, mut modes) = (Vec::new(), Vec::new());
    while modes.len() < count {
        let entered = monitor.until(&mut told, |line| !entered(line).is_empty());
        let entered = entered.unwrap_or_else(|| panic!("after {modes:?} nothing: {told:#?}"));
        modes.extend(self::entered(&entered));
    }
    modes
}

/// The expanded composite, with its components assigned to these processes and long timeouts for a loaded machine.
fn placed(folder: &Path, processes: &[(&str, &[&str])]) -> PathBuf {
    let mut expand = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let opened = expand.arg("expand").arg(shipped()).output().unwrap();
    let opened = String::from_utf8(opened.stdout).unwrap();
    let (whole, _) = opened.split_once("[deploy]").unwrap();
    let patient = whole.replace("stale_ms = 1000", "stale_ms = 20000");
    let patient = patient.replace("timeout_ms = 500", "timeout_ms = 20000");
    assert_eq!(patient.matches("_ms = 20000").count(), 4, "{whole}");
    let process = |(name, components): &(&str, &[&str])| {
        format!("  {{ name = {name:?}, components = {components:?} }},\n")
    };
    let processes: String = processes.iter().map(process).collect();
    let composite = folder.join("youbot.composite.toml");
    let deployed = format!("{patient}[deploy]\nprocesses = [\n{processes}]\n");
    std::fs::write(&composite, deployed).unwrap();
    for file in ["youbot.asm", "driver_protocol.asm"] {
        std::fs::copy(shipped().with_file_name(file), folder.join(file)).unwrap();
    }
    composite
}

#[test]
fn c17_in_two_processes_the_locomotor_goes_through_the_same_states() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let robot: &[&str] = &["Driver/youBotDriver", "Driver/SCAyouBotDriver"];
    let station: &[&str] = &["Locomotor", "Kinematics", "Operator"];
    let composite = placed(folder.path(), &[("robot", robot), ("station", station)]);
    let robot = started(&composite, &vhost, "robot");
    let expected = expected();
    let mut station = process(&composite, &vhost, "station");
    assert_eq!(first_modes(&mut station, expected.len()), expected);
    assert!(robot.interrupt().status.success());
}

#[test]
fn c17_in_four_processes_with_the_driver_and_its_proxy_apart() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let others: [(&str, &[&str]); 3] = [
        ("arm", &["Driver/youBotDriver"]),
        ("proxy", &["Driver/SCAyouBotDriver"]),
        ("desk", &["Operator", "Kinematics"]),
    ];
    let all = [&others[..], &[("brain", &["Locomotor"])]].concat();
    let composite = placed(folder.path(), &all);
    let others = others.map(|(name, _)| started(&composite, &vhost, name));
    let expected = expected();
    let mut brain = process(&composite, &vhost, "brain");
    assert_eq!(first_modes(&mut brain, expected.len()), expected);
    for other in others {
        assert!(other.interrupt().status.success());
    }
}

/// A library that shows a process another time of day, ahead by as many seconds as `AHEAD` says; the monotonic clock is as it is.
const WRONG_CLOCK: &str = "
#define _GNU_SOURCE
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
int clock_gettime(clockid_t clock, struct timespec *time) {
    int result = (int)syscall(SYS_clock_gettime, clock, time);
    if (result == 0 && clock == CLOCK_REALTIME) {
        time->tv_sec += atol(getenv(\"AHEAD\"));
    }
    return result;
}
";

/// A station whose clock differs by more than the timeout of every call, as on a computer that has lost its battery.
#[test]
#[cfg(target_os = "linux")]
fn c17_a_station_with_a_wrong_clock_moves_the_arm() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    if !asmotion_skip::has_compiler() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (source, library) = (
        folder.path().join("clock.c"),
        folder.path().join("clock.so"),
    );
    std::fs::write(&source, WRONG_CLOCK).unwrap();
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).arg(&library);
    assert!(compiler.arg(&source).status().unwrap().success());
    let robot: &[&str] = &["Driver/youBotDriver", "Driver/SCAyouBotDriver"];
    let station: &[&str] = &["Locomotor", "Kinematics", "Operator"];
    let composite = placed(folder.path(), &[("robot", robot), ("station", station)]);
    let expected = expected();
    for ahead in ["3600", "-3600"] {
        let vhost = broker.vhost().unwrap();
        let robot = started(&composite, &vhost, "robot");
        let mut station = process(&composite, &vhost, "station");
        station.env("LD_PRELOAD", &library).env("AHEAD", ahead);
        let modes = first_modes(&mut station, expected.len());
        assert_eq!(modes, expected, "ahead by {ahead} s");
        assert!(robot.interrupt().status.success());
    }
}

/// The state of `asmotion top`.
struct Monitor {
    bus: AmqpBus,
    everything: Subscription,
    board: Board,
    began: Instant,
}

impl Monitor {
    fn start(vhost: &Vhost<'_>) -> Self {
        let settings = AmqpSettings::parse(&vhost.url()).unwrap();
        let bus = AmqpBus::connect(settings, Duration::from_secs(10)).unwrap();
        let queue = QueuePolicy::All {
            size: 10_000,
            overflow: Overflow::DropOldest,
        };
        let notifier = Arc::new(Notifier::new());
        let everything = bus.subscribe("monitor", &Pattern::new("#"), queue, notifier);
        Self {
            everything: everything.unwrap(),
            bus,
            board: Board::default(),
            began: Instant::now(),
        }
    }

    /// Waits until the board satisfies a predicate.
    #[track_caller]
    fn shows(&mut self, what: &str, predicate: impl Fn(&Board, Duration) -> bool) {
        let until = Instant::now() + Duration::from_secs(30);
        loop {
            while let Some(envelope) = self.everything.try_next() {
                self.board.receive(&envelope, self.began.elapsed());
            }
            let now = self.began.elapsed();
            self.board.set_link(self.bus.health().link, now);
            if predicate(&self.board, now) {
                return;
            }
            assert!(Instant::now() < until, "{what} is not shown");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Whether a component is shown as silent; `None` if it is unknown.
fn silent(board: &Board, now: Duration, component: &str) -> Option<bool> {
    let mut components = board.components(now);
    let found = components.find(|it| it.present.name == component)?;
    Some(matches!(found.silence, Some(Silence::Stale(_))))
}

fn is_stale(board: &Board, now: Duration, topic: &str) -> Option<bool> {
    let found = board.topics().find(|it| it.name == topic)?;
    (found.count > 10).then(|| found.is_stale(now))
}

/// Starts the robot with a low speed, so that its link can be cut in the middle of a motion.
fn slow_robot(vhost: &Vhost<'_>) -> Running {
    let mut robot = process(&shipped(), vhost, "robot");
    robot.args(["--set", "Driver/youBotDriver.speed=0.2"]);
    let robot = Running::start(robot.stdout(Stdio::null()));
    queues(vhost, "robots.services.youbot.control.robot");
    robot
}

#[test]
fn y11_where_the_link_is_cut_nothing_old_is_shown_as_new_and_then_it_goes_on() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let _robot = slow_robot(&vhost);
    let mut monitor = Monitor::start(&vhost);
    let mut station = Heard::start(&mut process(&shipped(), &vhost, "station"));
    let mut events = Vec::new();
    assert!(station.until(&mut events, enters("BUSY")).is_some());
    let (arm, joints) = ("Driver/youBotDriver", "youbot.jointStatus");
    let well = |board: &Board, now| {
        let components = [arm, "Locomotor"].map(|it| silent(board, now, it));
        components == [Some(false); 2] && is_stale(board, now, joints) == Some(false)
    };
    monitor.shows("a system that is well", well);

    broker.kill().unwrap();
    assert!(station.until(&mut events, enters("FAULT")).is_some());
    monitor.shows("that the link is cut", |board, now| {
        let link = board
            .link
            .as_ref()
            .is_some_and(|(link, _)| !matches!(link, LinkState::Up));
        let stale = is_stale(board, now, joints) == Some(true);
        link && stale && silent(board, now, arm) == Some(true)
    });
    broker.revive().unwrap();
    monitor.shows("that all is well again", well);
    assert!(station.until(&mut events, enters("IDLE")).is_some());
    assert!(station.until(&mut events, enters("BUSY")).is_some());
}

#[test]
fn y11_a_robot_that_is_out_of_reach_is_stale_to_all() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let robot = slow_robot(&vhost);
    let mut monitor = Monitor::start(&vhost);
    let mut station = Heard::start(&mut process(&shipped(), &vhost, "station"));
    let mut events: Vec<Value> = Vec::new();
    assert!(station.until(&mut events, enters("BUSY")).is_some());
    let joints = "youbot.jointStatus";
    monitor.shows("a robot that moves", |board, now| {
        is_stale(board, now, joints) == Some(false)
    });
    // as if its cable were pulled: the connections exist, and nothing arrives
    robot.signal("-STOP");
    assert!(station.until(&mut events, enters("FAULT")).is_some());
    monitor.shows(
        "the silence of the robot, and of nobody else",
        |board, now| {
            let silent = |component| silent(board, now, component);
            silent("Driver/youBotDriver") == Some(true)
                && silent("Locomotor") == Some(false)
                && is_stale(board, now, joints) == Some(true)
        },
    );
    robot.signal("-CONT");
    assert!(station.until(&mut events, enters("IDLE")).is_some());
}
