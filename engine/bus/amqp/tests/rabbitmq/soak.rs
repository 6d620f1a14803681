//! Confirmed events through broker restarts: none lost, none duplicated, in order.

use std::time::{Duration, Instant};

use asmotion_bus::Bus;

use crate::common::{LONG, connect, events, number, publisher, settings, subscribe};

/// Publishes `count` events while the broker is killed `restarts` times.
fn soak(count: i64, restarts: i64) {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (reader, writer) = (
        connect(settings(&vhost.url())),
        connect(settings(&vhost.url())),
    );
    let queue = asmotion_bus::QueuePolicy::All {
        size: 200_000,
        overflow: asmotion_bus::Overflow::DropNewest,
    };
    let subscription = subscribe(&reader, "events", queue);
    let mut events = publisher(&writer, "events", events());
    let share = count / (restarts + 1);
    for n in 0..count {
        events.publish(0, number(n)).unwrap();
        // a few at a time, so that each restart hits messages in flight
        if n % 100 == 99 {
            std::thread::sleep(Duration::from_millis(2));
        }
        if n % share == share - 1 && n + share <= count {
            broker.kill().unwrap();
            broker.revive().unwrap();
        }
    }
    assert!(writer.drain(4 * LONG), "{:?}", events.counts());
    let until = Instant::now() + 4 * LONG;
    for n in 0..count {
        let left = until.saturating_duration_since(Instant::now());
        let envelope = subscription.next_within(left);
        let envelope = envelope.unwrap_or_else(|| panic!("{n} is lost: {subscription:?}"));
        assert_eq!(envelope.payload.to_datum().unwrap().as_int(), Some(n));
        assert_eq!(envelope.sequence, n as u64 + 1);
    }
    assert!(subscription.next_within(Duration::from_secs(1)).is_none());
    let (sent, received) = (events.counts(), subscription.counts());
    println!("{count} events, {restarts} restarts: {sent:?}, {received:?}");
    assert_eq!(
        (sent.accepted, sent.refused, sent.dropped),
        (count as u64, 0, 0)
    );
    assert_eq!(
        (received.missed, received.dropped, received.unreadable),
        (0, 0, 0)
    );
}

#[test]
fn five_thousand_confirmed_events_through_two_restarts() {
    soak(5_000, 2);
}

#[test]
#[ignore = "takes more than a minute: run it with `--ignored`"]
fn a_hundred_thousand_confirmed_events_through_five_restarts() {
    soak(100_000, 5);
}
