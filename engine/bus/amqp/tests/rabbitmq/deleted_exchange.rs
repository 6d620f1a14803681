//! Exchanges that an operator deletes while systems use them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, BusNotice};
use asmotion_bus::{Bus, Notifier, Payload, PublishOptions, QueuePolicy, Request, SenderId};
use asmotion_datum::Datum;

use crate::common::{
    LONG, all, client_panics, connect, events, eventually, noted, number, numbers, publisher,
    settings, subscribe,
};

/// Time within which everything must work again, also on a loaded machine.
const SOON: Duration = Duration::from_secs(5);

#[test]
fn is_declared_again_and_no_event_of_the_stream_is_lost() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let before = client_panics();
    let vhost = broker.vhost().unwrap();
    let (writing, writer_notices) = noted(&vhost.url());
    let writer = connect(writing);
    // the reader may neither declare nor write exchanges, so no refusal can show it the deletion
    let user = vhost.name().to_owned();
    broker.add_user(&user, "p").unwrap();
    vhost.permit(&user, "^asmotion", "^asmotion", ".*").unwrap();
    let (reading, reader_notices) = noted(&vhost.url_of(&user, "p"));
    let reader = connect(reading);
    let subscription = subscribe(&reader, "events", all(10_000));
    let state = subscribe(&reader, "state", QueuePolicy::Latest);
    let mut stream = publisher(&writer, "events", events());
    let mut states = publisher(&writer, "state", PublishOptions::state());

    for n in 0..100 {
        stream.publish(0, number(n)).unwrap();
    }
    // an event on its way at this moment may reach no queue, which counts as unrouted
    assert!(writer.drain(LONG));
    vhost.delete_exchange("robots").unwrap();
    let deleted = Instant::now();
    for n in 100..200 {
        stream.publish(0, number(n)).unwrap();
    }
    eventually("states arrive", || {
        // the link is down for a moment
        let _ = states.publish(0, number(7));
        state.next_within(Duration::from_millis(50)).is_some()
    });
    assert!(deleted.elapsed() < SOON, "{:?}", deleted.elapsed());
    assert!(writer.drain(LONG));
    let received = numbers(&subscription, Duration::from_secs(2));
    assert_eq!(
        received,
        (0..200).collect::<Vec<_>>(),
        "{:?}, {:?}, {writer_notices:?}, {reader_notices:?}",
        stream.counts(),
        subscription.counts()
    );
    let sent = stream.counts();
    assert_eq!(
        (sent.accepted, sent.unrouted, sent.refused, sent.lost),
        (200, 0, 0, 0)
    );
    // the writer may have declared the exchange again before the reader looks
    for (notices, least) in [(writer_notices, 1), (reader_notices, 0)] {
        let notices = notices.lock().unwrap();
        let deletions = notices.iter().filter(|notice| is_deletion(notice));
        assert!((least..=1).contains(&deletions.count()), "{notices:?}");
        let refused = |notice: &BusNotice| matches!(notice, BusNotice::Refused { .. });
        assert!(!notices.iter().any(refused), "{notices:?}");
    }
    assert_eq!(client_panics(), before, "the client has panicked");
}

fn is_deletion(notice: &BusNotice) -> bool {
    matches!(notice, BusNotice::Disconnected { reason } if reason.contains("an exchange was deleted"))
}

/// Another process has declared the exchange again before this one looks: nothing shows that the bindings are gone.
#[test]
fn and_declared_by_another_program_has_its_bindings_again() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let subscription = subscribe(&bus, "t", all(100));
    let serving = bus.serve("there", 8, Arc::new(Notifier::new())).unwrap();
    let mut publisher = publisher(&bus, "t", PublishOptions::default());
    vhost.replace_exchange("robots", "topic").unwrap();
    vhost.replace_exchange("robots.services", "direct").unwrap();
    let begun = Instant::now();
    eventually("messages arrive", || {
        // refused while the link is down: it may have looked between the deletion and the declaration
        publisher.publish(0, number(1)).is_ok()
            && subscription
                .next_within(Duration::from_millis(50))
                .is_some()
    });
    eventually("requests arrive", || {
        let pending = call(&bus, Duration::from_millis(500));
        if let Some(call) = serving.next_within(Duration::from_millis(50)) {
            call.reply(Ok(Payload::of(Datum::Null)));
        }
        pending.is_some_and(|pending| pending.wait().is_ok())
    });
    assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
    assert!(bus.health().is_up());
}

#[test]
fn of_services_is_declared_again_and_calls_reach_their_provider() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let [provider, caller] = [(); 2].map(|()| connect(settings(&vhost.url())));
    let serving = provider
        .serve("there", 8, Arc::new(Notifier::new()))
        .unwrap();
    vhost.delete_exchange("robots.services").unwrap();
    let begun = Instant::now();
    eventually("a call is executed", || {
        let pending = call(&caller, Duration::from_millis(500));
        if let Some(request) = serving.next_within(Duration::from_millis(200)) {
            request.reply(Ok(Payload::of(Datum::Int(7))));
        }
        pending.is_some_and(|pending| pending.wait().is_ok())
    });
    assert!(begun.elapsed() < SOON, "{:?}", begun.elapsed());
}

/// A call to the service `there`; `None` while the link is down.
fn call(bus: &AmqpBus, timeout: Duration) -> Option<asmotion_bus::PendingCall> {
    let request = Request::new(
        SenderId::new("Tester", 1),
        Payload::of(Datum::Null),
        timeout,
    );
    bus.call("there", request, Arc::new(Notifier::new())).ok()
}
