//! A description as an AsyncAPI 3.0.0 document: `docs/wire.md`, filled in for one composite.

use std::collections::BTreeSet;

use assembly::Plan;
use assembly::plan::Broker;
use datum::Schema;
use remote::{control_address, presence_topic};
use serde_json::{Map, Value, json};

use super::schema::{Definitions, key};
use super::{Channel, Description, Served};

/// The topic exchange; that of services is named after it.
const EXCHANGE: &str = "robots";
/// Which version of the AMQP bindings.
const BINDING: &str = "0.3.0";

/// The document. Topics and addresses are those of this robot.
pub fn document(description: &Description<'_>, robot: &str) -> Value {
    let mut document = Document {
        robot,
        channels: Map::new(),
        operations: Map::new(),
        messages: Map::new(),
        schemas: Definitions::default(),
    };
    for topic in &description.topics {
        document.topic(topic);
    }
    for served in &description.operations {
        document.service(served);
    }
    let mut processes: BTreeSet<&str> = (description.plan.processes.iter())
        .map(|it| it.name.as_str())
        .collect();
    processes.insert(&description.plan.name);
    document.processes(&processes.into_iter().collect::<Vec<_>>());
    document.finish(description)
}

/// The brokers of a composite whose addresses are known, without who goes there.
fn servers(plan: &Plan) -> Map<String, Value> {
    let server = |broker: &Broker| {
        let (protocol, rest) = broker.url.as_ref()?.shown().split_once("://")?;
        let (place, vhost) = rest.split_once('/').unwrap_or((rest, ""));
        let host = place.rsplit_once('@').map_or(place, |(_, host)| host);
        let mut server = json!({ "host": host, "protocol": protocol, "protocolVersion": "0.9.1" });
        if !vhost.is_empty() {
            server["pathname"] = format!("/{vhost}").into();
        }
        Some((key(&broker.name), server))
    };
    plan.brokers.iter().filter_map(server).collect()
}

struct Document<'a> {
    robot: &'a str,
    channels: Map<String, Value>,
    operations: Map<String, Value>,
    messages: Map<String, Value>,
    schemas: Definitions,
}

impl Document<'_> {
    fn topic(&mut self, topic: &Channel) {
        let message = self.publication(&topic.message);
        let channel = topic.name.as_str();
        self.channels.insert(
            channel.to_owned(),
            json!({
                "address": format!("{}.{channel}", self.robot),
                "messages": { &message: message_reference(&message) },
                "bindings": binding(EXCHANGE, "topic"),
            }),
        );
        for (action, ends) in [("send", &topic.publishers), ("receive", &topic.subscribers)] {
            for end in ends {
                self.operations.insert(
                    format!("{end}.{action}.{channel}"),
                    json!({
                        "action": action,
                        "channel": channel_reference(channel),
                        "messages": [message_of(channel, &message)],
                        "tags": [{ "name": end.component }],
                    }),
                );
            }
        }
    }

    fn service(&mut self, served: &Served) {
        let address = served.address();
        let request = self.asked(&served.operation.request);
        self.channels.insert(
            address.clone(),
            json!({
                "address": format!("{}.{address}", self.robot),
                "description": format!("Operation `{}` of `{}`.", served.operation.name, served.interface),
                "messages": { &request: message_reference(&request) },
                "bindings": binding(&format!("{EXCHANGE}.services"), "direct"),
            }),
        );
        let reply = (!served.one_way).then(|| self.reply(served));
        let operation = |action: &str, component: &str| {
            let mut operation = json!({
                "action": action,
                "channel": channel_reference(&address),
                "messages": [message_of(&address, &request)],
                "tags": [{ "name": component }],
            });
            if let Some(reply) = &reply {
                operation["reply"] = reply.clone();
            }
            operation
        };
        let serves = operation("receive", &served.service.component);
        self.operations.insert(address.clone(), serves);
        for caller in &served.callers {
            let mut calls = operation("send", &caller.reference.component);
            calls["bindings"] = json!({ "amqp": {
                "expiration": caller.timeout_ms, "mandatory": true, "bindingVersion": BINDING,
            } });
            if caller.one_way
                && let Value::Object(members) = &mut calls
            {
                members.remove("reply");
            }
            let name = format!(
                "{}.{} calls {address}",
                caller.reference, served.operation.name
            );
            self.operations.insert(key(&name), calls);
        }
    }

    /// The channel of an operation's replies, and what operations say of it.
    fn reply(&mut self, served: &Served) -> Value {
        let replies = format!("{}.reply", served.address());
        let result = self.answered(&served.operation.response);
        let answers = [result.as_str(), "refusal", "unavailable"];
        let listed: Map<String, Value> = answers
            .iter()
            .map(|answer| ((*answer).to_owned(), message_reference(answer)))
            .collect();
        self.channels.insert(
            replies.clone(),
            json!({
                "address": null,
                "description": "Whatever queue the request names in the AMQP property `reply_to`.",
                "messages": listed,
                "bindings": binding("", "default"),
            }),
        );
        json!({
            "address": { "location": "$message.header#/reply_to" },
            "channel": channel_reference(&replies),
            "messages": answers.map(|answer| message_of(&replies, answer)),
        })
    }

    /// What every process tells of itself, and where it takes orders.
    fn processes(&mut self, names: &[&str]) {
        let parameter = json!({ "process": {
            "description": "the name of the process; of one that runs the whole composite, the composite's",
            "enum": names,
        } });
        let word = |name: &str, doc: &str| {
            let payload = json!({ "type": "object" });
            (
                name.to_owned(),
                json!({ "name": name, "description": doc, "contentType": "application/json", "payload": payload }),
            )
        };
        self.messages.extend([
            word("presence", "What a process says of itself, once a second: its components with their ports, services, \
                properties, states and rates; `leaves` in its last word."),
            word("order", "What a process is to do: start or stop a component, or set its properties."),
        ]);
        let channels = [
            (
                "presence",
                presence_topic("{process}"),
                "presence",
                binding(EXCHANGE, "topic"),
            ),
            (
                "control",
                control_address("{process}"),
                "order",
                binding(&format!("{EXCHANGE}.services"), "direct"),
            ),
        ];
        for (channel, address, message, binding) in channels {
            self.channels.insert(
                channel.to_owned(),
                json!({
                    "address": format!("{}.{address}", self.robot),
                    "parameters": parameter,
                    "messages": { message: message_reference(message) },
                    "bindings": binding,
                }),
            );
            let action = if channel == "presence" {
                "send"
            } else {
                "receive"
            };
            self.operations.insert(
                format!("process.{channel}"),
                json!({
                    "action": action,
                    "channel": channel_reference(channel),
                    "messages": [message_of(channel, message)],
                }),
            );
        }
    }

    /// A message of a topic; its key.
    fn publication(&mut self, schema: &Schema) -> String {
        self.message("", schema, &schema.to_string(), "topicHeaders")
    }

    fn asked(&mut self, schema: &Schema) -> String {
        self.message("request.", schema, "request", "requestHeaders")
    }

    fn answered(&mut self, schema: &Schema) -> String {
        self.message("result.", schema, "result", "resultHeaders")
    }

    fn message(&mut self, prefix: &str, schema: &Schema, kind: &str, headers: &str) -> String {
        let key = format!("{prefix}{}", key(&schema.to_string()));
        let payload = self.schemas.schema(schema);
        let message = json!({
            "name": schema.to_string(),
            "headers": { "$ref": format!("#/components/schemas/{headers}") },
            "payload": payload,
            "bindings": { "amqp": { "messageType": kind, "bindingVersion": BINDING } },
        });
        self.messages.insert(key.clone(), message);
        key
    }

    fn finish(mut self, description: &Description<'_>) -> Value {
        let plan = description.plan;
        if !description.operations.is_empty() {
            self.messages.extend(refusals());
        }
        let mut schemas = self.schemas.into_value();
        for (name, headers) in headers() {
            schemas[name] = headers;
        }
        let mut info = json!({
            "title": plan.name,
            "version": plan.version.as_deref().unwrap_or("0.0.0"),
        });
        if let Some(doc) = &description.doc {
            info["description"] = doc.as_str().into();
        }
        let mut document = json!({
            "asyncapi": "3.0.0",
            "info": info,
            "defaultContentType": "application/cbor",
            "channels": self.channels,
            "operations": self.operations,
            "components": { "messages": self.messages, "schemas": schemas },
        });
        let servers = servers(plan);
        if !servers.is_empty() {
            document["servers"] = servers.into();
        }
        document
    }
}

/// Answers that all services have: the words of a fault, or nothing.
fn refusals() -> [(String, Value); 2] {
    let answer = |kind: &str, more: Value| {
        let mut message = json!({
            "name": kind,
            "headers": { "$ref": format!("#/components/schemas/{kind}Headers") },
            "bindings": { "amqp": { "messageType": kind, "bindingVersion": BINDING } },
        });
        if let (Value::Object(message), Value::Object(more)) = (&mut message, more) {
            message.extend(more);
        }
        (kind.to_owned(), message)
    };
    let words = json!({ "type": "string", "description": "the words of a fault" });
    [
        answer(
            "refusal",
            json!({ "contentType": "text/plain", "payload": words }),
        ),
        answer(
            "unavailable",
            json!({ "description": "Nobody is there to answer, or the request is not known; without content." }),
        ),
    ]
}

/// The headers of `docs/wire.md`.
fn headers() -> [(&'static str, Value); 5] {
    let text = |doc: &str| json!({ "type": "string", "description": doc });
    let whole = |doc: &str| json!({ "type": "integer", "description": doc });
    let source = text("the component that sent it");
    let incarnation = whole("which life of its process; grows with every restart");
    [
        (
            "topicHeaders",
            json!({ "type": "object", "properties": {
                "source": source,
                "incarnation": incarnation,
                "sequence": whole("its number among this publisher's messages, from 1 without gaps"),
                "stamp": whole("when it was sent, in nanoseconds"),
                "clock": text("of which clock: `wall:rover1`"),
                "traceparent": text("the trace it belongs to, as W3C writes it"),
            } }),
        ),
        (
            "requestHeaders",
            json!({ "type": "object", "required": ["timeout"], "properties": {
                "source": source,
                "incarnation": incarnation,
                "timeout": whole("how many nanoseconds the caller gives it"),
                "deadline": whole("when the caller gives up, in nanoseconds of Unix time"),
                "callback": text("the address where the caller serves what comes later"),
            } }),
        ),
        ("resultHeaders", json!({ "type": "object" })),
        (
            "refusalHeaders",
            json!({ "type": "object", "properties": { "code": text("the code of the fault") } }),
        ),
        ("unavailableHeaders", json!({ "type": "object" })),
    ]
}

/// A channel of an exchange, by routing key. Exchanges are durable.
fn binding(exchange: &str, kind: &str) -> Value {
    json!({ "amqp": {
        "is": "routingKey",
        "exchange": { "name": exchange, "type": kind, "durable": true },
        "bindingVersion": BINDING,
    } })
}

fn channel_reference(channel: &str) -> Value {
    json!({ "$ref": format!("#/channels/{}", pointer(channel)) })
}

fn message_reference(message: &str) -> Value {
    json!({ "$ref": format!("#/components/messages/{message}") })
}

/// A message of a channel, which is what operations name.
fn message_of(channel: &str, message: &str) -> Value {
    json!({ "$ref": format!("#/channels/{}/messages/{message}", pointer(channel)) })
}

/// A name as a step of a JSON pointer.
fn pointer(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}
