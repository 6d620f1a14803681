//! For tests: a private master of ROS 1, and nodes of rospy.
//!
//! Panics are how a test fails.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::missing_panics_doc,
    clippy::indexing_slicing,
    reason = "part of tests"
)]

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_bus::{Notifier, Overflow, QueuePolicy};
use asmotion_datum::Datum;
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind, InterfaceName};
use asmotion_ros1::{RosNode, RosNotice, RosSettings, RosTiming, RosUri, ServiceType, TopicType};
use serde_json::{Value, json};

/// Python of the system, for which Debian installs ROS.
const PYTHON: &str = "/usr/bin/python3";
/// Patience for something that should happen soon.
pub const SOON: Duration = Duration::from_secs(60);

/// Whether ROS is installed; reports that a test is skipped if it is not.
pub fn has_ros() -> bool {
    let mut command = Command::new(PYTHON);
    let modules = "import rospy, rosmaster, rosnode, rostopic, rosservice, actionlib, geometry_msgs, nav_msgs, std_srvs";
    let status = command.args(["-c", modules]).stderr(Stdio::null()).status();
    let is_installed = status.is_ok_and(|it| it.success());
    if !is_installed {
        asmotion_skip::ROSPY.skip();
    }
    is_installed
}

/// A process that ends with the test.
pub struct Process {
    child: Child,
    /// Lines of its standard output.
    lines: Receiver<String>,
    input: ChildStdin,
}

impl Process {
    /// Starts a program of Python that finds the master at this port.
    fn start(arguments: &[&str], port: u16) -> Self {
        let mut command = Command::new(PYTHON);
        command
            .args(arguments)
            .env("ROS_MASTER_URI", format!("http://127.0.0.1:{port}/"))
            .env("ROS_IP", "127.0.0.1")
            .env("ROS_PACKAGE_PATH", "/usr/share")
            .env("ROS_HOME", std::env::temp_dir().join("asmotion-ros-test"))
            .env("PYTHONUNBUFFERED", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let (output, input) = (child.stdout.take().unwrap(), child.stdin.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self {
            child,
            lines,
            input,
        }
    }

    /// The next line of its output.
    ///
    /// # Panics
    /// There is none soon.
    #[track_caller]
    pub fn line(&self) -> String {
        self.lines.recv_timeout(SOON).expect("a line of the peer")
    }

    /// The next line of its output, if there is one.
    pub fn try_line(&self) -> Option<String> {
        self.lines.try_recv().ok()
    }

    /// Writes a line to its input.
    pub fn tell(&mut self, line: &str) {
        writeln!(self.input, "{line}").unwrap();
        self.input.flush().unwrap();
    }

    /// Sends a signal such as `STOP`.
    pub fn signal(&self, signal: &str) {
        let signal = format!("-{signal}");
        let process = self.child.id().to_string();
        let status = Command::new("kill").args([&signal, &process]).status();
        assert!(status.unwrap().success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A master of ROS at a port of its own.
pub struct Master {
    /// Port of the master.
    pub port: u16,
    process: Option<Process>,
}

impl Master {
    /// Starts a master; `None`, with a notice, if ROS is not installed.
    pub fn start() -> Option<Self> {
        if !has_ros() {
            return None;
        }
        let [port] = asmotion_skip::free_ports().unwrap();
        let mut master = Self {
            port,
            process: None,
        };
        master.restart();
        Some(master)
    }

    /// Starts the process of the master again.
    pub fn restart(&mut self) {
        self.kill();
        let port = self.port.to_string();
        let program = "/usr/bin/rosmaster";
        self.process = Some(Process::start(&[program, "--core", "-p", &port], self.port));
        eventually("the master listens", || {
            std::net::TcpStream::connect(("127.0.0.1", self.port)).ok()
        });
    }

    /// Kills the process of the master.
    pub fn kill(&mut self) {
        self.process = None;
    }

    /// Runs a script of `peers/`, which takes part in the system.
    ///
    /// # Panics
    /// The script cannot be started.
    pub fn peer(&self, script: &str, arguments: &[&str]) -> Process {
        let path = format!("{}/peers/{script}.py", env!("CARGO_MANIFEST_DIR"));
        let mut all = vec![&*path];
        all.extend(arguments);
        Process::start(&all, self.port)
    }

    /// Starts a node of `asmotion-ros1`.
    pub fn node(&self, name: &str) -> TestNode {
        TestNode::start(self.port, name, |_| ())
    }

    /// Starts a node of rospy that does what its input says (`peers/node.py`).
    ///
    /// # Panics
    /// The node cannot be started.
    pub fn rospy(&self, name: &str) -> RospyNode {
        let node = RospyNode {
            process: self.peer("node", &[name]),
            unread: VecDeque::new(),
        };
        node.process.line();
        node
    }

    /// The address of the master, `ROS_MASTER_URI`.
    pub fn uri(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// The output of a tool of ROS, such as `rosnode list`.
    pub fn tool(&self, tool: &str, arguments: &[&str]) -> String {
        let mut command = Command::new(PYTHON);
        let output = command
            .arg(format!("/usr/bin/{tool}"))
            .args(arguments)
            .env("ROS_MASTER_URI", format!("http://127.0.0.1:{}/", self.port))
            .env("ROS_IP", "127.0.0.1")
            .env("ROS_PACKAGE_PATH", "/usr/share")
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(
            output.status.success(),
            "{text}{}",
            String::from_utf8_lossy(&output.stderr)
        );
        text
    }
}

/// A node of rospy.
pub struct RospyNode {
    process: Process,
    /// Lines that were not awaited yet.
    unread: VecDeque<Value>,
}

impl RospyNode {
    /// Gives a command to the node, and waits until it is done.
    ///
    /// # Panics
    /// The node does not answer soon.
    pub fn obey(&mut self, command: Value) {
        self.process.tell(&command.to_string());
        loop {
            let line = self.read();
            if line[0] == "done" {
                return;
            }
            self.unread.push_back(line);
        }
    }

    /// Subscribes to a topic.
    pub fn subscribe(&mut self, topic: &str, kind: &str) {
        self.obey(json!(["subscribe", topic, kind]));
    }

    /// Announces a topic, which is published later, and waits until so many nodes have subscribed to it.
    pub fn advertise(&mut self, topic: &str, kind: &str, subscribers: usize) {
        self.obey(json!(["advertise", topic, kind]));
        self.obey(json!(["connections", topic, subscribers]));
    }

    /// Publishes a message.
    pub fn publish(&mut self, topic: &str, kind: &str, message: Value) {
        self.obey(json!(["publish", topic, kind, message, false]));
    }

    /// The next message of a topic: its content, and the name of its publisher. Messages of other topics are kept.
    ///
    /// # Panics
    /// There is none soon.
    pub fn message(&mut self, topic: &str) -> (Value, String) {
        let line = self.event("message", topic);
        let publisher = line[3].as_str().unwrap_or_default().to_owned();
        (line[2].clone(), publisher)
    }

    /// The next line of this kind about a topic, service, action or parameter, such as `["request", service, request]`. Other
    /// lines are kept.
    ///
    /// # Panics
    /// There is none soon.
    pub fn event(&mut self, kind: &str, of: &str) -> Value {
        let is_of = |line: &Value| line[0] == *kind && line[1] == *of;
        let found = self.unread.iter().position(is_of);
        if let Some(line) = found.and_then(|at| self.unread.remove(at)) {
            return line;
        }
        loop {
            let line = self.read();
            if is_of(&line) {
                return line;
            }
            self.unread.push_back(line);
        }
    }

    /// The number of messages of a topic that have arrived and were not awaited.
    pub fn waiting(&mut self, topic: &str) -> usize {
        while let Some(line) = self.process.try_line() {
            self.unread.push_back(parsed(&line));
        }
        let of_topic = |line: &&Value| line[0] == "message" && line[1] == *topic;
        self.unread.iter().filter(of_topic).count()
    }

    /// Stops the process, so that it reads nothing.
    ///
    /// # Panics
    /// It cannot be stopped.
    pub fn pause(&self) {
        self.process.signal("STOP");
    }

    /// Lets a stopped process go on.
    ///
    /// # Panics
    /// It has ended.
    pub fn go_on(&self) {
        self.process.signal("CONT");
    }

    fn read(&self) -> Value {
        parsed(&self.process.line())
    }
}

fn parsed(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|_| panic!("the peer printed {line}"))
}

/// A node of this library, and its notices.
pub struct TestNode {
    /// The node itself, which may not be registered yet.
    pub node: RosNode,
    notices: Arc<Mutex<Vec<RosNotice>>>,
}

impl TestNode {
    /// Starts a node that finds the master at this port. `change` changes its settings.
    pub fn start(port: u16, name: &str, change: impl FnOnce(&mut RosSettings)) -> Self {
        let notices = Arc::new(Mutex::new(Vec::new()));
        let mut settings = RosSettings {
            master: RosUri::new("127.0.0.1", port),
            timing: RosTiming {
                check: Duration::from_millis(200),
                last_retry: Duration::from_millis(500),
                ..RosTiming::default()
            },
            ..RosSettings::new(name)
        };
        settings.notices = Arc::new({
            let notices = Arc::clone(&notices);
            move |notice| notices.lock().unwrap().push(notice.clone())
        });
        change(&mut settings);
        let node = RosNode::start(settings).unwrap();
        Self { node, notices }
    }

    /// The node, once the master knows all that it takes part in.
    pub fn registered(&self) -> &RosNode {
        self.node.await_registered(SOON).unwrap();
        &self.node
    }

    /// Its notices so far.
    pub fn notices(&self) -> Vec<RosNotice> {
        self.notices.lock().unwrap().clone()
    }

    /// Waits for a notice.
    pub fn notice<T>(&self, what: &str, find: impl Fn(&RosNotice) -> Option<T>) -> T {
        eventually(what, || self.notices().iter().find_map(&find))
    }
}

/// Waits until a condition has a value.
pub fn eventually<T>(what: &str, mut condition: impl FnMut() -> Option<T>) -> T {
    let until = Instant::now() + SOON;
    loop {
        if let Some(value) = condition() {
            return value;
        }
        assert!(Instant::now() < until, "not within {SOON:?}: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The type of a topic in Noetic.
pub fn topic_type(name: &str) -> TopicType {
    let noetic = Catalogue::included(Distribution::Ros1);
    TopicType::of(&noetic, &name.parse().unwrap()).unwrap()
}

/// The type of a service in Noetic.
pub fn service_type(package: &str, name: &str) -> ServiceType {
    let noetic = Catalogue::included(Distribution::Ros1);
    let name = InterfaceName::new(package, InterfaceKind::Service, name).unwrap();
    ServiceType::of(&noetic, &name).unwrap()
}

/// A message of `std_msgs/String`.
pub fn string(text: &str) -> Datum {
    Datum::record([("data", Datum::text(text))])
}

/// A queue for so many messages.
pub fn all(size: usize) -> QueuePolicy {
    QueuePolicy::All {
        size,
        overflow: Overflow::DropNewest,
    }
}

/// A notifier that nobody waits for.
pub fn notifier() -> Arc<Notifier> {
    Arc::new(Notifier::new())
}
