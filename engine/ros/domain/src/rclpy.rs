//! A node of ROS 2 itself: rclpy on Fast DDS, the middleware that Jazzy has by default.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::{Value, json};

use crate::peer::Peer;

/// Folder of the environment of Python that `./test` creates.
fn environment() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/rclpy/venv")
}

/// Python with rclpy and Fast DDS, which `./test` installs; `None`, with a notice, without it.
pub fn rclpy() -> Option<PathBuf> {
    static PYTHON: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
        let python = environment().join("bin/python");
        let tried = Command::new(&python)
            .args([
                "-c",
                "import rclpy, std_msgs.msg, std_srvs.srv, test_msgs.action",
            ])
            .output();
        tried.is_ok_and(|it| it.status.success()).then_some(python)
    });
    if PYTHON.is_none() {
        asmotion_skip::RCLPY.skip();
    }
    PYTHON.clone()
}

/// Folder with the definitions of `test_msgs`, a package that only tests use.
pub fn test_definitions() -> PathBuf {
    environment().join("share/test_msgs")
}

/// A node of rclpy.
pub struct RclpyNode {
    peer: Peer,
    /// Lines that were not awaited yet.
    unread: VecDeque<Value>,
}

impl RclpyNode {
    /// Starts a node with this name in a domain, on the loopback interface.
    ///
    /// # Panics
    /// It cannot be started.
    pub fn start(python: &Path, domain: u16, name: &str) -> Self {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/rclpy_node.py");
        let domain = domain.to_string();
        let log = std::env::temp_dir().join("asmotion-ros2-test");
        let log = log.display().to_string();
        let variables = [
            ("ROS_DOMAIN_ID", &*domain),
            ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
            ("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"),
            // over UDP as with another machine: no peer of ours has their shared memory
            ("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4"),
            ("ROS_LOG_DIR", &log),
        ];
        let node = Self {
            peer: Peer::spawn_with(python, script, &[name], &variables),
            unread: VecDeque::new(),
        };
        let ready: Value = serde_json::from_str(&node.peer.line()).unwrap();
        assert_eq!(ready, json!(["ready"]));
        node
    }

    /// Gives a command to the node, and waits until it is done.
    ///
    /// # Panics
    /// The node does not answer soon.
    pub fn obey(&mut self, command: &Value) {
        self.peer.tell(&command.to_string());
        loop {
            let line = self.read();
            if line[0] == "done" {
                return;
            }
            self.unread.push_back(line);
        }
    }

    /// The next line of this kind about a topic, service or action, such as `["request", service, request]`, without these two
    /// words. Other lines are kept.
    ///
    /// # Panics
    /// There is none soon.
    pub fn event(&mut self, kind: &str, of: &str) -> Vec<Value> {
        let is_of = |line: &Value| line[0] == *kind && line[1] == *of;
        let found = self.unread.iter().position(is_of);
        let mut line = found.and_then(|at| self.unread.remove(at));
        while line.is_none() {
            let next = self.read();
            if is_of(&next) {
                line = Some(next);
            } else {
                self.unread.push_back(next);
            }
        }
        let line = line.unwrap();
        line.as_array().unwrap()[2..].to_vec()
    }

    fn read(&self) -> Value {
        let line = self.peer.line();
        serde_json::from_str(&line).unwrap_or_else(|_| panic!("the peer printed {line}"))
    }
}
