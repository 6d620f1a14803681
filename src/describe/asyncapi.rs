//! AsyncAPI 3.0.0 document of a description, following `docs/wire.md`.

use std::collections::BTreeSet;

use asmotion_datum::Schema;
use asmotion_datum::json_schema::{SchemaDefinitions, key};
use asmotion_plan::{Broker, Plan};
use asmotion_remote::{control_address, presence_topic};
use serde_json::{Map, Value, json};

use super::envelope::{headers, refusals};
use super::{Channel, Description, ServedOperation};

/// Topic exchange, if the composite names no broker.
const EXCHANGE: &str = "robots";
/// Location of the message schemas in the document.
const SCHEMAS: &str = "#/components/schemas";
/// Version of the AMQP bindings.
pub(super) const BINDING: &str = "0.3.0";

/// Returns the document for a robot of this name.
pub fn document(description: &Description<'_>, robot: &str) -> Value {
    let plan = description.plan;
    let mut document = Document {
        robot,
        plan,
        channels: Map::new(),
        operations: Map::new(),
        messages: Map::new(),
        schemas: SchemaDefinitions::at(SCHEMAS),
    };
    for topic in &description.topics {
        document.topic(topic);
    }
    for served in &description.operations {
        document.service(served);
        document.promoted(served);
    }
    let mut processes: BTreeSet<&str> = plan.processes.iter().map(|it| it.name.as_str()).collect();
    processes.insert(&plan.name);
    document.processes(&processes.into_iter().collect::<Vec<_>>());
    document.finish(description)
}

/// Brokers with a known address, without credentials.
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
    plan: &'a Plan,
    channels: Map<String, Value>,
    operations: Map<String, Value>,
    messages: Map<String, Value>,
    schemas: SchemaDefinitions,
}

impl Document<'_> {
    fn topic(&mut self, topic: &Channel) {
        let message = self.publication(&topic.message);
        let channel = topic.name.as_str();
        let mut ends = topic.publishers.iter().chain(&topic.subscribers);
        let exchange = self.exchange(ends.find_map(|end| self.plan.broker_of(&end.component)));
        self.channels.insert(
            channel.to_owned(),
            json!({
                "address": format!("{}.{channel}", self.robot),
                "messages": { &message: message_reference(&message) },
                "bindings": binding(&exchange, "topic"),
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

    /// Exchange of a broker.
    fn exchange(&self, broker: Option<&str>) -> String {
        let mut brokers = self.plan.brokers.iter();
        let broker = brokers.find(|it| Some(&*it.name) == broker);
        broker.map_or(EXCHANGE, |it| &it.exchange).to_owned()
    }

    /// Adds an operation under the promoted names of its service.
    fn promoted(&mut self, served: &ServedOperation) {
        for (name, broker) in self.plan.promoted_over_brokers(&served.service) {
            let address = format!("{name}.{}", served.operation.name);
            let request = self.channel_of(served, &address, broker);
            let serves = self.operation("receive", served, &address, &request);
            self.operations.insert(address, serves);
        }
    }

    /// Adds the channel of an operation at an address; returns the key of the request.
    fn channel_of(
        &mut self,
        served: &ServedOperation,
        address: &str,
        broker: Option<&str>,
    ) -> String {
        let request = self.request_message(&served.operation.request);
        let exchange = format!("{}.services", self.exchange(broker));
        self.channels.insert(
            address.to_owned(),
            json!({
                "address": format!("{}.{address}", self.robot),
                "description": format!("Operation `{}` of `{}`.", served.operation.name, served.interface),
                "messages": { &request: message_reference(&request) },
                "bindings": binding(&exchange, "direct"),
            }),
        );
        request
    }

    /// Adds an operation at an address.
    fn operation(
        &mut self,
        action: &str,
        served: &ServedOperation,
        address: &str,
        request: &str,
    ) -> Value {
        let component = &served.service.component;
        let mut operation = json!({
            "action": action,
            "channel": channel_reference(address),
            "messages": [message_of(address, request)],
            "tags": [{ "name": component }],
        });
        if !served.one_way {
            operation["reply"] = self.reply(served);
        }
        operation
    }

    fn service(&mut self, served: &ServedOperation) {
        let address = served.address();
        let broker = self.plan.broker_of(&served.service.component);
        let request = self.channel_of(served, &address, broker);
        let serves = self.operation("receive", served, &address, &request);
        self.operations.insert(address.clone(), serves);
        for caller in &served.callers {
            let mut calls = self.operation("send", served, &address, &request);
            calls["tags"] = json!([{ "name": caller.reference.component }]);
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

    /// Adds the channel of the operation's replies; returns the `reply` object.
    fn reply(&mut self, served: &ServedOperation) -> Value {
        let replies = format!("{}.reply", served.address());
        let result = self.reply_message(&served.operation.response);
        let answers = [result.as_str(), "refusal", "unavailable"];
        let listed: Map<String, Value> = answers
            .iter()
            .map(|answer| ((*answer).to_owned(), message_reference(answer)))
            .collect();
        self.channels.insert(
            replies.clone(),
            json!({
                "address": null,
                "description": "The queue named by the AMQP property `reply_to` of the request.",
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

    /// Adds the presence and control channels of every process.
    fn processes(&mut self, names: &[&str]) {
        let parameter = json!({ "process": {
            "description": "Name of the process; that of the composite if one process runs all of it.",
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
            word("presence", "State of a process, published once a second: its components with their ports, services, \
                properties, states and rates; `leaves` is set in its last message."),
            word("order", "Order to a process: start or stop a component, or set its properties."),
        ]);
        let exchange = match &*self.plan.brokers {
            [only] => &only.exchange,
            _ => EXCHANGE,
        };
        let channels = [
            (
                "presence",
                presence_topic("{process}"),
                "presence",
                binding(exchange, "topic"),
            ),
            (
                "control",
                control_address("{process}"),
                "order",
                binding(&format!("{exchange}.services"), "direct"),
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

    /// Adds the message of a topic; returns its key.
    fn publication(&mut self, schema: &Schema) -> String {
        self.message("", schema, &schema.to_string(), "topicHeaders")
    }

    fn request_message(&mut self, schema: &Schema) -> String {
        self.message("request.", schema, "request", "requestHeaders")
    }

    fn reply_message(&mut self, schema: &Schema) -> String {
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

/// AMQP binding of a routing-key channel. Exchanges are durable.
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

/// Reference to a message of a channel, as operations use it.
fn message_of(channel: &str, message: &str) -> Value {
    json!({ "$ref": format!("#/channels/{}/messages/{message}", pointer(channel)) })
}

/// Escapes a name for use in a JSON pointer.
fn pointer(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}
