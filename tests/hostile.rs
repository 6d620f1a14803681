//! Strangers with credentials at the broker who send nonsense, old events and forged numbers while a mission runs.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::faults::{Heard, entered, enters};
use crate::processes::{
    Running, expected, navigation, over, run_any, through, tool, wait_until_present,
};
use crate::stranger::python;

/// Timeout for a loaded machine.
const LONG: Duration = Duration::from_secs(60);

/// A foreign program at the broker.
pub(super) struct Peer {
    child: Child,
    input: ChildStdin,
    heard: Arc<Mutex<Vec<Value>>>,
}

impl Peer {
    /// Starts it, and waits until it hears the messages with these routing keys.
    pub(super) fn start(python: &Path, url: &str, keys: &[&str]) -> Self {
        let peer = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile/peer.py");
        let mut command = Command::new(python);
        command.arg(peer).arg(url).args(keys);
        let mut child = { command.stdin(Stdio::piped()).stdout(Stdio::piped()) }
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        assert!(lines.next().unwrap().is_ok(), "it connects");
        let heard = Arc::<Mutex<Vec<Value>>>::default();
        let to = Arc::clone(&heard);
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let message = serde_json::from_str(&line).unwrap();
                to.lock().unwrap().push(message);
            }
        });
        let input = child.stdin.take().unwrap();
        Self {
            child,
            input,
            heard,
        }
    }

    /// Sends a message: `key`, `body`, and optionally `id`, `user`, `headers`.
    pub(super) fn send(&mut self, message: &Value) {
        writeln!(self.input, "{message}").unwrap();
    }

    fn say(&mut self, key: &str, body: &Value) {
        self.send(&json!({ "key": key, "body": body.to_string() }));
    }

    /// The messages heard with this routing key.
    pub(super) fn heard(&self, key: &str) -> Vec<Value> {
        let heard = self.heard.lock().unwrap();
        let with_key = heard.iter().filter(|message| message["key"] == key);
        with_key.cloned().collect()
    }

    /// Waits until it has heard messages with this routing key that satisfy the condition.
    #[track_caller]
    pub(super) fn wait_for(&self, key: &str, condition: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        let until = Instant::now() + LONG;
        loop {
            let heard = self.heard(key);
            if condition(&heard) {
                return heard;
            }
            assert!(Instant::now() < until, "{key}: {heard:?}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Messages that cannot be meant: a grid without cells of a size, places beyond all places.
fn nonsense() -> Vec<(&'static str, Value)> {
    let grid = |resolution: Value, side: u32| {
        let info = json!({ "resolution": resolution, "width": side, "height": side });
        json!({ "info": info, "data": [0] })
    };
    let path = |x: Value| {
        let pose = |x: &Value| json!({ "pose": { "position": { "x": x, "y": 4.7 } } });
        json!({ "header": { "frame_id": "map" }, "poses": [pose(&json!(1.4)), pose(&x)] })
    };
    let odometry = json!({ "pose": { "pose": { "position": { "x": "NaN" } } } });
    vec![
        ("navigation.port.MapServer.map", json!({})),
        ("navigation.port.MapServer.map", grid(json!(0.0), 1)),
        ("navigation.port.MapServer.map", grid(json!("NaN"), 1)),
        ("navigation.port.MapServer.map", grid(json!(0.05), u32::MAX)),
        ("navigation.plan", path(json!(1e308))),
        ("navigation.plan", path(json!("NaN"))),
        ("navigation.odom", odometry),
    ]
}

#[test]
fn nonsense_ends_no_process_and_changes_no_mission() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let mut peer = Peer::start(python, &vhost.url(), &[]);
    let mut disturb = || {
        for (key, body) in nonsense() {
            peer.say(key, &body);
        }
    };
    disturb();
    let mut supervisor = Heard::start(&mut over(&composite, &broker, &vhost, Some("supervisor")));
    let mut told = Vec::new();
    let follows = supervisor.until(&mut told, enters("FOLLOWING"));
    assert!(follows.is_some(), "{told:#?}");
    disturb();
    for encoders in [r#"{"left": "NaN"}"#, r#"{"right": 1e308}"#] {
        let url = vhost.url();
        let write = ["port", "write", "RoverDriver.encoders", encoders];
        let (code, _, said) = tool(&broker, &url, &write);
        assert!(code != Some(0) || said.is_empty(), "{said}");
    }
    let summary = supervisor.until(&mut told, |line| line["type"] == "summary");
    let modes: Vec<_> = told.iter().flat_map(entered).collect();
    assert_eq!(modes, expected().0);
    assert_eq!(summary.unwrap()["outcome"], "reached");
    let output = onboard.interrupt();
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(!said.contains(r#""type":"fault""#), "{said}");
    for input in ["map", "path", "encoders"] {
        let refused = format!("`{input}` refuses a message");
        assert!(said.contains(&refused), "{refused}: {said}");
    }
}

/// A goal, as a message.
fn goal(x: f64, y: f64) -> Value {
    let pose = json!({ "position": { "x": x, "y": y } });
    json!({ "header": { "frame_id": "map" }, "pose": pose })
}

/// Events without an order, about another order, and about the order before: all were true once, or nowhere.
#[test]
fn an_arrival_of_an_earlier_order_or_of_none_is_refused() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let onboard = Running::start(&mut over(&composite, &broker, &vhost, Some("onboard")));
    wait_until_present(&vhost, "onboard");
    let mut peer = Peer::start(python, &vhost.url(), &["navigation.event"]);
    let mut command = over(&composite, &broker, &vhost, Some("supervisor"));
    let mut supervisor = Heard::start(command.args(["--until", "mode=IDLE"]));
    let mut told = Vec::new();
    let mut time_of = |mode: &'static str| {
        let line = supervisor.until(&mut told, enters(mode));
        line.unwrap_or_else(|| panic!("{mode}"))["t"]
            .as_f64()
            .unwrap()
    };
    time_of("ARRIVED");
    let reached = |heard: &[Value]| {
        let codes = heard.iter().map(|message| &message["content"]["code"]);
        codes.filter(|code| **code == "REACHED").count()
    };
    let events = peer.wait_for("navigation.event", |heard| reached(heard) == 1);
    let first = events
        .iter()
        .find(|message| message["content"]["code"] == "REACHED");
    let first = first.unwrap()["content"].clone();
    // back to where it came from: 2 m
    peer.say("navigation.goal", &goal(1.4, 4.7));
    let follows = time_of("FOLLOWING");
    let other = json!({ "code": "REACHED", "plan": { "sec": 1 } });
    for event in [&first, &json!({ "code": "REACHED" }), &other] {
        peer.say("navigation.event", event);
    }
    let arrives = time_of("ARRIVED");
    // it drives 0.5 m/s at most
    assert!(
        arrives - follows > 3.0,
        "{first} is believed: {}",
        arrives - follows
    );
    let events = peer.wait_for("navigation.event", |heard| reached(heard) == 5);
    assert_ne!(events.last().unwrap()["content"]["plan"], first["plan"]);
    peer.say("navigation.cancel", &json!({}));
    time_of("IDLE");
    onboard.interrupt();
}

/// One who reads everything and may publish forges numbers in the streams of the coordinator: far ahead, and the next ones. It
/// also keeps saying that the rover may drive.
#[test]
fn a_forger_mutes_no_emergency_stop() {
    let (Some(broker), Some(python)) = (asmotion_broker::calm(), python()) else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = format!("dash-{}", vhost.name());
    broker.add_user(&user, "p").unwrap();
    vhost.permit(&user, ".*", ".*", ".*").unwrap();
    let composite = navigation().join("navigation.composite.toml");
    let command = |process| {
        let mut command = run_any(&composite);
        command.args(["--goal", "26.4,4.2"]);
        through(command, &broker, &vhost, Some(process))
    };
    let onboard = Running::start(&mut command("onboard"));
    wait_until_present(&vhost, "onboard");
    let keys = ["navigation.permit", "navigation.plan", "navigation.odom"];
    let mut dash = Peer::start(python, &vhost.url_of(&user, "p"), &keys);
    let mut operator = Peer::start(python, &vhost.url(), &[]);
    let mut supervisor = Heard::start(&mut command("supervisor"));
    let mut told = Vec::new();
    let follows = supervisor.until(&mut told, enters("FOLLOWING"));
    assert!(follows.is_some(), "{told:#?}");
    let speed = |message: &Value| message["content"]["twist"]["twist"]["linear"]["x"].as_f64();
    let drives = |heard: &[Value]| heard.last().and_then(speed).is_some_and(|it| it > 0.2);
    dash.wait_for("navigation.odom", drives);
    for key in ["navigation.permit", "navigation.plan"] {
        forge(&mut dash, &user, key);
    }
    operator.say("navigation.estop", &json!({ "data": true }));
    // in a second thread, because reading blocks
    let stops = std::thread::spawn(move || {
        let idle = supervisor.until(&mut told, enters("IDLE"));
        assert!(idle.is_some(), "{told:#?}");
        supervisor
    });
    let allow = |dash: &mut Peer| {
        dash.say("navigation.permit", &json!({ "data": true }));
        std::thread::sleep(Duration::from_millis(20));
    };
    while !stops.is_finished() {
        allow(&mut dash);
    }
    let _supervisor = stops.join().unwrap();
    let stopped = Instant::now();
    // time to brake, also on a loaded machine
    while stopped.elapsed() < Duration::from_secs(4) {
        allow(&mut dash);
    }
    let odometry = dash.heard("navigation.odom");
    let speeds: Vec<f64> = odometry.iter().rev().take(20).filter_map(speed).collect();
    assert!(speeds.iter().all(|it| it.abs() < 0.01), "{speeds:?}");
    onboard.interrupt();
}

/// Repeats the last message of a stream with forged numbers, with the name of the stranger's user and without.
fn forge(dash: &mut Peer, user: &str, key: &str) {
    let heard = dash.wait_for(key, |heard| !heard.is_empty());
    let last = heard.last().unwrap();
    let known = heard.len();
    let (stream, number) = last["id"].as_str().unwrap().rsplit_once('-').unwrap();
    let number: i64 = number.parse().unwrap();
    let ahead = (1..100).map(|more| number + more);
    let mut sent = 0;
    for number in ahead.chain([1 << 62, i64::MAX]) {
        for user in [Some(user), None] {
            sent += 1;
            dash.send(&json!({
                "key": key,
                "body": last["content"].to_string(),
                "id": format!("{stream}-{number}"),
                "user": user,
                "headers": { "sequence": number },
            }));
        }
    }
    // what follows is behind them in every queue
    dash.wait_for(key, |heard| heard.len() >= known + sent);
}
