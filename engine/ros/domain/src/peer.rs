//! Processes of `peers/peer.py`.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use asmotion_ros_interface::{Catalogue, Distribution};

/// Time within which a peer answers, on a busy machine too.
pub const LONG: Duration = Duration::from_secs(60);

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

/// The script of all peers; its first argument is the role.
pub fn peer_script() -> &'static str {
    concat!(env!("CARGO_MANIFEST_DIR"), "/peers/peer.py")
}

/// Number of domains. Ports of higher ones are those that systems give to outgoing connections.
const DOMAINS: usize = 95;

/// A domain for a test, which no other test has, also in processes that run at the same time.
///
/// # Panics
/// The folder for temporary files is not one, or tests have taken all domains.
pub fn domain() -> u16 {
    /// Locks of the domains of this process.
    static TAKEN: Mutex<Vec<File>> = Mutex::new(Vec::new());
    let mut taken = TAKEN.lock().unwrap_or_else(PoisonError::into_inner);
    let first = std::process::id() as usize % DOMAINS;
    let domains = (0..DOMAINS).map(|offset| 1 + (first + offset) % DOMAINS);
    for domain in domains {
        let lock = std::env::temp_dir().join(format!("asmotion-ros-domain-{domain}"));
        let lock = File::create(lock).unwrap();
        if lock.try_lock().is_ok() {
            taken.push(lock);
            return u16::try_from(domain).unwrap();
        }
    }
    panic!("tests have taken all {DOMAINS} domains");
}

/// The definitions of ROS 2.
pub fn catalogue() -> Arc<Catalogue> {
    static JAZZY: LazyLock<Arc<Catalogue>> =
        LazyLock::new(|| Arc::new(Catalogue::included(Distribution::Ros2)));
    Arc::clone(&JAZZY)
}

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// A running peer. It ends when this is dropped.
pub struct Peer {
    child: Child,
    stdin: Option<ChildStdin>,
    lines: Receiver<String>,
}

impl Peer {
    /// Starts a peer in a role, with its settings.
    ///
    /// # Panics
    /// It cannot be started.
    pub fn start(python: &Path, role: &str, settings: &serde_json::Value) -> Self {
        Self::spawn(python, peer_script(), &[role, &settings.to_string()])
    }

    /// Starts a script of `peers/`.
    ///
    /// # Panics
    /// It cannot be started.
    pub fn start_script(python: &Path, script: &str, arguments: &[&str]) -> Self {
        let path = format!("{}/peers/{script}.py", env!("CARGO_MANIFEST_DIR"));
        Self::spawn(python, &path, arguments)
    }

    /// Starts a script.
    pub(crate) fn spawn(python: &Path, script: &str, arguments: &[&str]) -> Self {
        Self::spawn_with(python, script, arguments, &[("CYCLONEDDS_URI", CYCLONE)])
    }

    /// Starts a script with these environment variables.
    pub(crate) fn spawn_with(
        python: &Path,
        script: &str,
        arguments: &[&str],
        variables: &[(&str, &str)],
    ) -> Self {
        let mut child = Command::new(python)
            .arg(script)
            .args(arguments)
            .envs(variables.iter().copied())
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
    ///
    /// # Panics
    /// There is none soon.
    pub fn line(&self) -> String {
        self.lines.recv_timeout(LONG).expect("a line of the peer")
    }

    /// The next lines, at most so many; fewer if no further one comes soon.
    pub fn lines(&self, count: usize) -> Vec<String> {
        let next = || self.lines.recv_timeout(LONG).ok();
        std::iter::from_fn(next).take(count).collect()
    }

    /// Expects a line.
    ///
    /// # Panics
    /// The next line is another.
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

    /// Writes a line to the peer's input.
    ///
    /// # Panics
    /// The peer has ended.
    pub fn tell(&mut self, line: &str) {
        let input = self.stdin.as_mut().expect("a peer that runs");
        writeln!(input, "{line}").unwrap();
        input.flush().unwrap();
    }

    /// Sends a signal such as `STOP`.
    ///
    /// # Panics
    /// The peer has ended.
    pub fn signal(&self, signal: &str) {
        let process = self.child.id().to_string();
        let status = Command::new("kill")
            .args([&format!("-{signal}"), &process])
            .status();
        assert!(status.unwrap().success());
    }

    /// Ends the peer without a farewell.
    ///
    /// # Panics
    /// It cannot be ended.
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
