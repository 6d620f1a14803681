//! The dashboard together with everything else that a run can do: several processes, restarts, other versions, recordings.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_recording::{RecordingItem, RunReader};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::processes::{navigation, over, three_processes, tool, wait_until_present};

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(60);

/// A run with a dashboard. It is killed at the end of the test.
pub(super) struct Watched {
    process: Child,
    address: String,
    /// The address that it prints, with the token if it can be controlled.
    url: String,
}

impl Watched {
    /// Starts a run, whose dashboard has to open.
    pub(super) fn start(command: &mut Command) -> Self {
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut process = command.spawn().unwrap();
        let url = url(process.stderr.take().unwrap());
        let address = address_of(&url);
        Self {
            process,
            address,
            url,
        }
    }

    /// The token of the dashboard.
    pub(super) fn token(&self) -> &str {
        self.url.split_once("#token=").unwrap().1
    }

    /// Ends the run like Ctrl-C, and waits for its end.
    pub(super) fn interrupt(&mut self) {
        let pid = self.process.id().to_string();
        let sent = Command::new("kill").args(["-INT", &pid]).status().unwrap();
        assert!(sent.success());
        self.wait();
    }

    /// Waits for the end of the run.
    pub(super) fn wait(&mut self) {
        self.process.wait().unwrap();
    }

    pub(super) fn tab(&self) -> LiveTab {
        LiveTab::open(&self.address)
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The address that a run with a dashboard prints.
fn url(stderr: ChildStderr) -> String {
    let mut lines = BufReader::new(stderr).lines();
    let mut said = Vec::new();
    let url = loop {
        let Some(Ok(line)) = lines.next() else {
            panic!("{said:#?}")
        };
        if line.trim_start().starts_with("Dashboard") {
            break line.split_whitespace().last().unwrap().to_owned();
        }
        said.push(line);
    };
    // what it prints is not needed, but has to go somewhere
    std::thread::spawn(move || lines.for_each(drop));
    url
}

/// Host and port of an address.
fn address_of(url: &str) -> String {
    let address = url.trim_start_matches("http://").split('/').next();
    address.unwrap().to_owned()
}

/// A tab without a browser.
pub(super) struct LiveTab {
    socket: WebSocket<TcpStream>,
    /// What the system consists of.
    pub system: Value,
    /// The first message.
    pub hello: Value,
}

impl LiveTab {
    pub(super) fn open(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(LONG)).unwrap();
        let request = format!("ws://{address}/live")
            .into_client_request()
            .unwrap();
        let (socket, _) = tungstenite::client(request, stream).unwrap();
        let mut tab = Self {
            socket,
            system: Value::Null,
            hello: Value::Null,
        };
        let hello = tab.next().unwrap();
        assert_eq!(hello["type"], "hello");
        tab.system = hello["system"].clone();
        tab.hello = hello;
        tab
    }

    pub(super) fn subscribe(&mut self, streams: &[&str]) {
        let request = json!({ "type": "subscribe", "streams": streams, "max_hz": 30.0 });
        self.socket
            .send(Message::text(request.to_string()))
            .unwrap();
    }

    /// Sends a message.
    pub(super) fn send(&mut self, message: &Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }

    /// Sends a message, and returns the reply to it.
    pub(super) fn ask(&mut self, message: &Value) -> Value {
        self.send(message);
        let is_reply = |it: &Value| {
            ["armed", "done", "problem"]
                .iter()
                .any(|kind| it["type"] == *kind)
        };
        self.until("the reply", is_reply)
    }

    /// The next message, which is acknowledged; `None` at the end of the connection.
    pub(super) fn next(&mut self) -> Option<Value> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    if message["type"] == "frame" {
                        let ack = json!({ "type": "ack", "seq": message["seq"] });
                        let _ = self.socket.send(Message::text(ack.to_string()));
                    }
                    return Some(message);
                }
                Ok(Message::Close(_)) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }

    /// The next message for which this is true.
    #[track_caller]
    pub(super) fn until(&mut self, what: &str, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        while let Some(message) = self.next() {
            if is_wanted(&message) {
                return message;
            }
            assert!(begun.elapsed() < LONG, "{what} does not come");
        }
        panic!("the connection ended before {what}");
    }

    /// Waits until the connection ends.
    fn end(&mut self) {
        let begun = Instant::now();
        while self.next().is_some() {
            assert!(begun.elapsed() < LONG, "the connection does not end");
        }
    }

    /// Names of the components of the process.
    fn components(&self) -> Vec<&str> {
        let components = self.system["components"].as_array().unwrap().iter();
        components.map(|it| it["name"].as_str().unwrap()).collect()
    }
}

/// Number of the newest sample of an output in a frame.
fn number(frame: &Value, output: &str) -> Option<u64> {
    frame["samples"][output]["n"].as_u64()
}

/// The state of a component in a frame that describes the components.
fn state<'f>(frame: &'f Value, component: &str) -> Option<&'f str> {
    let components = frame["components"]["components"].as_array()?;
    let of = components.iter().find(|it| it["name"] == component)?;
    of["state"].as_str()
}

/// The figures for Prometheus.
fn figures(address: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET /metrics HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut response = String::new();
    stream.read_to_string(&mut response).unwrap();
    response
}

pub(super) fn with_dashboard(command: &mut Command) -> &mut Command {
    command.args(["--dashboard", "127.0.0.1:0"])
}

#[test]
fn each_process_shows_its_part_also_after_a_restart_of_another_one_and_of_the_broker() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let start = |process: &str| {
        let mut command = over(&composite, &broker, &vhost, Some(process));
        Watched::start(with_dashboard(&mut command))
    };
    let onboard = start("onboard");
    let planning = start("planning");
    let mut tab = onboard.tab();
    assert!(tab.components().contains(&"RoverDriver"), "{}", tab.system);
    assert!(!tab.components().contains(&"TrajectoryPlanner"));
    let mut other = planning.tab();
    assert_eq!(other.components(), ["TrajectoryPlanner"]);
    let running = |frame: &Value| state(frame, "TrajectoryPlanner") == Some("Running");
    other.subscribe(&["components"]);
    other.until("the planner", running);

    // a process that is killed takes its own dashboard with it; the other one continues
    tab.subscribe(&["RoverDriver.odom"]);
    drop(planning);
    other.end();
    let odom = |frame: &Value| number(frame, "RoverDriver.odom").is_some();
    let before = number(&tab.until("odometry", odom), "RoverDriver.odom").unwrap();
    let planning = start("planning");
    let mut other = planning.tab();
    other.subscribe(&["components"]);
    other.until("the planner", running);

    // dashboards need no broker
    broker.kill().unwrap();
    let later = |count: u64| {
        move |frame: &Value| number(frame, "RoverDriver.odom").is_some_and(|it| it > count)
    };
    let is_down = |frame: &Value| {
        let links = frame["links"].as_array().into_iter().flatten();
        let mut down = links.filter(|it| it["state"] == "down");
        down.any(|it| it["reason"].as_str().is_some_and(|it| !it.is_empty()))
    };
    tab.until("the loss of the broker", is_down);
    let metrics = || figures(&onboard.address);
    assert!(
        metrics().contains(&format!("asmotion_link_up{{link=\"{}", broker.address())),
        "{}",
        metrics()
    );
    let up = |state: &str| {
        let metrics = metrics();
        let mut lines = metrics
            .lines()
            .filter(|it| it.starts_with("asmotion_link_up{"));
        lines.all(|it| it.ends_with(state))
    };
    assert!(up("} 0"), "{}", metrics());
    let during = tab.until("odometry without the broker", later(before + 50));
    assert!(during["end"].is_null(), "{during}");
    other.until("the planner without the broker", running);
    broker.revive().unwrap();
    let count = number(&during, "RoverDriver.odom").unwrap();
    tab.until("odometry after the outage", later(count + 50));
    other.until("the planner after the outage", running);
    tab.until("the connection", |it| {
        it["type"] == "frame" && it["links"].is_null()
    });
    assert!(up("} 1"), "{}", metrics());
}

#[test]
fn an_open_tab_follows_the_system_to_another_version() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (user, address) = (broker.user(), broker.address());
    let url = format!("amqp://{user}@{address}/{}", vhost.name());
    let folder = tempfile::tempdir().unwrap();
    let composite = three_processes(folder.path());
    let mut command = over(&composite, &broker, &vhost, Some("onboard"));
    let onboard = Watched::start(with_dashboard(&mut command));
    wait_until_present(&vhost, "onboard");
    let mut command = over(&composite, &broker, &vhost, Some("planning"));
    let _planning = Watched::start(with_dashboard(&mut command));
    wait_until_present(&vhost, "planning");
    let mut tab = onboard.tab();
    tab.subscribe(&["outputs"]);
    let first = std::fs::read_to_string(&composite).unwrap();
    let text = first.replacen(
        "rust = \"nav::sim::RoverDriver\" }\nactivity  = { period_ms = 20 }",
        "rust = \"nav::sim::RoverDriver\" }\nactivity  = { period_ms = 10 }",
        1,
    );
    assert_ne!(first, text);
    std::fs::write(&composite, text).unwrap();
    let path = composite.to_str().unwrap();
    let (code, _, err) = tool(&broker, &url, &["reconfigure", path]);
    assert_eq!(code, Some(0), "{err}");
    let hello = tab.until("the next version", |it| it["type"] == "hello");
    assert_eq!(hello["system"]["name"], tab.system["name"]);
    // it subscribes again, as the page does, and sees the system as it is now
    tab.subscribe(&["outputs", "components"]);
    tab.until("the changed period", |frame| {
        let components = frame["components"]["components"].as_array();
        let mut components = components.into_iter().flatten();
        components.any(|it| it["name"] == "RoverDriver" && it["period_ms"] == 10)
    });
}

#[test]
fn a_run_has_a_dashboard_a_recording_and_its_output_as_json_at_the_same_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .arg("run")
        .arg(navigation().join("navigation.composite.toml"));
    command.args([
        "--json", "--goal", "3.4,4.7", "--speed", "4", "--for", "120", "--record",
    ]);
    command
        .arg(&file)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut process = with_dashboard(&mut command).spawn().unwrap();
    let stdout = BufReader::new(process.stdout.take().unwrap());
    let lines = std::thread::spawn(move || {
        let lines = stdout.lines().map(|line| {
            let line = line.unwrap();
            serde_json::from_str::<Value>(&line).unwrap_or_else(|error| panic!("{error}: {line}"))
        });
        lines.collect::<Vec<_>>()
    });
    let address = address_of(&url(process.stderr.take().unwrap()));
    let mut tabs = [LiveTab::open(&address), LiveTab::open(&address)];
    for tab in &mut tabs {
        tab.subscribe(&["steps", "log"]);
    }
    for tab in &mut tabs {
        let end = tab.until("the end", |it| it["end"].is_string());
        assert_eq!(end["end"], "reached");
        tab.end();
    }
    assert!(process.wait().unwrap().success());
    let lines = lines.join().unwrap();
    let opened = lines.iter().find(|it| it["type"] == "dashboard");
    assert_eq!(opened.unwrap()["url"], format!("http://{address}/"));
    let modes = lines.iter().flat_map(|it| {
        let updates = it["step"]["updates"].as_array().into_iter().flatten();
        updates.filter(|it| it["location"] == "mode")
    });
    assert_eq!(modes.last().unwrap()["after"], "ARRIVED");
    let ends = RunReader::open(&file).unwrap();
    let ends = ends.filter(|item| matches!(item, RecordingItem::End(end) if end.lost == 0));
    assert_eq!(ends.count(), 1, "the recording is complete");
}

#[test]
fn runs_on_one_machine_have_dashboards_of_their_own_and_a_port_in_use_is_named() {
    let composite = navigation().join("navigation.composite.toml");
    let run = |dashboard: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
        command.arg("run").arg(&composite);
        command.args(["--clock", "wall", "--for", "60", "--dashboard"]);
        command.args(dashboard);
        command
    };
    let (first, second) = (Watched::start(&mut run(&[])), Watched::start(&mut run(&[])));
    assert_ne!(first.address, second.address);
    for watched in [&first, &second] {
        let mut tab = watched.tab();
        tab.subscribe(&["RoverDriver.odom"]);
        tab.until("odometry", |it| number(it, "RoverDriver.odom").is_some());
    }
    let output = run(&[&first.address]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success(), "{said}");
    let expected = format!("cannot listen at {}", first.address);
    assert!(said.contains(&expected), "{said}");
}
