//! The server of the dashboard, as clients of all kinds see it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod access;
mod commands;
mod content;
mod login;
mod page;

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_bus::{Bus, LocalBus, Notifier, Payload, Refusal};
use asmotion_component::Time;
use asmotion_datum::{Datum, Sample};
use asmotion_monitor::{
    BusLink, Dashboard, DashboardSettings, Feed, MonitorSource, OrderBus, SystemDescription,
};
use asmotion_runtime::{Event, Observer};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::{Message, WebSocket};

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
            warning: Some("its login is `guest`".to_owned()),
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
        self.send("GET", path, headers)
    }

    /// Sends a request with this method, these headers and no content.
    fn send(&self, method: &str, path: &str, headers: &str) -> (String, String) {
        let mut stream = TcpStream::connect(self.address()).unwrap();
        let request = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n");
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
        self.connect_with(origin, None)
    }

    /// Opens a WebSocket, with this `Origin` and this `Cookie` if there are any.
    fn connect_with(&self, origin: Option<&str>, cookie: Option<&str>) -> Result<Client, String> {
        let stream = TcpStream::connect(self.address()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let url = format!("ws://{}/live", self.address());
        let mut request = url.into_client_request().unwrap();
        for (name, value) in [("Origin", origin), ("Cookie", cookie)] {
            if let Some(value) = value {
                let value = HeaderValue::from_str(value).unwrap();
                request.headers_mut().insert(name, value);
            }
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
                    // what the component refuses
                    let is_bad = order.get("component").unwrap().as_text() == Some("Refusing");
                    call.reply(if is_bad {
                        Err(Refusal {
                            code: "REFUSED".to_owned(),
                            detail: "not now".to_owned(),
                        })
                    } else {
                        Ok(Payload::of(Datum::Null))
                    });
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
