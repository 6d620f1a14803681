//! Programs with credentials of their own, and machines with other clocks.

use std::time::{Duration, Instant, SystemTime};

use amqprs::channel::{
    BasicConsumeArguments, BasicPublishArguments, Channel, ExchangeDeclareArguments,
};
use amqprs::connection::Connection;
use amqprs::{BasicProperties, FieldTable, FieldValue};
use asmotion_amqp::{AmqpBus, BusNotice};
use asmotion_broker::TestBroker;
use asmotion_bus::{Bus, Notifier, Payload, ServedAddress};
use asmotion_datum::Datum;
use std::sync::Arc;
use tokio::runtime::Runtime;

use crate::common::{
    LONG, all, connect, events, eventually, noted, number, numbers, publisher, settings, subscribe,
};
use crate::raw;

/// A connection of the bare client, used in its own runtime.
struct Stranger {
    runtime: Runtime,
    /// Channel and connection; `None` only while the value is dropped.
    client: Option<(Channel, Connection)>,
    replies: tokio::sync::mpsc::UnboundedReceiver<amqprs::channel::ConsumerMessage>,
}

impl Stranger {
    fn new(broker: &TestBroker, vhost: &str, user: &str, password: &str) -> Self {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .enable_all()
            .build()
            .unwrap();
        let (connection, channel, replies) = runtime.block_on(async {
            let (connection, channel) = raw::open_as(broker, vhost, user, password).await;
            let mut consume = BasicConsumeArguments::new("amq.rabbitmq.reply-to", "");
            consume.auto_ack(true);
            let (_, replies) = channel.basic_consume_rx(consume).await.unwrap();
            (connection, channel, replies)
        });
        Self {
            runtime,
            client: Some((channel, connection)),
            replies,
        }
    }

    fn publish(&self, exchange: &str, key: &str, properties: BasicProperties) {
        let arguments = BasicPublishArguments::new(exchange, key);
        let (channel, _) = self.client.as_ref().unwrap();
        let published = channel.basic_publish(properties, b"7".to_vec(), arguments);
        self.runtime.block_on(published).unwrap();
    }

    /// Sends a message about the request `id`. `late_s` is the number of seconds by which its deadline has passed.
    fn request(&self, kind: &str, id: &str, late_s: i64) {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        let now = i64::try_from(now.unwrap().as_nanos()).unwrap();
        let headers = table([
            ("timeout", 5_000_000_000),
            ("deadline", now - late_s * 1_000_000_000),
        ]);
        let properties = BasicProperties::default()
            .with_content_type("application/json")
            .with_message_type(kind)
            .with_message_id(id)
            .with_correlation_id(id)
            .with_reply_to("amq.rabbitmq.reply-to")
            .with_headers(headers)
            .finish();
        self.publish("robots.services", "planner.plan", properties);
    }

    /// The properties and the content of the next reply.
    fn whole_reply(&mut self) -> Option<(BasicProperties, Vec<u8>)> {
        let replies = &mut self.replies;
        let next = async { tokio::time::timeout(Duration::from_secs(2), replies.recv()).await };
        let message = self.runtime.block_on(next).ok().flatten()?;
        Some((message.basic_properties?, message.content?))
    }

    /// The id of the request and the kind of the next reply.
    fn reply(&mut self) -> Option<(String, String)> {
        let (properties, _) = self.whole_reply()?;
        let text = |text: Option<&String>| text.cloned().unwrap_or_default();
        Some((
            text(properties.correlation_id()),
            text(properties.message_type()),
        ))
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        // the client's destructors use the current runtime
        let _entered = self.runtime.enter();
        self.client = None;
    }
}

fn table<const N: usize>(fields: [(&str, i64); N]) -> FieldTable {
    let mut table = FieldTable::new();
    for (name, value) in fields {
        table.insert(name.try_into().unwrap(), FieldValue::l(value));
    }
    table
}

fn serve(bus: &AmqpBus) -> ServedAddress {
    bus.serve("planner.plan", 8, Arc::new(Notifier::new()))
        .unwrap()
}

/// A second user, who may do everything, sends messages in the stream of another one: with a number far ahead, and with the
/// next ones.
#[test]
fn a_forged_number_mutes_no_stream() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = format!("dash-{}", vhost.name());
    broker.add_user(&user, "p").unwrap();
    vhost.permit(&user, ".*", ".*", ".*").unwrap();
    let bus = connect(settings(&vhost.url()));
    let (tap, subscription) = (
        subscribe(&bus, "permit", all(100)),
        subscribe(&bus, "permit", all(100)),
    );
    let mut permit = publisher(&bus, "permit", events());
    permit.publish(0, number(1)).unwrap();
    assert_eq!(
        numbers(&subscription, LONG.min(Duration::from_secs(1))),
        [1]
    );
    let seen = tap.next_within(LONG).unwrap();
    assert_eq!(seen.sequence, 1);
    let dash = Stranger::new(&broker, vhost.name(), &user, "p");
    // the ids of our streams are those of a process and a number, which every reader sees
    let id = raw::message_id(&broker, vhost.name(), "permit", || {
        permit.publish(0, number(2)).unwrap();
    });
    let (stream, _) = id.rsplit_once('-').unwrap();
    let far = i64::MAX / 2;
    for (claimed, number) in [Some(&user), None]
        .into_iter()
        .flat_map(|claimed| [far, 3, 4, 5].map(|number| (claimed, number)))
    {
        let mut properties = BasicProperties::default();
        properties
            .with_content_type("application/json")
            .with_message_id(&format!("{stream}-{number}"))
            .with_headers(table([("sequence", number)]));
        if let Some(user) = claimed {
            properties.with_user_id(user);
        }
        dash.publish("robots", "permit", properties.finish());
    }
    let forged = numbers(&tap, Duration::from_secs(2));
    assert_eq!(forged, [&[2][..], &[7; 8]].concat());
    for n in 3..6 {
        permit.publish(0, number(n)).unwrap();
    }
    let mut received = numbers(&subscription, Duration::from_secs(2));
    received.retain(|n| *n != 7);
    assert_eq!(received, [2, 3, 4, 5]);
    assert_eq!(subscription.counts().missed, 0);
}

/// A stranger neither cancels nor pre-empts the request of another user, though it knows the id.
#[test]
fn the_requests_of_one_user_are_its_own() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = format!("dash-{}", vhost.name());
    broker.add_user(&user, "p").unwrap();
    vhost.permit(&user, ".*", ".*", ".*").unwrap();
    let bus = connect(settings(&vhost.url()));
    let serving = serve(&bus);
    let mut robot = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    let dash = Stranger::new(&broker, vhost.name(), &user, "p");
    let as_user = |stranger: &Stranger, user: &str, kind: &str| {
        let properties = BasicProperties::default()
            .with_content_type("application/json")
            .with_message_type(kind)
            .with_message_id("r.1")
            .with_correlation_id("r.1")
            .with_reply_to("amq.rabbitmq.reply-to")
            .with_user_id(user)
            .with_headers(table([("timeout", 20_000_000_000)]))
            .finish();
        stranger.publish("robots.services", "planner.plan", properties);
    };
    as_user(&dash, &user, "request");
    drop(
        serving
            .next_within(LONG)
            .expect("the stranger's own request"),
    );
    as_user(&robot, broker.user(), "request");
    let request = serving.next_within(LONG).expect("the robot's request");
    as_user(&dash, &user, "cancel");
    std::thread::sleep(Duration::from_millis(300));
    request.reply(Ok(number(1)));
    assert_eq!(robot.reply(), Some(("r.1".to_owned(), "result".to_owned())));
}

/// A caller that writes JSON reads JSON.
#[test]
fn a_result_has_the_content_type_of_its_request() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let serving = serve(&bus);
    let mut caller = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    for (content_type, content) in [
        ("application/json", &b"1.5"[..]),
        ("application/cbor", b"\xfb\x3f\xf8\0\0\0\0\0\0"),
    ] {
        let properties = BasicProperties::default()
            .with_content_type(content_type)
            .with_message_type("request")
            .with_message_id(content_type)
            .with_correlation_id(content_type)
            .with_reply_to("amq.rabbitmq.reply-to")
            .finish();
        caller.publish("robots.services", "planner.plan", properties);
        let request = serving.next_within(LONG).unwrap();
        request.reply(Ok(Payload::of(Datum::Float(1.5))));
        let (properties, found) = caller.whole_reply().unwrap();
        let expected = content_type.to_owned();
        assert_eq!(properties.content_type(), Some(&expected));
        assert_eq!(found, content, "{content_type}");
    }
}

/// A caller whose clock is ten seconds behind: its requests seem to be late.
#[test]
fn a_caller_with_another_clock_is_served_and_reported() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let serving = serve(&bus);
    let mut caller = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    // ahead of ours: its deadlines are far in the future
    caller.request("request", "ahead", -30);
    serving.next_within(LONG).unwrap().reply(Ok(number(1)));
    assert_eq!(caller.reply().unwrap().0, "ahead");
    // behind: held until the caller shows that it waits
    caller.request("request", "behind", 10);
    assert!(serving.next_within(Duration::from_millis(200)).is_none());
    caller.request("enquiry", "behind", 10);
    serving.next_within(LONG).unwrap().reply(Ok(number(1)));
    assert_eq!(caller.reply().unwrap().0, "behind");
    // from now on its clock is known
    let begun = Instant::now();
    caller.request("request", "again", 10);
    serving.next_within(LONG).unwrap().reply(Ok(number(1)));
    assert_eq!(caller.reply().unwrap().0, "again");
    assert!(begun.elapsed() < Duration::from_secs(1));
    // a caller that has given up sends no enquiry
    caller.request("request", "late", 60);
    assert!(serving.next_within(Duration::from_millis(1800)).is_none());
    eventually("both are reported", || {
        let notices = notices.lock().unwrap();
        let has = |what: fn(&BusNotice) -> bool| notices.iter().any(what);
        has(
            |it| matches!(it, BusNotice::ClockOffset { difference, .. } if difference.as_secs() / 5 == 3),
        ) && has(|it| matches!(it, BusNotice::Late { .. }))
    });
}

/// Nobody enquires about a one-way request, so it is executed unless the clock of its sender is known and shows that it is late.
#[test]
fn a_one_way_request_of_a_caller_with_another_clock_is_executed() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let serving = serve(&bus);
    let mut caller = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    let is_executed = |within: Duration| serving.next_within(within).is_some();
    for (id, late_s) in [("behind", 10), ("ahead", -10)] {
        caller.request("telling", id, late_s);
        assert!(is_executed(LONG), "{id}");
    }
    // its clock becomes known: it is 10 s behind
    caller.request("request", "asks", 10);
    assert!(!is_executed(Duration::from_millis(200)));
    caller.request("enquiry", "asks", 10);
    serving.next_within(LONG).unwrap().reply(Ok(number(1)));
    assert_eq!(caller.reply().unwrap().0, "asks");
    caller.request("telling", "again", 10);
    assert!(is_executed(LONG));
    caller.request("telling", "late", 20);
    assert!(!is_executed(Duration::from_secs(1)));
    eventually("it is reported", || {
        let notices = notices.lock().unwrap();
        notices
            .iter()
            .any(|it| matches!(it, BusNotice::Late { .. }))
    });
}

/// A caller whose timeout is shorter than the interval of its enquiries withdraws its first request without one.
#[test]
fn a_caller_with_another_clock_and_a_short_timeout_is_served_from_its_second_request_on() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let serving = serve(&bus);
    let mut caller = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    caller.request("request", "first", 10);
    assert!(serving.next_within(Duration::from_millis(200)).is_none());
    caller.request("cancel", "first", 10);
    eventually("its clock is reported", || {
        let notices = notices.lock().unwrap();
        let is_offset = |it: &BusNotice| matches!(it, BusNotice::ClockOffset { .. });
        notices.iter().any(is_offset)
    });
    caller.request("request", "second", 10);
    serving.next_within(LONG).unwrap().reply(Ok(number(1)));
    assert_eq!(caller.reply().unwrap().0, "second");
}

/// Replies of 1 MB each: the provider remembers the last few, and does not execute an earlier request again.
#[test]
fn remembered_replies_are_bounded() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let serving = serve(&bus);
    let mut caller = Stranger::new(&broker, vhost.name(), broker.user(), broker.password());
    let large = Datum::Bytes(vec![0; 1 << 20].into());
    for n in 0..12 {
        caller.request("request", &format!("large-{n}"), -4);
        let request = serving.next_within(LONG).unwrap();
        request.reply(Ok(Payload::of(large.clone())));
        assert_eq!(caller.reply().unwrap().1, "result");
    }
    for (n, expected) in [(11, "result"), (0, "refusal")] {
        caller.request("request", &format!("large-{n}"), -4);
        assert_eq!(caller.reply().unwrap().1, expected);
    }
    assert!(serving.next_within(Duration::from_millis(300)).is_none());
    // past their deadlines they are forgotten altogether
    eventually("the request is executed anew", || {
        caller.request("request", "large-11", -4);
        serving.next_within(Duration::from_millis(200)).is_some()
    });
}

/// The broker does not read for longer than a command is valid.
#[test]
fn no_command_comes_later_than_its_readers_use_it() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (reader, writer) = (
        connect(settings(&vhost.url())),
        connect(settings(&vhost.url())),
    );
    let limit = Duration::from_secs(1);
    let commands = subscribe(&reader, "twist", all(100));
    let held = subscribe(&reader, "pose", all(100));
    let mut twist = publisher(&writer, "twist", events().max_age(Some(limit)));
    let mut pose = publisher(&writer, "pose", events());
    twist.publish(0, number(0)).unwrap();
    assert!(commands.next_within(LONG).is_some());
    eventually("it is confirmed", || twist.counts().accepted == 1);
    broker.kill().unwrap();
    eventually("the writer knows", || !writer.health().is_up());
    twist.publish(0, number(1)).unwrap();
    pose.publish(0, number(1)).unwrap();
    std::thread::sleep(2 * limit);
    broker.revive().unwrap();
    eventually("both are back", || {
        writer.health().is_up() && reader.health().is_up()
    });
    let late = held.next_within(LONG).expect("a pose is used at any age");
    assert!(late.age >= 2 * limit, "{:?}", late.age);
    twist.publish(0, number(2)).unwrap();
    let first = commands.next_within(LONG).expect("a new command");
    assert_eq!(first.payload.to_datum().unwrap().as_int(), Some(2));
    assert!(first.age < limit);
    assert_eq!(twist.counts().dropped, 1);
}

#[test]
fn an_exchange_of_another_type_is_reported() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let runtime = Runtime::new().unwrap();
    let (connection, channel) = runtime.block_on(raw::open(&broker, vhost.name()));
    let mut fanout = ExchangeDeclareArguments::new("robots", "fanout");
    fanout.durable(true);
    runtime.block_on(channel.exchange_declare(fanout)).unwrap();
    let failed = AmqpBus::connect(settings(&vhost.url()), Duration::from_secs(5));
    let reason = failed.map(drop).unwrap_err().to_string();
    assert!(
        reason.contains("robots") && reason.contains("inequivalent arg 'type'"),
        "{reason}"
    );
    let _entered = runtime.enter();
    drop((channel, connection));
}
