//! Queues of processes that come back after a crash.

use std::time::Duration;

use asmotion_amqp::AmqpBus;
use asmotion_broker::{TestBroker, Vhost};

use crate::common::{all, connect, events, number, numbers, publisher, settings, subscribe};
use crate::raw;

/// Silence after which nothing more is expected.
const SILENCE: Duration = Duration::from_millis(300);

fn returning(vhost: &Vhost<'_>) -> AmqpBus {
    let mut settings = settings(&vhost.url());
    settings.returns = true;
    connect(settings)
}

/// Declares the queue that a crashed process of the same name has left, with another length, and sends it three messages.
fn leave_queue(broker: &TestBroker, vhost: &Vhost<'_>) {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    runtime.block_on(async {
        let (connection, channel) = raw::open(broker, vhost.name()).await;
        let queue = "asmotion.Tester.numbers.0";
        raw::full_queue(&channel, queue, "robots", "numbers", 5000).await;
        channel.close().await.unwrap();
        connection.close().await.unwrap();
        for text in ["1", "2", "3"] {
            let json = Some("application/json");
            raw::publish(broker, vhost.name(), "numbers", json, text.as_bytes()).await;
        }
    });
}

#[test]
fn messages_for_an_earlier_run_are_discarded_and_counted() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    for (returns, expected) in [(true, 3), (false, 0)] {
        let vhost = broker.vhost().unwrap();
        let bus = if returns {
            returning(&vhost)
        } else {
            connect(settings(&vhost.url()))
        };
        leave_queue(&broker, &vhost);
        let subscription = subscribe(&bus, "numbers", all(10));
        assert_eq!(subscription.counts().discarded, expected);
        let mut writer = publisher(&bus, "numbers", events());
        writer.publish(0, number(4)).unwrap();
        assert_eq!(numbers(&subscription, SILENCE), [4]);
        // the queue of a subscription that ends disappears, and its name can be used again
        drop(subscription);
        let again = subscribe(&bus, "numbers", all(10));
        writer.publish(0, number(5)).unwrap();
        assert_eq!(numbers(&again, SILENCE), [5]);
        assert_eq!(again.counts().discarded, 0);
    }
}

#[test]
fn a_second_process_of_the_same_name_takes_nothing_away() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (one, other) = (returning(&vhost), returning(&vhost));
    let first = [(); 2].map(|()| subscribe(&one, "numbers", all(10)));
    let second = subscribe(&other, "numbers", all(10));
    let mut writer = publisher(&one, "numbers", events());
    for n in 1..=3 {
        writer.publish(0, number(n)).unwrap();
    }
    for subscription in first.iter().chain([&second]) {
        assert_eq!(numbers(subscription, SILENCE), [1, 2, 3]);
        assert_eq!(subscription.counts().discarded, 0);
    }
}

/// A process that subscribes again at once meets its own queue while the broker deletes it, which the broker answers at times with "home
/// node of durable queue is down or inaccessible".
#[test]
fn a_subscription_begins_while_the_last_one_of_its_name_ends() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = returning(&vhost);
    let mut writer = publisher(&bus, "numbers", events());
    let mut last = subscribe(&bus, "numbers", all(10));
    for n in 0..100 {
        drop(last);
        last = subscribe(&bus, "numbers", all(10));
        writer.publish(0, number(n)).unwrap();
        let arrived = last.next_within(crate::common::LONG).expect("the message");
        assert_eq!(arrived.payload.to_datum().unwrap().as_int(), Some(n));
    }
}
