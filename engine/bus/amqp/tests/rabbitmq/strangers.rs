//! Another AMQP user that reads everything, may publish, and reuses the ids of others.

use std::sync::Arc;
use std::time::Duration;

use amqprs::channel::{
    BasicConsumeArguments, BasicPublishArguments, Channel, ConsumerMessage, QueueBindArguments,
    QueueDeclareArguments,
};
use amqprs::connection::{Connection, OpenConnectionArguments};
use amqprs::{BasicProperties, FieldTable, FieldValue};
use asmotion_amqp::BusNotice;
use asmotion_broker::{TestBroker, Vhost};
use asmotion_bus::{Bus, Notifier, Request, SenderId};
use tokio::runtime::Runtime;
use tokio::sync::mpsc::UnboundedReceiver;

use crate::common::{
    LONG, all, connect, events, noted, number, numbers, publisher, settings, subscribe,
};

/// The stranger's name and password.
const NAME: &str = "stranger";

struct Stranger {
    runtime: Runtime,
    /// `None` once dropped.
    session: Option<(Connection, Channel)>,
    copies: UnboundedReceiver<ConsumerMessage>,
}

impl Stranger {
    /// Logs in, and takes a copy of every message with this key.
    fn listen(broker: &TestBroker, vhost: &Vhost<'_>, exchange: &str, key: &str) -> Self {
        // another test may have created the user
        let _ = broker.add_user(NAME, NAME);
        vhost.permit(NAME, ".*", ".*", ".*").unwrap();
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .unwrap();
        let port = broker.address().port();
        let mut arguments = OpenConnectionArguments::new("127.0.0.1", port, NAME, NAME);
        arguments.virtual_host(vhost.name());
        let (connection, channel, copies) = runtime.block_on(async {
            let connection = Connection::open(&arguments).await.unwrap();
            let channel = connection.open_channel(None).await.unwrap();
            let queue = QueueDeclareArguments::new(NAME);
            channel.queue_declare(queue).await.unwrap();
            let binding = QueueBindArguments::new(NAME, exchange, key);
            channel.queue_bind(binding).await.unwrap();
            let mut consume = BasicConsumeArguments::new(NAME, "");
            consume.auto_ack(true);
            let (_, copies) = channel.basic_consume_rx(consume).await.unwrap();
            (connection, channel, copies)
        });
        Self {
            runtime,
            session: Some((connection, channel)),
            copies,
        }
    }

    /// The next message of another user.
    fn overhear(&mut self) -> (BasicProperties, Vec<u8>) {
        loop {
            let next = async { tokio::time::timeout(LONG, self.copies.recv()).await };
            let message = self.runtime.block_on(next).unwrap().unwrap();
            let properties = message.basic_properties.unwrap();
            if properties.user_id().is_none_or(|user| user != NAME) {
                return (properties, message.content.unwrap());
            }
        }
    }

    /// Publishes in its own name, which the broker verifies, or without one.
    fn publish(
        &self,
        (exchange, key): (&str, &str),
        mut properties: BasicProperties,
        bytes: &[u8],
        is_named: bool,
    ) {
        if is_named {
            properties.with_user_id(NAME);
        }
        let arguments = BasicPublishArguments::new(exchange, key);
        let (_, channel) = self.session.as_ref().unwrap();
        let sending = channel.basic_publish(properties, bytes.to_vec(), arguments);
        self.runtime.block_on(sending).unwrap();
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        // the client closes its connection with a task
        let _context = self.runtime.enter();
        self.session = None;
    }
}

/// The properties of a number with this id, without a user.
fn forged(stream: &str, sequence: u64) -> BasicProperties {
    let mut headers = FieldTable::new();
    let count = FieldValue::l(i64::try_from(sequence).unwrap());
    headers.insert("sequence".try_into().unwrap(), count);
    BasicProperties::default()
        .with_content_type("application/json")
        .with_message_id(&format!("{stream}-{sequence}"))
        .with_headers(headers)
        .finish()
}

#[test]
fn ids_of_another_user_hide_no_message() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let subscription = subscribe(&bus, "stop", all(100));
    let mut publisher = publisher(&bus, "stop", events());
    let mut stranger = Stranger::listen(&broker, &vhost, "robots", "stop");
    publisher.publish(0, number(1)).unwrap();
    let (properties, _) = stranger.overhear();
    let id = properties.message_id().unwrap();
    let (stream, sequence) = id.rsplit_once('-').unwrap();
    let next = sequence.parse::<u64>().unwrap() + 1;
    // the ids of the messages to come, and one far beyond
    for is_named in [true, false] {
        for sequence in [next, next + 1, 1 << 62] {
            let properties = forged(stream, sequence);
            stranger.publish(("robots", "stop"), properties, b"-1", is_named);
        }
    }
    let silence = Duration::from_millis(500);
    assert_eq!(numbers(&subscription, silence), [1, -1, -1, -1, -1, -1, -1]);
    for n in 2..5 {
        publisher.publish(0, number(n)).unwrap();
    }
    assert_eq!(numbers(&subscription, silence), [2, 3, 4]);
    assert_eq!(subscription.counts().duplicates, 0);
    let notices = notices.lock().unwrap();
    let jumps = |notice: &&BusNotice| matches!(notice, BusNotice::SequenceJump { user, .. } if user == NAME);
    assert_eq!(notices.iter().filter(jumps).count(), 1, "{notices:?}");
}

#[test]
fn another_user_can_neither_claim_nor_cancel_a_request() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let here = connect(settings(&vhost.url()));
    let there = connect(settings(&vhost.url()));
    let address = "planner.plan";
    let serving = there.serve(address, 8, Arc::new(Notifier::new())).unwrap();
    let (services, key) = ("robots.services", "planner.plan");
    let mut stranger = Stranger::listen(&broker, &vhost, services, key);
    let request = Request::new(SenderId::new("Tester", 1), number(20), LONG);
    let pending = here.call(address, request, Arc::new(Notifier::new()));
    let pending = pending.unwrap();
    let (properties, bytes) = stranger.overhear();
    let request = serving.next_within(LONG).unwrap();
    // cancels, and repeats the request for itself
    for is_named in [true, false] {
        for kind in ["cancel", "enquiry", "request"] {
            let mut copy = properties.clone();
            copy.with_message_type(kind);
            let mut plain = without_user(&copy);
            plain.with_reply_to(NAME);
            stranger.publish((services, key), plain, &bytes, is_named);
        }
    }
    // its own requests, with the same id
    let own = [serving.next_within(LONG), serving.next_within(LONG)].map(Option::unwrap);
    assert!(request.is_awaited(), "not cancelled");
    for own in own {
        own.reply(Ok(number(-1)));
    }
    request.reply(Ok(number(21)));
    let reply = pending.wait().unwrap().to_datum().unwrap();
    assert_eq!(reply.as_int(), Some(21));
}

/// A copy that names no user.
fn without_user(properties: &BasicProperties) -> BasicProperties {
    let mut copy = BasicProperties::default();
    copy.with_content_type("application/cbor");
    if let Some(kind) = properties.message_type() {
        copy.with_message_type(kind);
    }
    if let Some(id) = properties.correlation_id() {
        copy.with_correlation_id(id).with_message_id(id);
    }
    if let Some(headers) = properties.headers() {
        copy.with_headers(headers.clone());
    }
    copy.finish()
}
