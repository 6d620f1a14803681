//! The server of the dashboard, as clients of all kinds see it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, LocalBus, Notifier, Payload};
use asmotion_component::Time;
use asmotion_datum::{Datum, Sample};
use asmotion_monitor::{
    BearerToken, BusLink, Dashboard, DashboardSettings, Feed, MonitorSource, OrderBus,
    SystemDescription,
};
use asmotion_runtime::{Event, Observer};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Error, Message, WebSocket};

const PATIENCE: Duration = Duration::from_secs(30);

/// A dashboard of a system that does nothing by itself.
struct Fixture {
    server: Dashboard,
    feed: Feed,
    bus: LocalBus,
}

impl Fixture {
    fn open(change: impl FnOnce(&mut DashboardSettings)) -> Self {
        let bus = LocalBus::new();
        let orders = OrderBus {
            bus: Arc::new(bus.clone()),
            process: "rover".to_owned(),
        };
        let link = BusLink {
            name: "broker \"1\"".to_owned(),
            bus: Arc::new(bus.clone()),
        };
        let source = MonitorSource::new(SystemDescription::default(), Some(orders), vec![link]);
        let feed = source.feed();
        let mut settings = DashboardSettings::at(SocketAddr::from(([127, 0, 0, 1], 0)));
        change(&mut settings);
        let server = Dashboard::open(settings, source).unwrap();
        Self { server, feed, bus }
    }

    fn address(&self) -> SocketAddr {
        self.server.address()
    }

    /// Sends a request with these headers, and returns the head and the body of the response.
    fn request(&self, path: &str, headers: &str) -> (String, String) {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n");
        stream.write_all(request.as_bytes()).unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.to_owned(), body.to_owned())
    }

    fn host(&self) -> String {
        format!("Host: {}\r\n", self.address())
    }

    fn status(&self, path: &str, headers: &str) -> String {
        let (head, _) = self.request(path, headers);
        head.split(' ').nth(1).unwrap().to_owned()
    }

    /// Opens a WebSocket, with this `Origin` if there is one.
    fn connect(&self, origin: Option<&str>) -> Result<Client, String> {
        let stream = TcpStream::connect(self.address()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{}/live", self.address());
        let mut request = url.into_client_request().unwrap();
        if let Some(origin) = origin {
            let origin = HeaderValue::from_str(origin).unwrap();
            request.headers_mut().insert("Origin", origin);
        }
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Client(socket)),
            Err(error) => Err(error.to_string()),
        }
    }

    fn client(&self) -> Client {
        let mut client = self.connect(None).unwrap();
        assert_eq!(client.next()["type"], "hello");
        client
    }

    /// Carries out the orders of the bus for ever, and passes on what they were.
    fn serve_orders(&self) -> std::sync::mpsc::Receiver<Datum> {
        let (sender, received) = std::sync::mpsc::channel();
        let address = self
            .bus
            .serve("control.rover", 16, Arc::new(Notifier::new()))
            .unwrap();
        std::thread::spawn(move || {
            loop {
                while let Some(call) = address.try_next() {
                    let order = call.argument.to_datum().unwrap();
                    call.reply(Ok(Payload::of(Datum::Null)));
                    if sender.send(order).is_err() {
                        return;
                    }
                }
                std::thread::sleep(Duration::from_millis(5));
            }
        });
        received
    }

    fn publish(&mut self, value: i64) {
        let sample = Datum::Int(value);
        self.feed.observe(Time::ZERO, &published(&sample));
    }

    fn report(&mut self, text: &str) {
        let data = Datum::text(text);
        let event = Event::Report {
            component: "Driver",
            kind: "notice",
            data: &data,
        };
        self.feed.observe(Time::ZERO, &event);
    }
}

fn published(sample: &dyn Sample) -> Event<'_> {
    Event::Published {
        component: "Driver",
        port: "odom",
        topic: None,
        sequence: 1,
        sample,
    }
}

struct Client(WebSocket<TcpStream>);

impl Client {
    fn send(&mut self, message: &Value) {
        self.0.send(Message::text(message.to_string())).unwrap();
    }

    /// The next message.
    fn next(&mut self) -> Value {
        loop {
            match self.0.read().unwrap() {
                Message::Text(text) => return serde_json::from_str(&text).unwrap(),
                Message::Ping(_) | Message::Pong(_) => {}
                other @ (Message::Binary(_) | Message::Close(_) | Message::Frame(_)) => {
                    panic!("{other:?}")
                }
            }
        }
    }

    /// The next message that is no frame.
    fn reply(&mut self) -> Value {
        loop {
            let message = self.next();
            if message["type"] != "frame" {
                return message;
            }
            self.send(&json!({ "type": "ack", "seq": message["seq"] }));
        }
    }

    /// The next frame with such a part; the frames until then are acknowledged.
    fn frame_with(&mut self, part: &str) -> Value {
        let begun = Instant::now();
        loop {
            let frame = self.next();
            self.send(&json!({ "type": "ack", "seq": frame["seq"] }));
            if !frame[part].is_null() {
                return frame;
            }
            assert!(begun.elapsed() < PATIENCE, "no frame with `{part}`");
        }
    }

    fn subscribe(&mut self, streams: &[&str]) {
        self.send(&json!({ "type": "subscribe", "streams": streams, "max_hz": 60.0 }));
    }

    /// Subscribes to every sample of the driver.
    fn subscribe_to_every(&mut self, max_hz: f64) {
        self.send(&json!({ "type": "subscribe", "streams": [], "every": ["Driver.odom"], "max_hz": max_hz }));
    }

    /// The samples of the driver up to this one, and the number of batches in which they have arrived.
    fn samples_until(&mut self, last: i64) -> (Vec<i64>, usize) {
        let (mut samples, mut batches) = (Vec::new(), 0);
        while samples.last() != Some(&last) {
            let frame = self.frame_with("batches");
            let batch = &frame["batches"]["Driver.odom"];
            assert_eq!(batch["missed"], 0, "{batch}");
            let pairs = batch["samples"].as_array().unwrap().iter();
            samples.extend(pairs.map(|pair| pair[1].as_i64().unwrap()));
            assert_eq!(batch["n"].as_i64(), samples.last().copied(), "{batch}");
            batches += 1;
        }
        (samples, batches)
    }

    /// Asks for the part of the log with these words.
    fn filter(&mut self, number: u64, words: &[&str]) {
        let filter = json!({ "number": number, "level": "notice", "words": words });
        self.send(
            &json!({ "type": "subscribe", "streams": ["log"], "log": filter, "max_hz": 60.0 }),
        );
    }

    /// The texts of the next entries of the log under this name.
    fn entries(&mut self, name: &str) -> Vec<String> {
        let frame = self.frame_with(name);
        let entries = match name {
            "found" => &frame["found"]["entries"],
            name => &frame[name],
        };
        let entries = entries.as_array().unwrap().iter();
        entries
            .map(|it| it["text"].as_str().unwrap().to_owned())
            .collect()
    }
}

#[test]
fn every_sample_of_a_chart_arrives_once_and_in_order() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    fixture.publish(1);
    client.subscribe_to_every(60.0);
    assert_eq!(client.samples_until(1).0, [1]);
    let (mut seen, mut batches, mut last) = (Vec::new(), 0, 1);
    for burst in [1, 7, 30, 200, 2, 500] {
        (last + 1..=last + burst).for_each(|value| fixture.publish(value));
        last += burst;
        let (samples, count) = client.samples_until(last);
        seen.extend(samples);
        batches += count;
    }
    assert_eq!(seen, (2..=last).collect::<Vec<_>>());
    assert!(batches < 100, "{batches}");
    // one that comes later begins with what is still there, and misses nothing from then on
    let mut late = fixture.client();
    late.subscribe_to_every(60.0);
    let (first, _) = late.samples_until(last);
    assert!(first.len() > 100, "{}", first.len());
    (last + 1..=last + 50).for_each(|value| fixture.publish(value));
    for client in [&mut client, &mut late] {
        let (samples, _) = client.samples_until(last + 50);
        assert_eq!(samples, (last + 1..=last + 50).collect::<Vec<_>>());
    }
}

#[test]
fn a_tab_in_the_background_gets_fewer_frames_and_the_same_samples() {
    let mut fixture = Fixture::open(|_| {});
    let (mut shown, mut hidden) = (fixture.client(), fixture.client());
    fixture.publish(1);
    for (client, max_hz) in [(&mut shown, 60.0), (&mut hidden, 1.0)] {
        client.subscribe_to_every(max_hz);
        client.samples_until(1);
    }
    let begun = Instant::now();
    let (mut frames, mut seen) = (0, Vec::new());
    for value in 2..=60 {
        fixture.publish(value);
        let (samples, batches) = shown.samples_until(value);
        seen.extend(samples);
        frames += batches;
    }
    let (samples, few) = hidden.samples_until(60);
    let seconds = begun.elapsed().as_secs_f64();
    let expected: Vec<i64> = (2..=60).collect();
    assert_eq!((&seen, &samples), (&expected, &expected));
    // 30 and 1 in a second, one more at each end; whatever was asked for, there are no more
    assert_eq!(frames, 59);
    let frames = u32::try_from(frames).unwrap();
    assert!(f64::from(frames) <= 30.0 * seconds + 2.0, "{seconds} s");
    let few = u32::try_from(few).unwrap();
    assert!(f64::from(few) <= seconds + 2.0, "{few} in {seconds} s");
}

#[test]
fn a_frozen_tab_learns_how_many_samples_of_a_chart_are_gone() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    fixture.publish(1);
    client.subscribe_to_every(60.0);
    client.samples_until(1);
    (2..=1000).for_each(|value| fixture.publish(value));
    let frame = client.frame_with("batches");
    let first = &frame["batches"]["Driver.odom"];
    let mut known: Vec<Value> = first["samples"].as_array().unwrap().clone();
    let mut missed = first["missed"].as_u64().unwrap();
    while known.last().unwrap()[1] != 1000 {
        let frame = client.frame_with("batches");
        let batch = &frame["batches"]["Driver.odom"];
        known.extend(batch["samples"].as_array().unwrap().iter().cloned());
        missed += batch["missed"].as_u64().unwrap();
    }
    // each of the 999 has arrived, or is counted; a client that reads all the time may miss none
    assert_eq!(known.len() as u64 + missed, 999);
}

#[test]
fn a_tab_is_sent_only_the_part_of_the_log_that_it_asks_for() {
    let mut fixture = Fixture::open(|_| {});
    for number in 1..=400 {
        let colour = ["Red", "blue"][number % 2];
        fixture.report(&format!("{colour} {number}"));
    }
    let mut client = fixture.client();
    // of all that is kept, not only of what a tab receives at first
    client.filter(1, &["RED", "!00"]);
    let found = client.entries("found");
    let is_red = |it: &String| it.starts_with("Red") && !it.contains("00");
    assert_eq!(found.len(), 196);
    assert!(found.iter().all(is_red), "{found:?}");
    fixture.report("blue 401");
    fixture.report("Red 402");
    assert_eq!(client.entries("found"), ["Red 402"]);
    // nothing is an answer as well, and names its question
    client.filter(2, &["green"]);
    let frame = client.frame_with("found");
    assert_eq!(frame["found"], json!({ "filter": 2, "entries": [] }));
    // all of the log continues where it begins for a new tab, and then has everything
    client.subscribe(&["log"]);
    let all = client.entries("log");
    assert_eq!(
        (all.len(), &*all[0], &**all.last().unwrap()),
        (302, "blue 101", "Red 402")
    );
    client.filter(3, &["blue"]);
    assert_eq!(client.entries("found").len(), 201);
    fixture.report("Red 403");
    client.subscribe(&["log"]);
    assert_eq!(client.entries("log"), ["Red 403"]);
}

#[test]
fn a_foreign_host_is_refused_everywhere() {
    let fixture = Fixture::open(|_| {});
    for path in ["/", "/main.js", "/metrics", "/api/system", "/live"] {
        assert_eq!(
            fixture.status(path, "Host: evil.example\r\n"),
            "421",
            "{path}"
        );
        let rebound = "Host: 127.0.0.1.evil.example\r\nOrigin: http://127.0.0.1.evil.example\r\n";
        assert_eq!(fixture.status(path, rebound), "421", "{path}");
        assert_eq!(fixture.status(path, ""), "421", "{path}");
    }
    let (host, port) = (fixture.host(), fixture.address().port());
    assert_eq!(fixture.status("/", &host), "200");
    assert_eq!(
        fixture.status("/metrics", &format!("Host: localhost:{port}\r\n")),
        "200"
    );
}

#[test]
fn a_foreign_origin_is_refused_everywhere() {
    let fixture = Fixture::open(|_| {});
    let host = fixture.host();
    let port = fixture.address().port();
    for origin in [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        for path in ["/", "/metrics", "/live"] {
            let headers = format!("{host}Origin: {origin}\r\n");
            assert_eq!(fixture.status(path, &headers), "403", "{path} {origin}");
        }
        assert!(fixture.connect(Some(&origin)).is_err(), "{origin}");
    }
    let own = format!("http://127.0.0.1:{port}");
    assert!(fixture.connect(Some(&own)).is_ok());
    assert!(fixture.connect(None).is_ok());
}

#[test]
fn a_tab_controls_nothing_without_the_token() {
    let fixture = Fixture::open(|settings| settings.control = Some(BearerToken::new("s3cret")));
    let orders = fixture.serve_orders();
    let mut client = fixture.client();
    let order = json!({ "type": "order", "id": 7, "component": "Driver", "wish": "stop" });
    client.send(&order);
    let refused = client.reply();
    assert_eq!(
        (&refused["type"], &refused["id"]),
        (&json!("problem"), &json!(7))
    );
    assert!(
        refused["text"].as_str().unwrap().contains("not armed"),
        "{refused}"
    );
    for token in ["", "s3cre", "s3crets"] {
        client.send(&json!({ "type": "arm", "token": token }));
        assert!(
            client.reply()["text"]
                .as_str()
                .unwrap()
                .contains("wrong token")
        );
    }
    client.send(&order);
    assert_eq!(client.reply()["type"], "problem");
    assert!(
        orders.try_recv().is_err(),
        "an order has reached the system"
    );

    client.send(&json!({ "type": "arm", "token": "s3cret" }));
    assert_eq!(client.reply()["type"], "armed");
    client.send(&order);
    assert_eq!(client.reply(), json!({ "type": "done", "id": 7 }));
    let order = orders.recv_timeout(PATIENCE).unwrap();
    assert_eq!(order.get("wish").unwrap().as_text(), Some("stop"));

    // another tab needs the permission, and gets it when the first one has gone
    let mut other = fixture.client();
    other.send(&json!({ "type": "arm", "token": "s3cret" }));
    assert!(
        other.reply()["text"]
            .as_str()
            .unwrap()
            .contains("another tab")
    );
    drop(client);
    let begun = Instant::now();
    loop {
        other.send(&json!({ "type": "arm", "token": "s3cret" }));
        if other.reply()["type"] == "armed" {
            break;
        }
        assert!(begun.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn without_control_a_token_does_not_help() {
    let fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.send(&json!({ "type": "arm", "token": "" }));
    assert!(
        client.reply()["text"]
            .as_str()
            .unwrap()
            .contains("--control")
    );
    // there is no other way to write
    let (head, _) = {
        let mut stream = TcpStream::connect(fixture.address()).unwrap();
        let request = format!(
            "POST /api/components HTTP/1.1\r\n{}Connection: close\r\nContent-Length: 2\r\n\r\n{{}}",
            fixture.host()
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        (head.to_owned(), body.to_owned())
    };
    assert!(head.starts_with("HTTP/1.1 405"), "{head}");
}

#[test]
fn a_message_that_is_too_large_ends_the_connection_and_no_other() {
    let mut fixture = Fixture::open(|_| {});
    let mut other = fixture.client();
    let mut client = fixture.client();
    let large = json!({ "type": "arm", "token": "x".repeat(65 * 1024) });
    // the server may close before it has read everything
    let _ = client.0.send(Message::text(large.to_string()));
    let code = loop {
        match client.0.read() {
            Ok(Message::Close(frame)) => break frame.map(|it| it.code),
            Ok(_) => {}
            Err(Error::Io(_) | Error::ConnectionClosed | Error::Protocol(_)) => break None,
            Err(error) => panic!("{error}"),
        }
    };
    assert!(matches!(code, Some(CloseCode::Size) | None), "{code:?}");
    other.subscribe(&["Driver.odom"]);
    fixture.publish(3);
    assert_eq!(
        other.frame_with("samples")["samples"]["Driver.odom"]["data"],
        3
    );
}

#[test]
fn a_thousand_connections_neither_stop_the_server_nor_those_that_are_open() {
    let mut fixture = Fixture::open(|settings| settings.max_connections = 16);
    let mut first = fixture.client();
    first.subscribe(&["Driver.odom"]);
    let mut open = Vec::new();
    let mut refused = 0;
    for _ in 0..1000 {
        match fixture.connect(None) {
            Ok(client) => open.push(client),
            Err(_) => refused += 1,
        }
    }
    assert_eq!((open.len(), refused), (15, 985));
    fixture.publish(1);
    assert_eq!(
        first.frame_with("samples")["samples"]["Driver.odom"]["data"],
        1
    );
    // connections that send nothing make room for one that does
    open.truncate(10);
    let begun = Instant::now();
    let idle: Vec<TcpStream> = (0..1000)
        .map(|_| TcpStream::connect(fixture.address()).unwrap())
        .collect();
    while fixture.status("/metrics", &fixture.host()) != "200" {
        assert!(begun.elapsed() < PATIENCE);
    }
    fixture.publish(2);
    assert_eq!(
        first.frame_with("samples")["samples"]["Driver.odom"]["data"],
        2
    );
    drop(idle);
}

#[test]
fn a_tab_that_is_frozen_does_not_see_the_past_as_the_present() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["Driver.odom", "log"]);
    fixture.publish(0);
    client.frame_with("samples");
    // it acknowledges nothing, while the system continues
    for value in 1..=10_000 {
        fixture.publish(value);
        fixture.report(&format!("entry {value}"));
        if value % 1000 == 0 {
            std::thread::sleep(Duration::from_millis(100));
        }
    }
    let mut frames = Vec::new();
    client
        .0
        .get_ref()
        .set_read_timeout(Some(Duration::from_millis(1500)))
        .unwrap();
    while let Ok(Message::Text(text)) = client.0.read() {
        frames.push(serde_json::from_str::<Value>(&text).unwrap());
    }
    // those of two intervals of 100 ms; the last one asks for an acknowledgement
    assert!(frames.len() <= 8, "{} frames were waiting", frames.len());
    assert_eq!(frames.last().unwrap()["ack"], true);
    client.0.get_ref().set_read_timeout(Some(PATIENCE)).unwrap();
    let last = frames.last().unwrap();
    client.send(&json!({ "type": "ack", "seq": last["seq"] }));
    let newest = client.frame_with("samples");
    assert_eq!(newest["samples"]["Driver.odom"]["data"], 10_000);
    let entries = newest["log"].as_array().unwrap();
    assert_eq!(entries.last().unwrap()["text"], "entry 10000");
    let seen: usize = frames
        .iter()
        .filter_map(|it| Some(it["log"].as_array()?.len()))
        .sum();
    let missed = newest["missed_log"].as_u64().unwrap();
    assert_eq!(seen as u64 + missed + entries.len() as u64, 10_000);
}

#[test]
fn a_tab_whose_socket_is_full_delays_nobody_and_receives_whole_messages() {
    let mut fixture = Fixture::open(|_| {});
    let (mut full, mut other) = (fixture.client(), fixture.client());
    full.subscribe(&["Driver.odom"]);
    other.subscribe(&["Driver.odom", "log"]);
    fixture.publish(1);
    for client in [&mut full, &mut other] {
        client.frame_with("samples");
    }
    // more than the buffers of a connection take
    let large = Datum::text("x".repeat(12 << 20));
    fixture.feed.observe(Time::ZERO, &published(&large));
    other.frame_with("samples");
    for value in 2..=20 {
        fixture.publish(value);
        fixture.report(&format!("entry {value}"));
        let log = other.frame_with("log")["log"].clone();
        assert!(log.to_string().contains(&format!("entry {value}")));
    }
    let begun = Instant::now();
    let mut lengths = Vec::new();
    loop {
        let frame = full.frame_with("samples");
        let data = &frame["samples"]["Driver.odom"]["data"];
        lengths.push(data.as_str().map_or(0, str::len));
        if *data == 20 {
            break;
        }
        assert!(begun.elapsed() < PATIENCE);
    }
    // nothing of what was published meanwhile waited behind the large sample
    assert!(matches!(lengths[..], [0] | [12_582_912, 0]), "{lengths:?}");
}

#[test]
fn subscriptions_are_limited_and_nonsense_is_answered() {
    let fixture = Fixture::open(|settings| settings.max_subscriptions = 2);
    let mut client = fixture.client();
    client.subscribe(&["log", "A.a", "A.b"]);
    client.subscribe(&["A.a", "A.b", "A.c"]);
    assert!(
        client.reply()["text"]
            .as_str()
            .unwrap()
            .contains("2 outputs")
    );
    for nonsense in [
        "",
        "[]",
        "{\"type\":\"launch\"}",
        "{\"type\":\"ack\",\"seq\":-1}",
    ] {
        client.0.send(Message::text(nonsense)).unwrap();
        assert!(
            client.reply()["text"]
                .as_str()
                .unwrap()
                .contains("not understood"),
            "{nonsense}"
        );
    }
    // a running system has no moments that a tab could ask for
    client.send(&json!({ "type": "seek", "t": 1.0, "span": 30.0, "window": true }));
    let reply = client.reply();
    assert!(reply["text"].as_str().unwrap().contains("runs"), "{reply}");
    // an acknowledgement of what was never sent opens no credit
    client.send(&json!({ "type": "ack", "seq": u64::MAX }));
    client.frame_with("seq");
}

#[test]
fn the_end_of_a_run_reaches_the_tab() {
    let fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["log"]);
    fixture.feed.end("reached");
    assert_eq!(client.frame_with("end")["end"], "reached");
    let begun = Instant::now();
    drop(fixture);
    assert!(
        begun.elapsed() < Duration::from_secs(2),
        "a tab delays the end of the run"
    );
}

#[test]
fn a_new_version_of_the_system_reaches_open_tabs() {
    let mut fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.subscribe(&["Driver.odom"]);
    fixture.publish(1);
    client.frame_with("samples");
    let mut version = SystemDescription::default();
    version.name = "second".to_owned();
    fixture.feed.follow(version);
    let greeting = client.reply();
    assert_eq!(
        (&greeting["type"], &greeting["system"]["name"]),
        (&json!("hello"), &json!("second"))
    );
    // the tab subscribes again, and receives what it knew
    client.subscribe(&["Driver.odom"]);
    let samples = client.frame_with("samples");
    assert_eq!(samples["samples"]["Driver.odom"]["data"], 1);
    let (_, system) = fixture.request("/api/system", &fixture.host());
    assert!(system.contains("\"second\""), "{system}");
}

#[test]
fn a_port_in_use_is_an_error_unless_another_one_will_do() {
    let first = Fixture::open(|_| {});
    let taken = first.address();
    let mut settings = DashboardSettings::at(taken);
    let source = || MonitorSource::new(SystemDescription::default(), None, Vec::new());
    let refused = Dashboard::open(settings.clone(), source()).unwrap_err();
    assert!(
        refused.to_string().contains(&taken.to_string()),
        "{refused}"
    );
    settings.or_free_port = true;
    let second = Dashboard::open(settings, source()).unwrap();
    assert_eq!(second.address().ip(), taken.ip());
    assert_ne!(second.address(), taken);
}

#[test]
fn every_response_forbids_the_page_to_load_from_elsewhere() {
    let fixture = Fixture::open(|_| {});
    for (path, headers) in [
        ("/", fixture.host()),
        ("/nothing", fixture.host()),
        ("/", String::new()),
    ] {
        let (head, _) = fixture.request(path, &headers);
        for part in [
            "content-security-policy: default-src 'self'",
            "frame-ancestors 'none'",
            "nosniff",
            "no-referrer",
        ] {
            assert!(head.contains(part), "{path}: {head}");
        }
        assert!(!head.contains("unsafe"), "{head}");
    }
}

#[test]
fn the_page_is_small_and_builds_nothing_from_text() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page");
    let fixture = Fixture::open(|_| {});
    let mut compressed = 0;
    let files = |folder: &std::path::Path| {
        let files = std::fs::read_dir(folder)
            .unwrap()
            .map(|it| it.unwrap().path());
        // how others' files are updated is no part of the page
        let served = files.filter(|path| path.is_file() && !path.ends_with("README.md"));
        served.collect::<Vec<_>>()
    };
    let own = files(&folder);
    for path in own.iter().chain(&files(&folder.join("vendor"))) {
        let name = path
            .strip_prefix(&folder)
            .unwrap()
            .to_str()
            .unwrap()
            .to_owned();
        let text = std::fs::read_to_string(path).unwrap();
        // a file without a row in the table would be missing in the program
        let (head, body) = fixture.request(&format!("/{name}"), &fixture.host());
        assert!(head.starts_with("HTTP/1.1 200") && body == text, "{name}");
        for forbidden in [
            "innerHTML",
            "outerHTML",
            "insertAdjacentHTML",
            "document.write",
            "eval(",
            "new Function",
            "setAttribute(\"style",
        ] {
            assert!(!text.contains(forbidden), "{name}: {forbidden}");
        }
        // comments of others name their sources
        assert!(!own.contains(path) || !text.contains("https://"), "{name}");
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(text.as_bytes()).unwrap();
        compressed += encoder.finish().unwrap().len();
    }
    assert!(compressed < 150_000, "{compressed} bytes");
    println!("{compressed} bytes compressed");
}

/// Contrast of two colours by WCAG, from 1 to 21.
fn contrast(one: &str, other: &str) -> f64 {
    let luminance = |colour: &str| {
        let part = |at: usize| {
            let share = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
            if share <= 0.040_45 {
                share / 12.92
            } else {
                ((share + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
    };
    let (one, other) = (luminance(one), luminance(other));
    (one.max(other) + 0.05) / (one.min(other) + 0.05)
}

#[test]
fn texts_can_be_read_in_both_themes() {
    let style = include_str!("../src/page/style.css");
    let themes: Vec<&str> = style
        .split(":root")
        .filter(|it| it.contains("--ground:"))
        .collect();
    // light, dark by preference, and dark by choice
    assert_eq!(themes.len(), 3);
    for theme in themes {
        let block = theme.split('}').next().unwrap();
        let colour = |name: &str| {
            let after = block.split(&format!("--{name}: ")).nth(1);
            let after = after.unwrap_or_else(|| panic!("no --{name} in {block}"));
            after[..7].to_owned()
        };
        for (text, ground) in [
            ("ink", "panel"),
            ("ink", "ground"),
            ("ink", "changed"),
            ("ink", "accent-soft"),
            ("faint", "panel"),
            ("faint", "sunken"),
            ("faint", "ground"),
            ("accent", "panel"),
            ("accent", "accent-soft"),
            ("good", "good-soft"),
            ("bad", "panel"),
            ("bad", "bad-soft"),
            ("note", "note-soft"),
            ("note", "panel"),
            ("on-accent", "accent"),
        ] {
            let found = contrast(&colour(text), &colour(ground));
            assert!(found >= 4.5, "{text} on {ground}: {found:.2}");
        }
    }
}

#[test]
fn vendored_files_are_those_of_their_version() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/page/vendor");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let version = "1.6.32";
    assert!(read("README.md").contains(version));
    assert!(read("uPlot.esm.js").contains(&format!("(v{version})")));
    assert!(read("LICENSE.uPlot").contains("Permission is hereby granted"));
}

#[test]
fn figures_are_exported_for_prometheus() {
    let mut fixture = Fixture::open(|_| {});
    fixture.feed.describe(presence());
    fixture.publish(1);
    let _tabs = [fixture.client(), fixture.client()];
    let (head, body) = fixture.request("/metrics", &fixture.host());
    assert!(head.contains("text/plain; version=0.0.4"), "{head}");
    for line in [
        "asmotion_component_cycles_total{component=\"A\\\"\\\\\\n\"} 7",
        "asmotion_component_running{component=\"A\\\"\\\\\\n\"} 1",
        "asmotion_component_overruns_total{component=\"A\\\"\\\\\\n\"} 2",
        "asmotion_component_cycle_mean_seconds{component=\"A\\\"\\\\\\n\"} 0.0005",
        "asmotion_output_samples_total{component=\"Driver\",port=\"odom\"} 1",
        "asmotion_link_up{link=\"broker \\\"1\\\"\"} 1",
        "asmotion_dashboard_tabs 2",
        "asmotion_dashboard_viewers 0",
        "asmotion_output_stale{component=\"Driver\",port=\"odom\"} 0",
    ] {
        assert!(body.lines().any(|it| it == line), "{line}\n{body}");
    }
    // each metric has its type once, before its values
    let types: Vec<&str> = body.lines().filter(|it| it.starts_with("# TYPE")).collect();
    let mut unique = types.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), types.len());
}

fn presence() -> asmotion_remote::Presence {
    asmotion_remote::Presence {
        components: vec![asmotion_remote::PresentComponent {
            name: "A\"\\\n".to_owned(),
            state: "Running".to_owned(),
            cycles: 7,
            overruns: 2,
            cycle_mean_ms: 0.5,
            ..Default::default()
        }],
        ..Default::default()
    }
}
