//! Faults of brokers, one per test.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, BusNotice};
use asmotion_bus::{Bus, BusError, LinkState, Notifier, PublishOptions, QueuePolicy};

use crate::common::{
    LONG, all, connect, events, eventually, is_down, is_own_process, noted, number, numbers,
    publisher, quick, settings, subscribe,
};
use crate::raw;

/// Publishes events before and after a fault: none is lost or repeated. Returns how long after the fault both ends were connected
/// again; `None` without a broker.
fn survives(fault: impl FnOnce(&asmotion_broker::TestBroker, &AmqpBus)) -> Option<Duration> {
    let broker = asmotion_broker::alone()?;
    let vhost = broker.vhost().unwrap();
    let (mut quickly, notices) = noted(&vhost.url());
    quickly.timing = quick(&vhost.url()).timing;
    let (reader, writer) = (connect(quickly.clone()), connect(quickly));
    let subscription = subscribe(&reader, "events", all(10_000));
    let state = subscribe(&reader, "state", QueuePolicy::Latest);
    let mut events = publisher(&writer, "events", events());
    let mut states = publisher(&writer, "state", PublishOptions::state());
    for n in 0..500 {
        events.publish(0, number(n)).unwrap();
    }
    // a publisher of which no message has arrived anywhere does not wait for the reader after the fault
    eventually("the first message has arrived", || {
        events.counts().accepted > 0
    });
    fault(&broker, &writer);
    let ended = Instant::now();
    for n in 500..1000 {
        events.publish(0, number(n)).unwrap();
    }
    eventually("the writer is back", || writer.health().is_up());
    eventually("the reader is back", || reader.health().is_up());
    let resumed = ended.elapsed();
    assert!(writer.drain(LONG));
    let came = numbers(&subscription, Duration::from_secs(2));
    let (sent, received) = (events.counts(), subscription.counts());
    assert!(
        came == (0..1000).collect::<Vec<_>>(),
        "{} numbers from {:?} to {:?}\n{sent:?}\n{received:?}\n{:#?}\n{}",
        came.len(),
        came.first(),
        came.last(),
        notices.lock().unwrap(),
        broker.log(),
    );
    assert_eq!(received.missed, 0);
    assert_eq!(
        (sent.accepted, sent.dropped, sent.lost, sent.refused),
        (1000, 0, 0, 0)
    );
    // the queue of a state topic is declared again
    eventually("the state comes", || {
        states.publish(0, number(7)).unwrap();
        state.next_within(Duration::from_millis(50)).is_some()
    });
    Some(resumed)
}

#[test]
fn t28_a_broker_that_is_killed_and_started_again() {
    let limit = Duration::from_secs(5);
    let resumed = survives(|broker, bus| {
        let begun = Instant::now();
        broker.kill().unwrap();
        eventually("it is noticed", || is_down(bus));
        assert!(begun.elapsed() < limit, "{:?}", begun.elapsed());
        broker.revive().unwrap();
    });
    assert!(resumed.is_none_or(|it| it < limit), "{resumed:?}");
}

/// The broker comes back without the readers' queues (a container without a volume, a queue that expired), and the
/// publisher is back before its reader.
#[test]
fn a_broker_that_has_forgotten_the_queue_of_a_reader_that_is_back_later() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let mut slow = settings(&vhost.url());
    slow.timing.first_retry = Duration::from_secs(3);
    slow.timing.last_retry = Duration::from_secs(3);
    slow.timing.jitter = 0.0;
    slow.timing.reply_retention = Duration::from_secs(1);
    let (reader, writer) = (connect(slow), connect(settings(&vhost.url())));
    let subscription = subscribe(&reader, "events", all(10_000));
    let mut events = publisher(&writer, "events", events());
    events.publish(0, number(0)).unwrap();
    assert!(subscription.next_within(LONG).is_some());
    broker.close_connections().unwrap();
    eventually("the queue has expired", || {
        vhost.queues().unwrap().is_empty()
    });
    eventually("the writer is back", || writer.health().is_up());
    for n in 1..100 {
        events.publish(0, number(n)).unwrap();
    }
    let received = numbers(&subscription, Duration::from_secs(4));
    assert_eq!(received, (1..100).collect::<Vec<_>>());
    let sent = events.counts();
    assert_eq!((sent.accepted, sent.unrouted, sent.dropped), (100, 0, 0));
}

#[test]
fn connections_closed_by_the_operator() {
    survives(|broker, _| broker.close_connections().unwrap());
}

#[test]
fn a_broker_stopped_and_started_inside_its_node() {
    survives(|broker, bus| {
        broker.stop_app().unwrap();
        eventually("it is noticed", || is_down(bus));
        broker.start_app().unwrap();
    });
}

#[test]
fn a_broker_frozen_for_a_moment() {
    survives(|broker, bus| {
        let begun = Instant::now();
        broker.freeze().unwrap();
        eventually("it is noticed", || is_down(bus));
        // sooner than by heartbeats, which take twice their interval
        assert!(
            begun.elapsed() < Duration::from_secs(4),
            "{:?}",
            begun.elapsed()
        );
        broker.thaw().unwrap();
    });
}

#[test]
fn a_broker_frozen_until_it_is_given_up() {
    survives(|broker, bus| {
        let given_up = "the broker is silent for 3s";
        let said = |bus: &AmqpBus| bus.health().link.to_string();
        broker.freeze().unwrap();
        eventually("it is given up", || {
            said(bus).contains(given_up) || said(bus).contains("within")
        });
        broker.thaw().unwrap();
    });
}

#[test]
fn a_broker_out_of_memory_takes_nothing_and_nothing_is_buffered_without_bound() {
    let test = "faults::a_broker_out_of_memory_takes_nothing_and_nothing_is_buffered_without_bound";
    if !is_own_process(test) {
        return;
    }
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let (bus, reader) = (connect(settings), connect(quick(&vhost.url())));
    let subscription = subscribe(&reader, "t", all(10_000));
    let mut kept = publisher(&bus, "t", events());
    let mut dropped = publisher(&bus, "t", PublishOptions::default());
    broker.raise_alarm().unwrap();
    eventually("it is blocked", || {
        matches!(bus.health().link, LinkState::Blocked { .. })
    });
    let memory = memory();
    let big = asmotion_bus::Payload::of(asmotion_datum::Datum::Bytes(vec![0; 16 * 1024].into()));
    // the bare client takes 8434 of these, 133 MiB, before it waits
    for _ in 0..8000 {
        assert!(matches!(
            dropped.publish(0, big.clone()),
            Err(BusError::Disconnected { .. })
        ));
    }
    for n in 0..100 {
        kept.publish(0, number(n)).unwrap();
    }
    let grown = self::memory().saturating_sub(memory);
    assert!(grown < 20 << 20, "{grown} bytes more");
    assert_eq!(
        (dropped.counts().dropped, kept.counts().pending()),
        (8000, 100)
    );
    broker.clear_alarm().unwrap();
    eventually("it is up", || bus.health().is_up());
    assert!(bus.drain(LONG));
    let silence = Duration::from_millis(500);
    assert_eq!(
        numbers(&subscription, silence),
        (0..100).collect::<Vec<_>>()
    );
    let notices = notices.lock().unwrap();
    assert!(notices.contains(&BusNotice::Blocked) && notices.contains(&BusNotice::Unblocked));
}

/// Resident memory of this process.
fn memory() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<usize>().ok());
    kilobytes.unwrap_or(0) * 1024
}

#[test]
fn a_queue_deleted_under_its_reader_is_made_again() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let subscription = subscribe(&bus, "t", all(100));
    let mut publisher = publisher(&bus, "t", events());
    publisher.publish(0, number(1)).unwrap();
    assert!(subscription.next_within(LONG).is_some());
    for queue in vhost.queues().unwrap() {
        vhost.delete_queue(&queue).unwrap();
    }
    eventually("it is made again", || vhost.queues().unwrap().len() == 1);
    eventually("messages come", || {
        publisher.publish(0, number(2)).unwrap();
        subscription
            .next_within(Duration::from_millis(50))
            .is_some()
    });
    let notices = notices.lock().unwrap();
    let deleted = |notice: &BusNotice| matches!(notice, BusNotice::Refused { reason, .. } if reason.contains("deleted"));
    assert!(notices.iter().any(deleted), "{notices:?}");
}

#[test]
fn a_queue_that_overflows_while_its_reader_is_away_drops_as_declared_and_says_so() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    // a reader that holds a queue like ours, and does not read
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let bus = connect(settings(&vhost.url()));
    let (connection, channel) = runtime.block_on(raw::open(&broker, vhost.name()));
    runtime.block_on(raw::full_queue(&channel, "full", "robots", "t", 3));
    let mut publisher = publisher(&bus, "t", events());
    for n in 0..10 {
        publisher.publish(0, number(n)).unwrap();
    }
    assert!(bus.drain(LONG));
    let sent = publisher.counts();
    assert_eq!((sent.accepted, sent.refused), (3, 7));
    runtime.block_on(async {
        channel.close().await.unwrap();
        connection.close().await.unwrap();
    });
}

#[test]
fn who_may_not_is_told_and_others_go_on() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = vhost.name().to_owned();
    broker.add_user(&user, "p").unwrap();
    // may read but not publish
    let admin = connect(settings(&vhost.url()));
    vhost.permit(&user, "^asmotion", "^asmotion", ".*").unwrap();
    let (settings, notices) = noted(&vhost.url_of(&user, "p"));
    let bus = connect(settings);
    let mut forbidden = publisher(&bus, "t", events());
    forbidden.publish(0, number(1)).unwrap();
    eventually("it is refused", || forbidden.counts().refused == 1);
    let serving = bus.serve("there", 1, Arc::new(Notifier::new()));
    assert!(matches!(serving.map(drop), Err(BusError::Refused { .. })));
    let subscription = subscribe(&bus, "t", all(10));
    publisher(&admin, "t", events())
        .publish(0, number(2))
        .unwrap();
    assert_eq!(numbers(&subscription, Duration::from_millis(500)), [2]);
    assert!(bus.health().is_up());
    let notices = notices.lock().unwrap();
    let said = |notice: &BusNotice| notice.to_string().contains("ACCESS_REFUSED");
    assert!(notices.iter().any(said), "{notices:?}");
}

#[test]
fn who_may_not_read_is_told_at_once() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = vhost.name().to_owned();
    broker.add_user(&user, "p").unwrap();
    vhost.permit(&user, ".*", ".*", "^$").unwrap();
    let bus = connect(settings(&vhost.url_of(&user, "p")));
    let end = bus.subscribe(
        "Tester",
        &asmotion_bus::Pattern::all(),
        all(1),
        Arc::new(Notifier::new()),
    );
    assert!(matches!(end.map(drop), Err(BusError::Refused { .. })));
}

#[test]
fn a_publication_on_a_channel_that_the_broker_closed_is_not_taken_for_sent() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let user = vhost.name().to_owned();
    broker.add_user(&user, "p").unwrap();
    let admin = connect(settings(&vhost.url()));
    vhost.permit(&user, "^asmotion", "^asmotion", ".*").unwrap();
    let (settings, notices) = noted(&vhost.url_of(&user, "p"));
    let bus = connect(settings);
    drop(admin);
    let mut publishers =
        [events(), PublishOptions::default()].map(|sending| publisher(&bus, "t", sending));
    for publisher in &mut publishers {
        for n in 0..20 {
            // an error counts the message as dropped
            let _ = publisher.publish(0, number(n));
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    eventually("each is accounted for", || {
        publishers
            .iter()
            .all(|publisher| publisher.counts().pending() == 0)
    });
    for publisher in &publishers {
        assert_eq!(publisher.counts().accepted, 0, "{:?}", publisher.counts());
    }
    let notices = notices.lock().unwrap();
    assert!(
        notices
            .iter()
            .any(|notice| notice.to_string().contains("ACCESS_REFUSED"))
    );
}

#[test]
fn a_forged_user_is_found_out_by_the_broker() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let subscription = subscribe(&bus, "t", all(10));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let forged = |user| runtime.block_on(raw::publish_as(&broker, vhost.name(), user, "t"));
    assert!(forged("tester"));
    assert!(!forged("somebody_else"));
    assert_eq!(numbers(&subscription, Duration::from_millis(500)), [1]);
}

#[test]
fn what_cannot_be_read_is_counted_and_said_and_never_fatal() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let subscription = subscribe(&bus, "#", all(10));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    for (content_type, bytes) in [
        (Some("image/png"), &b"?"[..]),
        (None, b"?"),
        (Some("application/json; charset=utf-8"), b"41"),
        (Some("application/json"), b"42"),
    ] {
        runtime.block_on(raw::publish(
            &broker,
            vhost.name(),
            "t",
            content_type,
            bytes,
        ));
    }
    assert_eq!(numbers(&subscription, Duration::from_millis(500)), [41, 42]);
    assert_eq!(subscription.counts().unreadable, 2);
    let notices = notices.lock().unwrap();
    assert!(
        notices
            .iter()
            .any(|notice| notice.to_string().contains("`image/png`"))
    );
}

#[test]
fn a_message_that_breaks_the_client_does_not_break_it_for_ever() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let (settings, notices) = noted(&vhost.url());
    let bus = connect(settings);
    let subscription = subscribe(&bus, "t", all(10));
    // a header whose text is not UTF-8, as clients in other languages can write it
    let undefined = ["undefined"; 11].join(", ");
    broker
        .evaluate(&format!(
            "rabbit_basic:publish(rabbit_misc:r(<<\"{}\">>, exchange, <<\"robots\">>), <<\"t\">>, \
             {{'P_basic', <<\"application/json\">>, undefined, [{{<<\"x\">>, longstr, <<255,254>>}}], \
             {undefined}}}, <<\"1\">>)",
            vhost.name()
        ))
        .unwrap();
    eventually("it is discarded", || {
        let notices = notices.lock().unwrap();
        let thrown = |notice: &BusNotice| notice.to_string().contains("discarded");
        notices.iter().any(thrown)
    });
    let mut publisher = publisher(&bus, "t", events());
    eventually("messages come", || {
        publisher.publish(0, number(2)).unwrap();
        subscription
            .next_within(Duration::from_millis(50))
            .is_some()
    });
    std::thread::sleep(Duration::from_millis(2500));
    assert!(bus.health().is_up());
}
