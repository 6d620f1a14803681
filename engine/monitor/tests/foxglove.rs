//! The protocol of Foxglove, as a viewer sees it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use asmotion_component::Time;
use asmotion_coordinator::{StepRecord, UpdateRecord};
use asmotion_datum::{Datum, Message as _, Sample, message};
use asmotion_monitor::{Dashboard, DashboardSettings, Feed, MonitorSource, SystemDescription};
use asmotion_runtime::{Event, Observer};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

const PATIENCE: Duration = Duration::from_secs(30);

message! {
    /// A vector.
    pub struct Vector3 = "geometry_msgs/Vector3" {
        /// Along x.
        pub x: f64,
        /// Along y.
        pub y: f64,
        /// Along z.
        pub z: f64,
    }
}

message! {
    /// A velocity.
    pub struct Twist = "geometry_msgs/Twist" {
        /// Linear part.
        pub linear: Vector3,
        /// Angular part.
        pub angular: Vector3,
    }
}

message! {
    /// A message that ROS does not have.
    pub struct Reading = "acme/Reading" {
        /// Its value.
        pub value: i64,
    }
}

/// A dashboard of a system that does nothing by itself.
struct Fixture {
    server: Dashboard,
    feed: Feed,
}

impl Fixture {
    fn open(change: impl FnOnce(&mut DashboardSettings)) -> Self {
        let source = MonitorSource::new(SystemDescription::default(), None, Vec::new());
        let feed = source.feed();
        feed.learn(BTreeMap::from([
            ("Pilot.twist".to_owned(), Twist::schema().clone()),
            ("Sensor.reading".to_owned(), Reading::schema().clone()),
        ]));
        let mut settings = DashboardSettings::at(SocketAddr::from(([127, 0, 0, 1], 0)));
        change(&mut settings);
        let server = Dashboard::open(settings, source).unwrap();
        Self { server, feed }
    }

    /// Opens a WebSocket. Returns it with the selected subprotocol, or the status of the refusal.
    fn connect(
        &self,
        path: &str,
        protocols: &'static str,
        origin: Option<&str>,
    ) -> Result<(Viewer, String), u16> {
        let address = self.server.address();
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}{path}")
            .into_client_request()
            .unwrap();
        let headers = request.headers_mut();
        if !protocols.is_empty() {
            let protocols = HeaderValue::from_static(protocols);
            headers.insert("Sec-WebSocket-Protocol", protocols);
        }
        if let Some(origin) = origin {
            headers.insert("Origin", HeaderValue::from_str(origin).unwrap());
        }
        match tungstenite::client(request, stream) {
            Ok((socket, response)) => {
                let selected = response.headers().get("Sec-WebSocket-Protocol").unwrap();
                let viewer = Viewer {
                    socket,
                    channels: BTreeMap::new(),
                };
                Ok((viewer, selected.to_str().unwrap().to_owned()))
            }
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
                Err(response.status().as_u16())
            }
            Err(error) => panic!("{error}"),
        }
    }

    /// A viewer that has been greeted.
    fn viewer(&self) -> Viewer {
        let connected = self.connect("/foxglove", "foxglove.websocket.v1", None);
        let (mut viewer, _) = connected.unwrap_or_else(|status| panic!("{status}"));
        assert_eq!(viewer.text("serverInfo")["capabilities"], json!(["time"]));
        viewer
    }

    fn publish(
        &mut self,
        at: Time,
        (component, port): (&str, &str),
        topic: Option<&str>,
        sample: &dyn Sample,
    ) {
        let event = Event::Published {
            component,
            port,
            topic,
            sequence: 1,
            sample,
        };
        self.feed.observe(at, &event);
    }

    fn read(&mut self, value: i64) {
        let reading = Reading { value };
        let at = Time::from_nanos(value * 1_000_000);
        self.publish(at, ("Sensor", "reading"), None, &reading);
    }

    fn step(&mut self, number: u64, mode: &str) {
        let record = StepRecord {
            specification: "navigate".to_owned(),
            number,
            inputs: vec![("goal".to_owned(), "true".to_owned())],
            choices: vec![(1, 3)],
            updates: vec![UpdateRecord {
                location: "mode".to_owned(),
                before: "IDLE".to_owned(),
                after: mode.to_owned(),
                place: "navigate.asm:3".to_owned(),
            }],
            safe_rule: None,
        };
        let data = Datum::of(&record).unwrap();
        let event = Event::Report {
            component: "Navigator",
            kind: asmotion_coordinator::STEP_REPORT,
            data: &data,
        };
        self.feed.observe(Time::from_nanos(1_500_000_000), &event);
    }
}

struct Viewer {
    socket: WebSocket<TcpStream>,
    /// The advertised channels by name.
    channels: BTreeMap<String, Value>,
}

/// A binary message of the server.
#[derive(Debug, PartialEq)]
enum Data {
    Time(u64),
    Message {
        subscription: u32,
        at: u64,
        data: Vec<u8>,
    },
}

enum Received {
    Text(Value),
    Data(Data),
}

fn u64_at(bytes: &[u8], from: usize) -> u64 {
    u64::from_le_bytes(bytes[from..from + 8].try_into().unwrap())
}

impl Viewer {
    fn send(&mut self, message: &Value) {
        self.socket
            .send(Message::text(message.to_string()))
            .unwrap();
    }

    /// The next message. Answers pings, as every client does.
    fn next(&mut self) -> Received {
        loop {
            match self.socket.read().unwrap() {
                Message::Text(text) => {
                    let message: Value = serde_json::from_str(&text).unwrap();
                    for channel in message["channels"].as_array().into_iter().flatten() {
                        let name = channel["topic"].as_str().unwrap();
                        self.channels.insert(name.to_owned(), channel.clone());
                    }
                    return Received::Text(message);
                }
                Message::Binary(bytes) if bytes[0] == 1 => {
                    return Received::Data(Data::Message {
                        subscription: u32::from_le_bytes(bytes[1..5].try_into().unwrap()),
                        at: u64_at(&bytes, 5),
                        data: bytes[13..].to_vec(),
                    });
                }
                Message::Binary(bytes) => {
                    assert_eq!((bytes[0], bytes.len()), (2, 9));
                    return Received::Data(Data::Time(u64_at(&bytes, 1)));
                }
                Message::Ping(_) | Message::Pong(_) => {}
                other @ (Message::Close(_) | Message::Frame(_)) => panic!("{other:?}"),
            }
        }
    }

    /// The next text of this kind.
    fn text(&mut self, op: &str) -> Value {
        loop {
            if let Received::Text(message) = self.next()
                && message["op"] == op
            {
                return message;
            }
        }
    }

    /// The number of a channel, once it is advertised.
    fn channel(&mut self, name: &str) -> Value {
        let begun = Instant::now();
        loop {
            if let Some(channel) = self.channels.get(name) {
                return channel.clone();
            }
            assert!(begun.elapsed() < PATIENCE, "no channel `{name}`");
            self.next();
        }
    }

    fn subscribe(&mut self, id: u32, channel: &str) -> Value {
        let channel = self.channel(channel);
        let subscription = json!({ "id": id, "channelId": channel["id"] });
        self.send(&json!({ "op": "subscribe", "subscriptions": [subscription] }));
        channel
    }

    /// The next message of a subscription, with its time.
    fn message(&mut self, wanted: u32) -> (u64, Vec<u8>) {
        let begun = Instant::now();
        loop {
            if let Received::Data(Data::Message {
                subscription,
                at,
                data,
            }) = self.next()
                && subscription == wanted
            {
                return (at, data);
            }
            assert!(begun.elapsed() < PATIENCE, "no message");
        }
    }

    fn json(&mut self, wanted: u32) -> Value {
        serde_json::from_slice(&self.message(wanted).1).unwrap()
    }
}

#[test]
fn a_viewer_is_served_under_each_name_of_the_protocol() {
    let fixture = Fixture::open(|_| {});
    for (path, offered, selected) in [
        (
            "/foxglove",
            "foxglove.websocket.v1",
            "foxglove.websocket.v1",
        ),
        (
            "/foxglove",
            "foxglove.sdk.v1.1, foxglove.sdk.v1, foxglove.websocket.v1",
            "foxglove.sdk.v1",
        ),
        (
            "/",
            "foxglove.websocket.v1, foxglove.sdk.v1",
            "foxglove.websocket.v1",
        ),
    ] {
        let connected = fixture.connect(path, offered, None);
        let (mut viewer, spoken) = connected.unwrap_or_else(|status| panic!("{status}"));
        assert_eq!(spoken, selected);
        let info = viewer.text("serverInfo");
        assert!(info["name"].as_str().unwrap().starts_with("asmotion"));
        assert!(!info["sessionId"].as_str().unwrap().is_empty());
    }
    for offered in ["", "chat", "foxglove.sdk.v2"] {
        let refused = fixture.connect("/foxglove", offered, None).err();
        assert_eq!(refused, Some(400), "{offered}");
    }
    // the page is still there
    assert_eq!(
        fixture
            .connect("/live", "foxglove.sdk.v1", Some("http://evil.example"))
            .err(),
        Some(403)
    );
}

#[test]
fn only_pages_of_allowed_origins_read() {
    let app = "https://app.foxglove.dev";
    let status = |fixture: &Fixture, path: &str, origin: &str| {
        let connected = fixture.connect(path, "foxglove.websocket.v1", Some(origin));
        connected.err().unwrap_or(101)
    };
    let closed = Fixture::open(|_| {});
    assert_eq!(status(&closed, "/foxglove", app), 403);
    let open = Fixture::open(|settings| settings.allowed_origins = vec![app.to_owned()]);
    let own = format!("http://{}", open.server.address());
    for (path, origin, expected) in [
        ("/foxglove", app, 101),
        ("/", app, 101),
        ("/foxglove", &own, 101),
        ("/foxglove", "https://evil.example", 403),
        ("/foxglove", "null", 403),
        // the dashboard itself, which can control the system, stays closed
        ("/live", app, 403),
    ] {
        assert_eq!(status(&open, path, origin), expected, "{path} {origin}");
    }
}

#[test]
fn samples_are_of_ros_if_it_has_their_type_and_json_otherwise() {
    let mut fixture = Fixture::open(|_| {});
    let twist = Twist {
        linear: Vector3 {
            x: 0.5,
            y: 0.0,
            z: 0.0,
        },
        angular: Vector3 {
            x: 0.0,
            y: 0.0,
            z: -1.0,
        },
    };
    let at = Time::from_nanos(2_500_000_000);
    fixture.publish(at, ("Pilot", "twist"), Some("cmd_vel"), &twist);
    fixture.read(7);
    let mut viewer = fixture.viewer();
    let channel = viewer.subscribe(40, "topic/cmd_vel");
    assert_eq!(
        (
            &channel["encoding"],
            &channel["schemaName"],
            &channel["schemaEncoding"]
        ),
        (
            &json!("cdr"),
            &json!("geometry_msgs/msg/Twist"),
            &json!("ros2msg")
        )
    );
    assert!(
        channel["schema"]
            .as_str()
            .unwrap()
            .contains("MSG: geometry_msgs/Vector3")
    );
    // a sample from before the subscription is new to the viewer
    let (time, data) = viewer.message(40);
    assert_eq!((time, data.len()), (2_500_000_000, 4 + 6 * 8));
    assert_eq!(f64::from_le_bytes(data[4..12].try_into().unwrap()), 0.5);
    let channel = viewer.subscribe(41, "port/Sensor.reading");
    assert_eq!(
        (&channel["encoding"], &channel["schemaName"]),
        (&json!("json"), &json!("acme/Reading"))
    );
    let schema: Value = serde_json::from_str(channel["schema"].as_str().unwrap()).unwrap();
    assert_eq!(schema["properties"]["value"]["type"], "integer");
    assert_eq!(viewer.json(41), json!({ "value": 7 }));
    fixture.read(8);
    assert_eq!(
        viewer.message(41),
        (8_000_000, b"{\"value\":8}".to_vec()),
        "its time is that of the run"
    );
    viewer.send(&json!({ "op": "unsubscribe", "subscriptionIds": [41] }));
    // answered after the server has handled the one before
    viewer.subscribe(41, "log");
    viewer.json(41);
}

#[test]
fn steps_states_and_the_log_are_channels() {
    let mut fixture = Fixture::open(|_| {});
    fixture.step(12, "DRIVE");
    let text = Datum::text("goal reached");
    let event = Event::Report {
        component: "Navigator",
        kind: "notice",
        data: &text,
    };
    fixture
        .feed
        .observe(Time::from_nanos(1_600_000_000), &event);
    let mut viewer = fixture.viewer();
    viewer.subscribe(0, "asm/Navigator/step");
    viewer.subscribe(1, "asm/Navigator/state");
    let channel = viewer.subscribe(2, "log");
    assert_eq!(channel["schemaName"], "foxglove.Log");
    let (mut steps, mut states, mut entries) = (Vec::new(), Vec::new(), Vec::new());
    while steps.is_empty() || states.is_empty() || entries.is_empty() {
        if let Received::Data(Data::Message {
            subscription,
            at,
            data,
        }) = viewer.next()
        {
            let list = [&mut steps, &mut states, &mut entries];
            let message: Value = serde_json::from_slice(&data).unwrap();
            list[subscription as usize].push((at, message));
        }
    }
    let (at, step) = &steps[0];
    assert_eq!((*at, &step["number"]), (1_500_000_000, &json!(12)));
    assert_eq!(
        step["read"],
        json!([{ "location": "goal", "value": "true" }])
    );
    assert_eq!(step["choices"], json!([{ "index": 1, "of": 3 }]));
    assert_eq!(step["updates"][0]["after"], "DRIVE");
    let (_, state) = &states[0];
    assert_eq!(state["values"]["mode"], "DRIVE");
    let (at, entry) = &entries[0];
    assert_eq!(*at, 1_600_000_000);
    assert_eq!(
        (&entry["name"], &entry["level"]),
        (&json!("Navigator"), &json!(2))
    );
    assert_eq!(entry["message"], "notice: goal reached");
    assert_eq!(entry["timestamp"], json!({ "sec": 1, "nsec": 600_000_000 }));
    fixture.step(13, "IDLE");
    assert_eq!(viewer.json(1)["values"]["mode"], "IDLE");
}

#[test]
fn the_time_of_the_run_comes_before_its_messages() {
    let mut fixture = Fixture::open(|_| {});
    fixture.read(3);
    let mut viewer = fixture.viewer();
    viewer.subscribe(9, "port/Sensor.reading");
    viewer.message(9);
    fixture.read(5);
    let mut times = Vec::new();
    loop {
        match viewer.next() {
            Received::Data(Data::Time(time)) => times.push(time),
            Received::Data(Data::Message { at, .. }) => {
                assert_eq!(at, 5_000_000);
                break;
            }
            Received::Text(_) => {}
        }
    }
    assert_eq!(times.last(), Some(&5_000_000), "{times:?}");
}

#[test]
fn a_viewer_that_is_frozen_neither_delays_others_nor_sees_the_past_as_the_present() {
    let mut fixture = Fixture::open(|_| {});
    fixture.read(0);
    let (mut frozen, mut other) = (fixture.viewer(), fixture.viewer());
    frozen.subscribe(1, "port/Sensor.reading");
    other.subscribe(1, "port/Sensor.reading");
    frozen.message(1);
    other.message(1);
    // it reads nothing, and so answers no ping, while the system continues
    for value in 1..=200 {
        fixture.read(value);
        std::thread::sleep(Duration::from_millis(5));
    }
    let newest = |viewer: &mut Viewer| {
        let mut count = 0;
        let mut said = Vec::new();
        loop {
            match viewer.next() {
                Received::Data(Data::Message { data, .. }) => {
                    count += 1;
                    let message: Value = serde_json::from_slice(&data).unwrap();
                    if message["value"] == 200 {
                        return (count, said);
                    }
                }
                Received::Text(message) if message["op"] == "status" => {
                    said.push(message["message"].as_str().unwrap().to_owned());
                }
                Received::Text(_) | Received::Data(Data::Time(_)) => {}
            }
        }
    };
    let begun = Instant::now();
    let (count, said) = newest(&mut frozen);
    assert!(begun.elapsed() < Duration::from_secs(5));
    // those of two intervals of 100 ms, up to four of the tick before them, and the newest one
    assert!(count <= 2 * 20 + 4 + 1, "{count} messages were waiting");
    assert!(said.iter().any(|it| it.contains("too slow")), "{said:?}");
    // the other one did not read either, but that is not known before it does; both are served again
    newest(&mut other);
    fixture.read(201);
    assert_eq!(frozen.json(1)["value"], 201);
    assert_eq!(other.json(1)["value"], 201);
}

#[test]
fn requests_are_limited_and_nonsense_is_answered() {
    let mut fixture = Fixture::open(|settings| settings.max_channels = 2);
    fixture.step(1, "DRIVE");
    let mut viewer = fixture.viewer();
    viewer.subscribe(1, "log");
    viewer.subscribe(2, "asm/Navigator/step");
    assert_eq!(viewer.json(2)["number"], 1);
    let problem = |viewer: &mut Viewer, message: &str, expected: &str| {
        viewer.socket.send(Message::text(message)).unwrap();
        let said = viewer.text("status");
        assert!(
            said["message"].as_str().unwrap().contains(expected),
            "{said}"
        );
    };
    let state = viewer.channel("asm/Navigator/state")["id"].clone();
    let log = viewer.channel("log")["id"].clone();
    let subscribe = |id: u32, channel: &Value| {
        json!({ "op": "subscribe", "subscriptions": [{ "id": id, "channelId": channel }] })
            .to_string()
    };
    problem(&mut viewer, &subscribe(3, &state), "2 channels at most");
    problem(&mut viewer, &subscribe(3, &log), "subscribed to already");
    problem(&mut viewer, &subscribe(1, &state), "in use");
    problem(
        &mut viewer,
        &subscribe(3, &json!(4_000_000_000_u32)),
        "no channel",
    );
    for nonsense in ["", "[]", "{\"op\":\"subscribe\"}", "{\"op\":7}"] {
        problem(&mut viewer, nonsense, "not understood");
    }
    // it shows the system, and cannot change it
    for wish in ["advertise", "setParameters", "getParameters", "fetchAsset"] {
        problem(
            &mut viewer,
            &json!({ "op": wish, "channels": [] }).to_string(),
            "only shows",
        );
    }
    // what is subscribed to still comes
    fixture.step(2, "IDLE");
    assert_eq!(viewer.json(2)["number"], 2);
    viewer
        .socket
        .send(Message::binary(vec![1, 0, 0, 0, 0]))
        .unwrap();
    let closed = loop {
        match viewer.socket.read() {
            Ok(Message::Close(frame)) => break frame.map(|it| it.code.into()),
            Ok(_) => {}
            Err(error) => panic!("{error}"),
        }
    };
    assert_eq!(closed, Some(1003_u16), "a published message");
}

#[test]
fn a_new_version_of_the_system_can_have_other_types() {
    let mut fixture = Fixture::open(|_| {});
    fixture.read(1);
    let mut viewer = fixture.viewer();
    let before = viewer.subscribe(1, "port/Sensor.reading");
    viewer.message(1);
    fixture.feed.learn(BTreeMap::from([(
        "Sensor.reading".to_owned(),
        Twist::schema().clone(),
    )]));
    fixture.feed.follow(SystemDescription::default());
    let twist = Twist::default();
    fixture.publish(
        Time::from_nanos(9_000_000),
        ("Sensor", "reading"),
        None,
        &twist,
    );
    let gone = viewer.text("unadvertise");
    assert_eq!(gone["channelIds"], json!([before["id"]]));
    viewer.channels.remove("port/Sensor.reading");
    let after = viewer.subscribe(2, "port/Sensor.reading");
    assert_eq!(after["schemaName"], "geometry_msgs/msg/Twist");
    assert_ne!(after["id"], before["id"]);
    assert_eq!(viewer.message(2).0, 9_000_000);
}

#[test]
fn the_end_of_a_run_is_said_and_does_not_wait_for_viewers() {
    let fixture = Fixture::open(|_| {});
    let mut viewer = fixture.viewer();
    let _silent = fixture.viewer();
    fixture.feed.end("reached");
    assert_eq!(viewer.text("status")["message"], "the run has ended");
    let begun = Instant::now();
    drop(fixture);
    assert!(begun.elapsed() < Duration::from_secs(3));
}
