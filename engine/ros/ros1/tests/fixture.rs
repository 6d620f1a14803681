//! A private master, nodes of rospy, and nodes of this library.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_bus::{Notifier, Overflow, QueuePolicy};
use asmotion_datum::Datum;
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceKind, InterfaceName};
use asmotion_ros1::{RosNode, RosNotice, RosSettings, RosTiming, RosUri, ServiceType, TopicType};

/// Python of the system, for which Debian installs ROS.
const PYTHON: &str = "/usr/bin/python3";
/// Patience for something that should happen soon.
pub const SOON: Duration = Duration::from_secs(20);

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
            .env("ROS_HOME", std::env::temp_dir().join("asmotion-ros1-test"))
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
    pub port: u16,
    process: Option<Process>,
}

impl Master {
    /// Starts a master; `None`, with a notice, if ROS is not installed.
    pub fn start() -> Option<Self> {
        if !has_ros() {
            return None;
        }
        let free = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = free.local_addr().unwrap().port();
        drop(free);
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

    /// Runs a script of `tests/peers`.
    pub fn peer(&self, script: &str, arguments: &[&str]) -> Process {
        let here = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peers");
        // this file is also part of the tests of the command line
        let there = concat!(env!("CARGO_MANIFEST_DIR"), "/engine/ros/ros1/tests/peers");
        let is_here = std::path::Path::new(here).exists();
        let path = format!("{}/{script}.py", if is_here { here } else { there });
        let mut all = vec![&*path];
        all.extend(arguments);
        Process::start(&all, self.port)
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

    /// Starts a node of this library.
    pub fn node(&self, name: &str) -> TestNode {
        TestNode::start(self.port, name, |_| ())
    }
}

/// A node of this library, and its notices.
pub struct TestNode {
    pub node: RosNode,
    notices: Arc<Mutex<Vec<RosNotice>>>,
}

impl TestNode {
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

    pub fn registered(&self) -> &RosNode {
        self.node.await_registered(SOON).unwrap();
        &self.node
    }

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

pub fn topic_type(name: &str) -> TopicType {
    let noetic = Catalogue::included(Distribution::Ros1);
    TopicType::of(&noetic, &name.parse().unwrap()).unwrap()
}

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

pub fn notifier() -> Arc<Notifier> {
    Arc::new(Notifier::new())
}
