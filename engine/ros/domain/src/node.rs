//! A node of Cyclone DDS that does what a test says.

use std::collections::VecDeque;
use std::path::Path;
use std::time::{Duration, Instant};

use asmotion_datum::{Codec, Datum, Schema};
use asmotion_ros_interface::InterfaceName;
use serde_json::{Value, json};

use crate::action::{action_kinds, service_kinds};
use crate::peer::{LONG, Peer, catalogue, hex};

/// A node of ROS whose DDS is Cyclone: it publishes its name in the graph.
pub struct CycloneNode {
    peer: Peer,
    /// Messages that were not awaited yet: topic and content in CDR.
    unread: VecDeque<(String, String)>,
    kinds: Vec<(String, Schema)>,
    /// Services of which there are clients, with the schemas of request and response.
    services: Vec<(String, Vec<Schema>)>,
}

fn read(schema: &Schema, digits: &str) -> Value {
    let pair = |at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap();
    let bytes: Vec<u8> = (0..digits.len()).step_by(2).map(pair).collect();
    let datum: Datum = Codec::Cdr.decode(&bytes, schema).unwrap();
    serde_json::from_str(&asmotion_datum::json::encode(&datum).unwrap()).unwrap()
}

/// The quality of service of a topic of a [`CycloneNode`]: reliable, volatile, depth 10 by default.
#[derive(Clone, Copy, Debug)]
pub struct TopicPolicies {
    /// Lost messages are sent again.
    pub is_reliable: bool,
    /// Late subscribers get the last messages.
    pub is_transient: bool,
    /// Messages that are kept.
    pub depth: usize,
    /// Longest time between two messages.
    pub deadline: Option<Duration>,
}

impl Default for TopicPolicies {
    fn default() -> Self {
        Self {
            is_reliable: true,
            is_transient: false,
            depth: 10,
            deadline: None,
        }
    }
}

impl TopicPolicies {
    /// Best effort, as drivers of sensors have it.
    pub fn best_effort() -> Self {
        Self {
            is_reliable: false,
            ..Self::default()
        }
    }

    /// Transient local with a depth.
    pub fn latched(depth: usize) -> Self {
        Self {
            is_transient: true,
            depth,
            ..Self::default()
        }
    }

    fn json(self) -> Value {
        json!({
            "reliable": self.is_reliable, "transient": self.is_transient, "depth": self.depth,
            "deadline": self.deadline.map(|it| it.as_secs_f64()),
        })
    }
}

impl CycloneNode {
    /// Starts a node with this name, in the root namespace.
    ///
    /// # Panics
    /// It cannot be started.
    pub fn start(python: &Path, domain: u16, name: &str) -> Self {
        let node = Self {
            peer: Peer::start(python, "obey", &json!({ "domain": domain, "name": name })),
            unread: VecDeque::new(),
            kinds: Vec::new(),
            services: Vec::new(),
        };
        node.peer.expect("ready");
        node
    }

    /// Gives a command to the node, and waits until it is done.
    ///
    /// # Panics
    /// The node does not answer soon.
    pub fn obey(&mut self, command: &Value) {
        self.peer.tell(&command.to_string());
        loop {
            let line = self.peer.line();
            if line == "done" {
                return;
            }
            self.keep(&line);
        }
    }

    /// Subscribes to a topic.
    pub fn subscribe(&mut self, topic: &str, kind: &str, policies: TopicPolicies) {
        self.open("subscribe", topic, kind, policies);
    }

    /// Announces a topic, which is published later, and waits until so many subscribers match.
    pub fn advertise(&mut self, topic: &str, kind: &str, policies: TopicPolicies, matches: usize) {
        self.open("advertise", topic, kind, policies);
        self.await_subscribers(topic, matches);
    }

    /// Waits until so many subscribers match a topic that is announced.
    pub fn await_subscribers(&mut self, topic: &str, matches: usize) {
        self.obey(&json!(["subscribers", topic, matches]));
    }

    /// Waits until so many publishers match a topic that is subscribed to.
    pub fn await_publishers(&mut self, topic: &str, matches: usize) {
        self.obey(&json!(["publishers", topic, matches]));
    }

    fn open(&mut self, verb: &str, topic: &str, kind: &str, policies: TopicPolicies) {
        let name: InterfaceName = kind.parse().unwrap();
        let schema = catalogue().schema(&name).unwrap();
        let type_name = format!("{}::msg::dds_::{}_", name.package(), name.name());
        let policies = policies.json();
        self.obey(&json!([verb, topic, type_name, &schema, policies]));
        self.kinds.push((topic.to_owned(), schema));
    }

    /// Creates a client of a service, and waits until a server matches.
    pub fn client(&mut self, service: &str, of: &str) {
        let [request, response] = service_kinds(of);
        self.obey(&json!(["client", service, request, response]));
        let schemas = catalogue().schemas(&of.parse().unwrap()).unwrap();
        self.services.push((service.to_owned(), schemas));
    }

    /// Calls a service of which there is a client, and waits for the response.
    ///
    /// # Panics
    /// There is no response soon.
    pub fn call(&mut self, service: &str, request: &Value) -> Value {
        let known = self.services.iter().find(|(name, _)| name == service);
        let schemas = known.expect("a client").1.clone();
        let datum = Codec::Json.decode(request.to_string().as_bytes(), &schemas[0]);
        let complete = schemas[0].complete(datum.unwrap()).unwrap();
        let bytes = Codec::Cdr.encode(&complete, &schemas[0]).unwrap();
        self.obey(&json!(["call", service, hex(&bytes)]));
        let answer = self.unread.iter().position(|(of, _)| of == "answer");
        let (_, digits) = self.unread.remove(answer.expect("an answer")).unwrap();
        read(&schemas[1], &digits)
    }

    /// Creates a client of an action, and waits until a server matches.
    pub fn action_client(&mut self, action: &str, of: &str) {
        let (kinds, _) = action_kinds(of);
        self.obey(&json!(["actor", action, kinds]));
        let schemas = catalogue().schemas(&of.parse().unwrap()).unwrap();
        let parts = ["goal", "result", "feedback"].map(|part| format!("{action}/{part}"));
        self.kinds.extend(parts.into_iter().zip(schemas));
    }

    /// Sends a goal to an action of which there is a client. Feedback and result are messages of `ACTION/feedback` and
    /// `ACTION/result`.
    pub fn send_goal(&mut self, action: &str, goal: &Value) {
        let schema = self.schema(&format!("{action}/goal")).clone();
        let datum = Codec::Json.decode(goal.to_string().as_bytes(), &schema);
        let complete = schema.complete(datum.unwrap()).unwrap();
        let bytes = Codec::Cdr.encode(&complete, &schema).unwrap();
        self.obey(&json!(["goal", action, hex(&bytes)]));
    }

    /// Cancels the goal of an action.
    pub fn cancel_goal(&mut self, action: &str) {
        self.obey(&json!(["cancel", action]));
    }

    /// The next number of an action: `accepted` (0 or 1), `cancelling` (number of goals) or `status` (of the end).
    ///
    /// # Panics
    /// There is none soon.
    pub fn goal_number(&mut self, action: &str, of: &str) -> u8 {
        let name = format!("{action}/{of}");
        let digits = self.take_digits(&name, LONG);
        let digits = digits.unwrap_or_else(|| panic!("no {name}"));
        u8::from_str_radix(&digits, 16).unwrap()
    }

    fn schema(&self, topic: &str) -> &Schema {
        let mut kinds = self.kinds.iter();
        &kinds.find(|(name, _)| name == topic).expect("a topic").1
    }

    /// The hexadecimal digits of a message in CDR.
    fn digits(&self, topic: &str, message: &Value) -> String {
        let schema = self.schema(topic);
        let datum = Codec::Json.decode(message.to_string().as_bytes(), schema);
        hex(&Codec::Cdr.encode(&datum.unwrap(), schema).unwrap())
    }

    /// Publishes a message.
    pub fn publish(&mut self, topic: &str, message: &Value) {
        let digits = self.digits(topic, message);
        self.obey(&json!(["publish", topic, digits]));
    }

    /// Publishes messages one after the other, as fast as possible.
    pub fn publish_all(&mut self, topic: &str, messages: &[Value]) {
        let messages = messages.iter().map(|it| self.digits(topic, it));
        let messages: Vec<_> = messages.collect();
        self.obey(&json!(["burst", topic, messages]));
    }

    /// Publishes a message for ever, so many times in a second, and counts from `first` in the field at `path`.
    pub fn stream(&mut self, topic: &str, message: &Value, (path, first): (&str, u64), rate: u32) {
        let digits = self.digits(topic, message);
        self.obey(&json!(["stream", topic, digits, path, first, rate]));
    }

    /// The next message of a topic. Messages of other topics are kept.
    ///
    /// # Panics
    /// There is none soon.
    pub fn message(&mut self, topic: &str) -> Value {
        let found = self.try_message(topic, LONG);
        found.unwrap_or_else(|| panic!("no message of {topic}"))
    }

    /// The next message of a topic within a time.
    pub fn try_message(&mut self, topic: &str, within: Duration) -> Option<Value> {
        let digits = self.take_digits(topic, within)?;
        Some(read(self.schema(topic), &digits))
    }

    fn take_digits(&mut self, topic: &str, within: Duration) -> Option<String> {
        let end = Instant::now() + within;
        loop {
            if let Some(at) = self.unread.iter().position(|(of, _)| of == topic) {
                return Some(self.unread.remove(at)?.1);
            }
            let left = end.checked_duration_since(Instant::now())?;
            for line in self.peer.lines_for(left.min(Duration::from_millis(20))) {
                self.keep(&line);
            }
        }
    }

    fn keep(&mut self, line: &str) {
        let (topic, digits) = line.split_once(' ').expect("a message");
        self.unread.push_back((topic.to_owned(), digits.to_owned()));
    }

    /// Takes no messages of a topic from DDS until they are released.
    pub fn hold(&mut self, topic: &str) {
        self.obey(&json!(["hold", topic]));
    }

    /// Takes messages of a topic again.
    pub fn release(&mut self, topic: &str) {
        self.obey(&json!(["release", topic]));
    }

    /// Stops the process, so that it reads nothing.
    pub fn pause(&self) {
        self.peer.signal("STOP");
    }

    /// Lets a stopped process go on.
    pub fn go_on(&self) {
        self.peer.signal("CONT");
    }

    /// Ends the node without a farewell.
    pub fn kill(self) {
        self.peer.kill();
    }
}
