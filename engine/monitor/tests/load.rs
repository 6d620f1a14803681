//! What tabs and viewers cost: memory, and time of the thread that serves them.

#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_coordinator::{STEP_REPORT, StepRecord, UpdateRecord};
use asmotion_datum::{Datum, Numbers};
use asmotion_monitor::{Dashboard, DashboardSettings, Feed, MonitorSource, SystemDescription};
use asmotion_runtime::{Event, Observer};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

/// The outputs of the rover and the arm: odometry, a laser scan of 181 beams, and five joints.
const OUTPUTS: [(&str, &str); 3] = [("Driver", "odom"), ("Laser", "scan"), ("Arm", "status")];

/// A system that writes when it is told to.
struct LoadedSystem {
    server: Dashboard,
    feed: Feed,
    samples: [Datum; 3],
    ticks: u64,
}

impl LoadedSystem {
    fn open() -> Self {
        let source = MonitorSource::new(SystemDescription::default(), None, Vec::new());
        let feed = source.feed();
        let settings = DashboardSettings::at(SocketAddr::from(([127, 0, 0, 1], 0)));
        let server = Dashboard::open(settings, source).unwrap();
        let vector = |x: f64| {
            let parts = ["x", "y", "z"].map(|name| (name, Datum::Float(x)));
            Datum::record(parts)
        };
        let odometry = Datum::record([
            ("frame", Datum::text("map")),
            ("position", vector(1.25)),
            ("orientation", vector(0.5)),
            ("linear", vector(0.3)),
            ("angular", vector(0.1)),
        ]);
        let ranges: Vec<f32> = (0..181_u16).map(|beam| 0.017 * f32::from(beam)).collect();
        let scan = Datum::record([("ranges", Datum::Numbers(Numbers::F32(ranges.into())))]);
        let joint = || {
            let parts = ["position", "velocity", "effort", "current"];
            Datum::record(parts.map(|name| (name, Datum::Float(0.125))))
        };
        let status = Datum::record([("joints", Datum::List((0..5).map(|_| joint()).collect()))]);
        Self {
            server,
            feed,
            samples: [odometry, scan, status],
            ticks: 0,
        }
    }

    /// A period of 20 ms: a sample of each output; after each fifth one a step, and after each 50th an entry of the log.
    fn tick(&mut self) {
        self.ticks += 1;
        let at = Time::from_nanos(i64::try_from(self.ticks).unwrap() * 20_000_000);
        for ((component, port), sample) in OUTPUTS.iter().zip(&self.samples) {
            let event = Event::Published {
                component,
                port,
                topic: None,
                sequence: self.ticks,
                sample,
            };
            self.feed.observe(at, &event);
        }
        if self.ticks.is_multiple_of(5) {
            let record = StepRecord {
                specification: "navigate".to_owned(),
                number: self.ticks / 5,
                inputs: vec![("goal".to_owned(), "true".to_owned())],
                choices: Vec::new(),
                updates: vec![UpdateRecord {
                    location: "count".to_owned(),
                    before: (self.ticks - 1).to_string(),
                    after: self.ticks.to_string(),
                    place: "navigate.asm:3".to_owned(),
                }],
                safe_rule: None,
            };
            self.report(at, STEP_REPORT, &Datum::of(&record).unwrap());
        }
        if self.ticks.is_multiple_of(50) {
            self.report(at, "notice", &Datum::text("another second"));
        }
    }

    fn report(&mut self, at: Time, kind: &'static str, data: &Datum) {
        let event = Event::Report {
            component: "Navigator",
            kind,
            data,
        };
        self.feed.observe(at, &event);
    }
}

/// Clients that read until they are dropped.
struct Clients {
    stop: Arc<AtomicBool>,
    /// Number of messages that each has received.
    received: Vec<Arc<AtomicU64>>,
    /// Number of samples of the arm in the batches of all tabs.
    charted: Arc<AtomicU64>,
    threads: Vec<JoinHandle<()>>,
}

impl Clients {
    /// Starts clients with this function, which receives the socket of a new connection.
    fn start(
        system: &LoadedSystem,
        count: usize,
        (path, protocol): (&str, Option<&'static str>),
        answer: fn(&mut WebSocket<TcpStream>, &str, &AtomicU64),
    ) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let address = system.server.address();
        let received: Vec<Arc<AtomicU64>> = (0..count).map(|_| Arc::default()).collect();
        let charted: Arc<AtomicU64> = Arc::default();
        let threads = received.iter().map(|received| {
            let charted = Arc::clone(&charted);
            let mut request = format!("ws://{address}{path}")
                .into_client_request()
                .unwrap();
            if let Some(protocol) = protocol {
                let protocol = HeaderValue::from_static(protocol);
                let headers = request.headers_mut();
                headers.insert("Sec-WebSocket-Protocol", protocol);
            }
            let stream = TcpStream::connect(address).unwrap();
            let (mut socket, _) = tungstenite::client(request, stream).unwrap();
            // so that each sees that it has to end
            let patience = Some(Duration::from_millis(500));
            socket.get_ref().set_read_timeout(patience).unwrap();
            let (stop, received) = (Arc::clone(&stop), Arc::clone(received));
            std::thread::spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    match socket.read() {
                        Ok(Message::Text(text)) => {
                            received.fetch_add(1, Ordering::Relaxed);
                            answer(&mut socket, &text, &charted);
                        }
                        Ok(Message::Binary(_)) => {
                            received.fetch_add(1, Ordering::Relaxed);
                        }
                        Ok(_) | Err(tungstenite::Error::Io(_)) => {}
                        Err(error) => panic!("{error}"),
                    }
                }
            })
        });
        let threads = threads.collect();
        Self {
            stop,
            received,
            charted,
            threads,
        }
    }

    /// Tabs that show everything as the page does: every sample of the joints, of other outputs the newest one, in as many frames as it
    /// draws.
    fn tabs(system: &LoadedSystem, count: usize) -> Self {
        Self::start(system, count, ("/live", None), |socket, text, charted| {
            let outputs = ["Driver.odom", "Laser.scan"];
            answer_frame(socket, text, charted, (&outputs, &["Arm.status"], 20.0));
        })
    }

    /// Tabs that receive every sample of all outputs, in as many frames as the server sends.
    fn greedy_tabs(system: &LoadedSystem, count: usize) -> Self {
        Self::start(system, count, ("/live", None), |socket, text, charted| {
            let outputs = OUTPUTS.map(|(component, port)| format!("{component}.{port}"));
            let outputs = outputs.each_ref().map(|it| &**it);
            answer_frame(socket, text, charted, (&[], &outputs, 60.0));
        })
    }

    /// Viewers that subscribe to every channel.
    fn viewers(system: &LoadedSystem, count: usize) -> Self {
        let place = ("/foxglove", Some("foxglove.sdk.v1"));
        Self::start(system, count, place, |socket, text, _| {
            let message: Value = serde_json::from_str(text).unwrap();
            let channels = message["channels"].as_array().into_iter().flatten();
            let wanted: Vec<Value> = channels
                .map(|it| json!({ "id": it["id"], "channelId": it["id"] }))
                .collect();
            if !wanted.is_empty() {
                let request = json!({ "op": "subscribe", "subscriptions": wanted });
                let _ = socket.send(Message::text(request.to_string()));
            }
        })
    }

    /// Number of messages that each has received until now.
    fn received(&self) -> impl Iterator<Item = u64> {
        self.received.iter().map(|it| it.load(Ordering::Relaxed))
    }

    /// Ends the clients. Returns the number of messages that each has received.
    fn end(mut self) -> Vec<u64> {
        self.stop.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().unwrap();
        }
        self.received().collect()
    }
}

/// Subscribes to everything, counts the samples of the arm, and acknowledges frames that ask for it.
fn answer_frame(
    socket: &mut WebSocket<TcpStream>,
    text: &str,
    charted: &AtomicU64,
    (outputs, every, max_hz): (&[&str], &[&str], f64),
) {
    let message: Value = serde_json::from_str(text).unwrap();
    let samples = message["batches"]["Arm.status"]["samples"].as_array();
    let samples = samples.map_or(0, Vec::len);
    charted.fetch_add(samples as u64, Ordering::Relaxed);
    if message["ack"] == false {
        return;
    }
    let answer = if message["type"] == "hello" {
        let streams = [&["components", "outputs", "steps", "log"], outputs].concat();
        json!({ "type": "subscribe", "streams": streams, "every": every, "max_hz": max_hz })
    } else {
        json!({ "type": "ack", "seq": message["seq"] })
    };
    let _ = socket.send(Message::text(answer.to_string()));
}

/// Memory of this process, in kilobytes.
fn memory_kb() -> i64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|it| it.strip_prefix("VmRSS:"));
    let number = line.unwrap().trim().trim_end_matches("kB").trim();
    number.parse().unwrap()
}

/// What the thread of the server has used until now.
struct ServerCost {
    /// On a processor, in its own code and in the operating system.
    cpu: Duration,
    /// Number of times that it has waited.
    waits: u64,
}

fn server_cost() -> ServerCost {
    let mut tasks = std::fs::read_dir("/proc/self/task").unwrap();
    let folder = tasks.find_map(|task| {
        let folder = task.ok()?.path();
        let name = std::fs::read_to_string(folder.join("comm")).ok()?;
        (name.trim() == "dashboard").then_some(folder)
    });
    let read = |file| std::fs::read_to_string(folder.as_ref().unwrap().join(file)).unwrap();
    let (times, status) = (read("schedstat"), read("status"));
    let switches = status
        .lines()
        .find_map(|it| it.strip_prefix("voluntary_ctxt_switches:"));
    ServerCost {
        // nanoseconds on a processor are the first number
        cpu: Duration::from_nanos(times.split(' ').next().unwrap().parse().unwrap()),
        waits: switches.unwrap().trim().parse().unwrap(),
    }
}

#[test]
fn an_hour_at_50_hz_takes_no_memory() {
    let mut system = LoadedSystem::open();
    let tabs = Clients::tabs(&system, 5);
    let viewers = Clients::viewers(&system, 5);
    let mut run = |minutes: u64| {
        for tick in 0..minutes * 60 * 50 {
            system.tick();
            // clients and server have to come in between
            if tick % 500 == 0 {
                std::thread::sleep(Duration::from_millis(2));
            }
        }
    };
    // the first minutes fill the rings, and the buffers of every client
    run(10);
    let until = Instant::now() + Duration::from_secs(60);
    while let Some(slow) = tabs
        .received()
        .chain(viewers.received())
        .find(|it| *it < 50)
    {
        assert!(Instant::now() < until, "a client has {slow} messages");
        run(1);
    }
    let before = memory_kb();
    run(60);
    let growth = memory_kb() - before;
    let received = [tabs.end(), viewers.end()].concat();
    println!("{growth} kB in 180,000 samples of each output; messages: {received:?}");
    assert!(growth < 10_000, "{growth} kB");
    assert!(received.iter().all(|it| *it > 10), "{received:?}");
}

/// Prints CPU time of the server for ten clients: `cargo test --release -p asmotion-monitor --test load -- --ignored --nocapture`.
#[test]
#[ignore = "a figure, which takes a quiet machine"]
fn ten_clients_at_50_hz() {
    type Start = fn(&LoadedSystem, usize) -> Clients;
    let mut system = LoadedSystem::open();
    let kinds: [(&str, Option<Start>); 4] = [
        ("no client", None),
        ("10 tabs", Some(Clients::tabs)),
        ("10 tabs with every sample", Some(Clients::greedy_tabs)),
        ("10 viewers", Some(Clients::viewers)),
    ];
    for (name, start) in kinds {
        let clients = start.map(|start| start(&system, 10));
        let period = Duration::from_millis(20);
        let mut next = Instant::now();
        let mut run = |seconds: u32| {
            for _ in 0..seconds * 50 {
                system.tick();
                next += period;
                std::thread::sleep(next.saturating_duration_since(Instant::now()));
            }
        };
        run(2);
        let received = || -> u64 { clients.iter().flat_map(Clients::received).sum() };
        let charted = || clients.iter().map(|it| it.charted.load(Ordering::Relaxed));
        let charted = || -> u64 { charted().sum() };
        let (began, before, first) = (Instant::now(), server_cost(), received());
        let first_charted = charted();
        run(10);
        let (cost, seconds) = (server_cost(), began.elapsed().as_secs_f64());
        let share = 100.0 * (cost.cpu - before.cpu).as_secs_f64() / seconds;
        let waits = (cost.waits - before.waits) as f64 / seconds;
        let each = (received() - first) as f64 / seconds / 10.0;
        let samples = (charted() - first_charted) as f64 / seconds / 10.0;
        println!(
            "{name}: {share:.2} % of a core, {waits:.0} waits a second; {each:.0} messages and {samples:.1} samples of the arm a second for each"
        );
        clients.map(Clients::end);
    }
}
