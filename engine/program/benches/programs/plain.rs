//! Echo processes without a component.

use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use crate::Trips;

/// Bytes of a sample.
const SIZE: usize = 56;

/// Two processes that send each other a sample of this size: this one, or a client that measures on request, and an echo.
pub(crate) enum EchoProcess {
    Socket {
        stream: UnixStream,
        _server: EndedChild,
    },
    /// A client that reads a number of trips from its standard input, and writes their durations in nanoseconds.
    Client {
        requests: ChildStdin,
        times: BufReader<ChildStdout>,
        _client: EndedChild,
        _server: EndedChild,
        _folder: tempfile::TempDir,
    },
}

/// A process that ends with its owner.
pub(crate) struct EndedChild(Child);

impl Drop for EndedChild {
    fn drop(&mut self) {
        // it may have ended
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Returns everything that arrives at a socket.
pub(crate) fn echo_socket(path: &str) {
    let mut stream = UnixStream::connect(path).unwrap();
    let mut bytes = [0; SIZE];
    while stream.read_exact(&mut bytes).is_ok() {
        stream.write_all(&bytes).unwrap();
    }
}

impl EchoProcess {
    /// Blocking reads and writes on a Unix socket, in Rust.
    pub(crate) fn socket() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let listener = UnixListener::bind(&path).unwrap();
        let mut command = Command::new(std::env::current_exe().unwrap());
        let child = command.arg("echo-socket").arg(&path).spawn().unwrap();
        Self::Socket {
            stream: listener.accept().unwrap().0,
            _server: EndedChild(child),
        }
    }

    /// A request and its reply over `ipc` of libzmq, in C.
    pub(crate) fn zeromq_c() -> Result<Self, String> {
        let folder = tempfile::tempdir().unwrap();
        let executable = folder.path().join("zeromq");
        let mut compiler = Command::new("cc");
        compiler.args(["-O2", "-o"]).arg(&executable);
        let compiled = compiler.arg(source("zeromq.c")).arg("-lzmq").output();
        let compiled = compiled.map_err(|error| format!("no C compiler: {error}"))?;
        if !compiled.status.success() {
            let text = String::from_utf8_lossy(&compiled.stderr).into_owned();
            let first = text.lines().next().unwrap_or_default();
            return Err(format!("libzmq3-dev is missing: {first}"));
        }
        Ok(Self::client(folder, || Command::new(&executable)))
    }

    /// The same with pyzmq, in Python.
    pub(crate) fn zeromq_python() -> Result<Self, String> {
        let python = ["/usr/bin/python3", "python3"].into_iter().find(|python| {
            let mut command = Command::new(python);
            let output = command.args(["-c", "import zmq"]).output();
            output.is_ok_and(|it| it.status.success())
        });
        let python = python.ok_or("the Python package `zmq` is missing (python3-zmq)")?;
        let folder = tempfile::tempdir().unwrap();
        Ok(Self::client(folder, || {
            let mut command = Command::new(python);
            command.arg(source("zeromq.py"));
            command
        }))
    }

    fn client(folder: tempfile::TempDir, command: impl Fn() -> Command) -> Self {
        let address = format!("ipc://{}/zeromq", folder.path().display());
        let server = command().args(["server", &address]).spawn().unwrap();
        let mut client = command();
        client.args(["client", &address]);
        client.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut client = client.spawn().unwrap();
        Self::Client {
            requests: client.stdin.take().unwrap(),
            times: BufReader::new(client.stdout.take().unwrap()),
            _client: EndedChild(client),
            _server: EndedChild(server),
            _folder: folder,
        }
    }
}

impl Trips for EchoProcess {
    fn measure(&mut self, count: usize) -> Vec<Duration> {
        match self {
            Self::Socket { stream, .. } => {
                let mut bytes = [7; SIZE];
                let times = (0..count).map(|_| {
                    let begin = Instant::now();
                    stream.write_all(&bytes).unwrap();
                    stream.read_exact(&mut bytes).unwrap();
                    begin.elapsed()
                });
                times.collect()
            }
            Self::Client {
                requests, times, ..
            } => {
                writeln!(requests, "{count}").unwrap();
                let lines = times.by_ref().lines().take(count);
                lines
                    .map(|line| Duration::from_nanos(line.unwrap().parse().unwrap()))
                    .collect()
            }
        }
    }
}

fn source(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/programs");
    folder.join(name)
}
