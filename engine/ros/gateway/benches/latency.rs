//! Time of messages on their way from a port over ROS to a port, next to that between two nodes of Python, and messages per second.
//!
//! `cargo bench -p asmotion-ros-gateway --bench latency` prints a table for ROS 1, whose peers are nodes of rospy, and one for ROS 2,
//! whose peers are Cyclone DDS in Python; with `ros1` or `ros2` after `--`, only that one. Both kinds of pairs take turns in one run. Here a component writes a message to a port, a
//! bridge publishes it, a bridge with a node of its own receives it, and another component reads it from a port; each in a thread of its
//! own, or in that of the bridge (slaves). rospy needs Debian's package `python3-sensor-msgs`.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::indexing_slicing,
    reason = "a bench fails by panicking and prints its figures"
)]

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use asmotion_component::{Activity, Component, Cycle, Fault, In, Out, Policy};
use asmotion_datum::{Codec, Datum, Numbers, Schema};
use asmotion_ros_domain::{Peer, domain, hex, python};
use asmotion_ros_gateway::{
    MappedTopic, Ros1Settings, Ros1Transport, Ros2Settings, Ros2Transport, RosBridge, RosDirection,
    RosTransport,
};
use asmotion_ros_interface::{Catalogue, Distribution};
use asmotion_ros_master::{Master, Process};
use asmotion_runtime::{Live, Run, System};
use serde_json::{Value, json};

/// Turns of each pair.
const TURNS: usize = 5;
/// Messages of a turn, and how many pass in a second.
const PACED: (usize, usize) = (200, 100);
/// Messages that are on their way at most, when as many as possible pass.
const WINDOW: usize = 64;

/// The kinds of messages, and how many are sent as fast as possible.
const KINDS: [(&str, &str, usize); 3] = [
    ("Twist", "geometry_msgs", 5000),
    ("LaserScan", "sensor_msgs", 2000),
    ("OccupancyGrid", "nav_msgs", 200),
];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let names = words.iter().filter(|it| !it.starts_with('-'));
    let names: Vec<_> = names.collect();
    let is_chosen = |name: &str| names.is_empty() || names.iter().any(|it| *it == name);
    if is_chosen("ros1")
        && let Some(master) = Master::start()
    {
        let rows = KINDS.map(|kind| {
            let uri = master.uri();
            let ours = OurPair::start_both(kind, |node| {
                let settings = Ros1Settings {
                    node: format!("/{node}"),
                    master: uri.clone(),
                    host: "127.0.0.1".to_owned(),
                    relays: Vec::new(),
                };
                let noetic = Arc::new(Catalogue::included(Distribution::Ros1));
                Box::new(Ros1Transport::new(settings, noetic))
            });
            measure(kind, ours, |count, rate| {
                rospy(&master, kind.0, count, rate)
            })
        });
        table("ROS 1", "rospy", &rows);
        bare_sockets();
    }
    if is_chosen("ros2")
        && let Some(python) = python()
    {
        let rows = KINDS.map(|kind| {
            let domain = domain();
            let ours = OurPair::start_both(kind, |node| {
                let settings = Ros2Settings {
                    node: format!("/{node}"),
                    domain,
                    networks: vec![Ipv4Addr::LOCALHOST.into()],
                    relays: Vec::new(),
                };
                Box::new(Ros2Transport::new(settings, jazzy()))
            });
            measure(kind, ours, |count, rate| {
                let send = json!({
                    "domain": domain, "topic": "rt/there", "count": count, "rate": rate,
                    "type": format!("{}::msg::dds_::{}_", kind.1, kind.0),
                    "schema": schema(kind), "message": hex(&Codec::Cdr.encode(&message(kind), &schema(kind)).unwrap()),
                });
                cyclone(&python, &send)
            })
        });
        table("ROS 2", "Cyclone DDS in Python", &rows);
    }
}

/// Times in µs that eight bytes take between two threads over a socket of the loopback interface, at the pace of the messages: what no
/// connection over TCP can do without. With `polls`, the reader asks for them all the time in place of sleeping.
fn bare_socket(polls: bool) -> Vec<f64> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let mut writer = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    writer.set_nodelay(true).unwrap();
    let (mut reader, _) = listener.accept().unwrap();
    reader.set_nonblocking(polls).unwrap();
    let (start, (count, rate)) = (Instant::now(), PACED);
    let now = move || u64::try_from(start.elapsed().as_nanos()).unwrap();
    let reading = std::thread::spawn(move || {
        let mut ages = Vec::with_capacity(count);
        let mut sent = [0; 8];
        while ages.len() < count {
            match reader.read_exact(&mut sent) {
                Ok(()) => ages.push((now() - u64::from_le_bytes(sent)) as f64 / 1e3),
                Err(error) => assert_eq!(error.kind(), ErrorKind::WouldBlock),
            }
        }
        ages
    });
    for _ in 0..count {
        std::thread::sleep(Duration::from_secs(1) / u32::try_from(rate).unwrap());
        writer.write_all(&now().to_le_bytes()).unwrap();
    }
    reading.join().unwrap()
}

fn bare_sockets() {
    let mut ages = [Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        for (polls, ages) in [false, true].into_iter().zip(&mut ages) {
            ages.extend(bare_socket(polls));
        }
    }
    let [waiting, polling] = ages.map(|mut ages| {
        ages.sort_by(f64::total_cmp);
        let at = |part: f64| ages[(ages.len() as f64 * part) as usize];
        format!("{:.0} / {:.0}", at(0.5), at(0.99))
    });
    println!(
        "\nA bare socket, median and 99 % in µs: {waiting}; with a reader that does not sleep {polling}"
    );
}

fn jazzy() -> Arc<Catalogue> {
    Arc::new(Catalogue::included(Distribution::Ros2))
}

fn schema((name, package, _): (&str, &str, usize)) -> Schema {
    let name = format!("{package}/msg/{name}").parse().unwrap();
    jazzy().schema(&name).unwrap()
}

/// A message of a kind.
fn message(kind: (&str, &str, usize)) -> Datum {
    let fields = match kind.0 {
        "Twist" => Vec::new(),
        "LaserScan" => {
            let ranges: Arc<[f32]> = (0..720u16).map(|index| f32::from(index) / 100.0).collect();
            vec![("ranges", Datum::Numbers(Numbers::F32(ranges)))]
        }
        _ => {
            let cells: Arc<[i8]> = (0..160_000u32).map(|index| (index % 101) as i8).collect();
            vec![("data", Datum::Numbers(Numbers::I8(cells)))]
        }
    };
    schema(kind).complete(Datum::record(fields)).unwrap()
}

/// Times on the way in µs, and messages per second.
#[derive(Default)]
struct Figures {
    ages: Vec<f64>,
    pace: f64,
}

impl Figures {
    fn of(line: &str) -> Self {
        let line: Value = serde_json::from_str(line).unwrap();
        let ages = line["ages"].as_array().unwrap().iter();
        Self {
            ages: ages.map(|it| it.as_f64().unwrap()).collect(),
            pace: line["pace"].as_f64().unwrap(),
        }
    }
}

struct Row {
    kind: &'static str,
    /// With threads, and with slaves.
    ours: [Figures; 2],
    theirs: Figures,
}

/// Measures both pairs in turns.
fn measure(
    (kind, _, many): (&'static str, &str, usize),
    mut ours: [OurPair; 2],
    mut theirs: impl FnMut(usize, usize) -> Figures,
) -> Row {
    let mut row = Row {
        kind,
        ours: Default::default(),
        theirs: Figures::default(),
    };
    for _ in 0..TURNS {
        for (pair, figures) in ours.iter_mut().zip(&mut row.ours) {
            figures.ages.extend(pair.paced());
            figures.pace = figures.pace.max(pair.pace(many));
        }
        row.theirs.ages.extend(theirs(PACED.0, PACED.1).ages);
        row.theirs.pace = row.theirs.pace.max(theirs(many, 0).pace);
    }
    row
}

fn table(of: &str, peer: &str, rows: &[Row]) {
    println!("\n{of}, medians and 99 % in µs, and messages per second\n");
    println!(
        "| message | port to port | with slaves | {peer} | ratio | with slaves | per s | with slaves | {peer} |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for Row { kind, ours, theirs } in rows {
        let at = |of: &Figures, part: f64| {
            let mut ages = of.ages.clone();
            ages.sort_by(f64::total_cmp);
            ages[(ages.len() as f64 * part) as usize]
        };
        let both = |of: &Figures| format!("{:.0} / {:.0}", at(of, 0.5), at(of, 0.99));
        let [threads, slaves] = ours;
        let ratio = |of| format!("{:.2}", at(of, 0.5) / at(theirs, 0.5));
        let times = [threads, slaves, theirs].map(both).join(" | ");
        let ratios = [threads, slaves].map(ratio).join(" | ");
        let paces = [threads, slaves, theirs].map(|of| format!("{:.0}", of.pace));
        println!("| {kind} | {times} | {ratios} | {} |", paces.join(" | "));
    }
}

/// What the components at both ends share.
#[derive(Default)]
struct Progress {
    sent: Vec<Instant>,
    received: Vec<Instant>,
    /// Messages to be sent, in each cycle at most `batch`.
    remaining: usize,
    batch: usize,
}

type SharedProgress = Arc<Mutex<Progress>>;

struct Source {
    out: Out<Datum>,
    message: Datum,
    progress: SharedProgress,
}

impl Component for Source {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let mut progress = self.progress.lock().unwrap();
        let on_way = progress.sent.len() - progress.received.len();
        let room = WINDOW.saturating_sub(on_way);
        let count = progress.remaining.min(progress.batch).min(room);
        progress.remaining -= count;
        for _ in 0..count {
            progress.sent.push(Instant::now());
            cycle.write(self.out, self.message.clone());
        }
        Ok(())
    }
}

struct Sink {
    input: In<Datum>,
    progress: SharedProgress,
}

impl Component for Sink {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        let count = cycle.all(self.input).len();
        let now = Instant::now();
        let mut progress = self.progress.lock().unwrap();
        progress.received.extend(std::iter::repeat_n(now, count));
        Ok(())
    }
}

/// Two bridges with a component each, in one process.
struct OurPair {
    run: Live,
    progress: SharedProgress,
}

impl OurPair {
    fn start_both(
        kind: (&str, &str, usize),
        transport: impl Fn(&str) -> Box<dyn RosTransport>,
    ) -> [Self; 2] {
        let pair = |topic: &str, has_slaves| Self::start(kind, topic, has_slaves, &transport);
        [pair("here", false), pair("near", true)]
    }

    fn start(
        kind: (&str, &str, usize),
        topic: &str,
        has_slaves: bool,
        transport: impl Fn(&str) -> Box<dyn RosTransport>,
    ) -> Self {
        let (schema, progress) = (schema(kind), SharedProgress::default());
        let mapped = |direction| MappedTopic {
            port: "port".to_owned(),
            topic: None,
            schema: schema.clone(),
            ros: format!("/{topic}"),
            kind: format!("{}/{}", kind.1, kind.0),
            queue: 2 * WINDOW,
            is_latched: false,
            is_best_effort: false,
            deadline: None,
            lifespan: None,
            converters: Vec::new(),
            transform: None,
            direction,
        };
        let mut system = System::new();
        for (name, direction) in [
            ("Publishing", RosDirection::ToRos),
            ("Receiving", RosDirection::FromRos),
        ] {
            let node = format!("{}_{topic}", name.to_lowercase());
            let (transport, mapped) = (transport(&node), mapped(direction));
            let create = |interface: &mut _| -> Box<dyn Component> {
                Box::new(RosBridge::new(transport, vec![mapped], interface).unwrap())
            };
            system.add(name, Activity::event(), create).unwrap();
        }
        let (of, shared) = (schema.clone(), Arc::clone(&progress));
        system
            .add(
                "Source",
                Activity::periodic(Duration::from_millis(1)),
                |interface| {
                    Box::new(Source {
                        out: interface.output_of("out", of, "messages"),
                        message: message(kind),
                        progress: shared,
                    })
                },
            )
            .unwrap();
        let (of, shared) = (schema.clone(), Arc::clone(&progress));
        system
            .add("Sink", Activity::event(), |interface| {
                Box::new(Sink {
                    input: interface.input_of("in", of, "messages"),
                    progress: shared,
                })
            })
            .unwrap();
        let queue = || Policy::buffer(2 * WINDOW);
        system
            .connect("Source.out", "Publishing.port", queue())
            .unwrap();
        system
            .connect("Receiving.port", "Sink.in", queue())
            .unwrap();
        if has_slaves {
            system.add_slave("Publishing", "Source").unwrap();
            system.add_slave("Sink", "Receiving").unwrap();
        }
        let mut pair = Self {
            run: system.live(),
            progress,
        };
        pair.join();
        pair
    }

    /// Sends a message until one arrives.
    fn join(&mut self) {
        while self.with(|it| it.received.is_empty()) {
            self.with(|it| (it.remaining, it.batch) = (1, 1));
            self.run.run_for(Duration::from_millis(200));
        }
        self.run.run_for(Duration::from_millis(500));
    }

    fn with<T>(&self, use_progress: impl FnOnce(&mut Progress) -> T) -> T {
        use_progress(&mut self.progress.lock().unwrap())
    }

    /// Forgets the messages so far.
    fn begin(&self, remaining: usize, batch: usize) {
        self.with(|it| {
            *it = Progress {
                remaining,
                batch,
                ..Progress::default()
            }
        });
    }

    /// Runs until so many messages have arrived.
    fn until(&mut self, count: usize) {
        let until = Instant::now() + Duration::from_secs(60);
        while self.with(|it| it.received.len() < count) {
            assert!(Instant::now() < until, "messages are lost");
            self.run.run_for(Duration::from_millis(1));
        }
    }

    /// Times of messages on their way, in µs.
    fn paced(&mut self) -> Vec<f64> {
        let (count, rate) = PACED;
        self.begin(0, 1);
        let begun = Instant::now();
        for number in 0..count {
            let due = begun + Duration::from_secs(1) * number as u32 / rate as u32;
            self.run
                .run_for(due.saturating_duration_since(Instant::now()));
            self.with(|it| it.remaining += 1);
        }
        self.until(count);
        self.with(|it| {
            let pairs = it.sent.iter().zip(&it.received);
            let age = |(sent, received): (&Instant, &Instant)| {
                received.saturating_duration_since(*sent).as_secs_f64() * 1e6
            };
            pairs.map(age).collect()
        })
    }

    /// Messages per second, as many as pass.
    fn pace(&mut self, count: usize) -> f64 {
        self.begin(count, WINDOW);
        self.until(count);
        self.with(|it| {
            let time = it.received[count - 1] - it.received[0];
            (count - 1) as f64 / time.as_secs_f64()
        })
    }
}

/// A sender and a receiver of rospy.
fn rospy(master: &Master, kind: &str, count: usize, rate: usize) -> Figures {
    let expect_ready = |of: &Process| assert_eq!(of.line(), "ready");
    let mut receiver = master.peer("latency", &["receive", "receiver", "/there", kind]);
    expect_ready(&receiver);
    let (count, rate) = (count.to_string(), rate.to_string());
    let arguments = ["send", "sender", "/there", kind, &count, &rate];
    let mut sender = master.peer("latency", &arguments);
    expect_ready(&sender);
    sender.tell("go");
    assert_eq!(sender.line(), "sent");
    receiver.tell("report");
    Figures::of(&receiver.line())
}

/// A sender and a receiver of Cyclone DDS.
fn cyclone(python: &std::path::Path, settings: &Value) -> Figures {
    let start = |role: &str| {
        let mut peer = Peer::start_script(python, "latency", &[role]);
        peer.tell(&settings.to_string());
        peer.expect("ready");
        peer
    };
    let mut receiver = start("receive");
    let mut sender = start("send");
    sender.tell("go");
    sender.expect("sent");
    receiver.tell("report");
    Figures::of(&receiver.line())
}
