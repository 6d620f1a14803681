//! The link: connecting, losing and restoring the connection, with reports. Each gap of the client has a test here.

use std::net::TcpListener;
use std::sync::Arc;
use std::time::{Duration, Instant};

use asmotion_amqp::{AmqpBus, AmqpSettings, BusNotice, ClientIdentity, Credentials, TlsSettings};
use asmotion_bus::{
    Bus, BusError, CallFailure, LinkState, Notifier, Pattern, PublishOptions, Request, SenderId,
};
use asmotion_datum::{Datum, Message, Schema};

use crate::common::{
    LONG, all, connect, events, eventually, is_own_process, noted, number, numbers, publisher,
    settings, subscribe,
};

#[test]
fn a_wrong_password_is_known_at_once_and_in_words() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let begun = Instant::now();
    let end = AmqpBus::connect(settings(&vhost.url_of("tester", "wrong")), LONG);
    let Err(BusError::Refused { reason }) = end.map(drop) else {
        panic!("it was not refused");
    };
    assert!(reason.contains("ACCESS_REFUSED"), "{reason}");
    assert!(!reason.contains("wrong"), "{reason}");
    // the bare client needs 3 s, and reports a reset connection
    assert!(
        begun.elapsed() < Duration::from_secs(2),
        "{:?}",
        begun.elapsed()
    );
}

#[test]
fn a_missing_virtual_host_is_named() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let mut settings = settings(&broker.vhost().unwrap().url());
    settings.vhost = "nowhere".to_owned();
    let end = AmqpBus::connect(settings, LONG).map(drop);
    let Err(BusError::Refused { reason }) = end else {
        panic!("{end:?}");
    };
    assert!(reason.contains("nowhere"), "{reason}");
}

#[test]
fn a_mute_server_is_not_waited_for() {
    let mute = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut settings = settings(&format!("amqp://{}", mute.local_addr().unwrap()));
    settings.timing.connect = Duration::from_millis(300);
    let begun = Instant::now();
    let end = AmqpBus::connect(settings, Duration::from_secs(1)).map(drop);
    assert!(matches!(end, Err(BusError::Disconnected { .. })), "{end:?}");
    assert!(begun.elapsed() < Duration::from_secs(5));
}

#[test]
fn somebody_else_than_a_broker_is_found_out() {
    let stranger = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = stranger.local_addr().unwrap();
    std::thread::spawn(move || {
        use std::io::Write;
        while let Ok((mut peer, _)) = stranger.accept() {
            let _ = peer.write_all(b"HTTP/1.1 400 Bad Request\r\n\r\n");
        }
    });
    let settings = settings(&format!("amqp://{address}"));
    let end = AmqpBus::connect(settings, Duration::from_secs(1)).map(drop);
    let Err(BusError::Disconnected { reason }) = end else {
        panic!("{end:?}");
    };
    assert_eq!(reason, "not an AMQP broker");
}

#[test]
fn names_that_the_client_breaks_at_are_refused() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let (long, origin) = ("x".repeat(256), SenderId::new("Tester", 1));
    let notifier = || Arc::new(Notifier::new());
    let request = || Request::new(origin.clone(), number(1), LONG);
    let ends = [
        bus.publisher(&long, &origin, Datum::schema(), PublishOptions::default())
            .map(drop),
        bus.publisher(
            "topic",
            &origin,
            &Schema::opaque(long.clone()),
            PublishOptions::default(),
        )
        .map(drop),
        bus.subscribe("Tester", &Pattern::new(&*long), all(1), notifier())
            .map(drop),
        bus.serve(&long, 1, notifier()).map(drop),
        bus.call(&long, request(), notifier()).map(drop),
        bus.call_one_way(&long, request(), notifier()).map(drop),
    ];
    for end in ends {
        assert!(matches!(end, Err(BusError::InvalidName { .. })), "{end:?}");
    }
    let longest = "y".repeat(255);
    let subscription = subscribe(&bus, &longest, all(1));
    publisher(&bus, &longest, PublishOptions::default())
        .publish(0, number(1))
        .unwrap();
    assert!(subscription.next_within(LONG).is_some());
}

#[test]
fn a_source_or_an_argument_may_be_of_any_length() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let subscription = subscribe(&bus, "t", all(4));
    let origin = SenderId::new("ü".repeat(1000), 1);
    let mut publisher = bus
        .publisher("t", &origin, Datum::schema(), PublishOptions::default())
        .unwrap();
    publisher.publish(0, number(1)).unwrap();
    let envelope = subscription.next_within(LONG).unwrap();
    assert_eq!(envelope.source, origin.source);
}

#[test]
fn many_may_declare_at_once() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    std::thread::scope(|scope| {
        for thread in 0..16 {
            let bus = &bus;
            scope.spawn(move || {
                for n in 0..4 {
                    let topic = format!("t{thread}.{n}");
                    let subscription = subscribe(bus, &topic, all(4));
                    let mut publisher = publisher(bus, &topic, events());
                    publisher.publish(0, number(n)).unwrap();
                    assert!(subscription.next_within(LONG).is_some(), "{topic}");
                }
            });
        }
    });
}

#[test]
fn without_a_broker_a_bus_waits_for_it_and_keeps_what_it_is_told_to() {
    let Some(broker) = asmotion_broker::alone() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    broker.kill().unwrap();
    let bus = AmqpBus::open(settings(&vhost.url())).unwrap();
    assert!(matches!(bus.health().link, LinkState::Down { .. }));
    let subscription = subscribe(&bus, "kept", all(100));
    let mut kept = publisher(&bus, "kept", events());
    let mut latest = publisher(&bus, "kept", PublishOptions::state());
    let mut dropped = publisher(&bus, "kept", PublishOptions::default());
    for n in 0..10 {
        kept.publish(0, number(n)).unwrap();
        latest.publish(0, number(100 + n)).unwrap();
        assert!(dropped.publish(0, number(200)).is_err());
    }
    let request = Request::new(SenderId::new("Tester", 1), number(1), LONG);
    let pending = bus
        .call("nobody", request, Arc::new(Notifier::new()))
        .unwrap();
    assert_eq!(pending.wait().unwrap_err(), CallFailure::Unavailable);
    let (notifier, begun) = (Arc::new(Notifier::new()), Instant::now());
    bus.notify_on_change(&notifier);
    broker.revive().unwrap();
    while !bus.health().is_up() {
        assert!(begun.elapsed() < 3 * LONG);
        notifier.wait(LONG);
    }
    assert!(bus.drain(LONG));
    // the queue may be declared after the first messages were published; later ones arrive in any case
    eventually("what follows comes", || {
        kept.publish(0, number(99)).unwrap();
        subscription
            .next_within(Duration::from_millis(100))
            .is_some()
    });
    assert!(bus.drain(LONG));
    assert_eq!((kept.counts().dropped, kept.counts().lost), (0, 0));
    assert_eq!(
        (latest.counts().published, latest.counts().dropped),
        (10, 9)
    );
    assert_eq!(
        (dropped.counts().published, dropped.counts().dropped),
        (10, 10)
    );
}

#[test]
fn a_bus_that_is_closed_has_sent_what_it_took_and_leaves_nothing() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let reader = connect(settings(&vhost.url()));
    let subscription = subscribe(&reader, "t", all(5000));
    let (settings, notices) = noted(&vhost.url());
    let writer = connect(settings);
    let _unread = subscribe(&writer, "other", all(5));
    let _served = writer.serve("there", 1, Arc::new(Notifier::new())).unwrap();
    let mut publisher = publisher(&writer, "t", events());
    for n in 0..3000 {
        publisher.publish(0, number(n)).unwrap();
    }
    drop(writer);
    assert_eq!(publisher.counts().pending(), 0);
    assert!(
        publisher.publish(0, number(1)).is_ok(),
        "events are kept to the end of their days"
    );
    assert_eq!(
        numbers(&subscription, Duration::from_secs(1)),
        (0..3000).collect::<Vec<_>>()
    );
    assert_eq!(vhost.queues().unwrap().len(), 1, "the reader's");
    assert_eq!(
        notices.lock().unwrap().len(),
        1,
        "connected, and nothing went wrong"
    );
}

#[test]
fn credentials_come_from_a_file_and_are_not_shown() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let file = std::env::temp_dir().join(format!("credentials-{}", std::process::id()));
    std::fs::write(&file, format!("{}\n{}\n", broker.user(), broker.password())).unwrap();
    let (mut settings, notices) = noted(&vhost.url_of("x", "y"));
    settings.credentials = Credentials::from_file(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    let shown = format!("{settings:?}");
    connect(settings);
    let shown = format!("{shown}{:?}", notices.lock().unwrap());
    assert!(!shown.contains(broker.password()), "{shown}");
    assert!(matches!(
        notices.lock().unwrap()[0],
        BusNotice::Connected { .. }
    ));
}

/// Settings of an encrypted link to the broker.
fn encrypted(
    broker: &asmotion_broker::TestBroker,
    vhost: &asmotion_broker::Vhost<'_>,
) -> AmqpSettings {
    let port = broker.encrypted_port();
    let (certificate, key) = broker.client_identity();
    let mut settings = settings(&format!(
        "amqps://{}:{}@localhost:{port}/{}",
        broker.user(),
        broker.password(),
        vhost.name()
    ));
    settings.tls = Some(TlsSettings {
        authority: Some(broker.authority()),
        identity: Some(ClientIdentity { certificate, key }),
    });
    settings
}

#[test]
fn an_encrypted_link_with_certificates_on_both_sides_keeps_the_contract() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(encrypted(&broker, &vhost));
    assert_eq!(asmotion_bus::contract::violations(&bus, "secret"), []);
}

#[test]
fn an_encrypted_link_is_refused_where_the_certificates_do_not_fit() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let right = encrypted(&broker, &vhost);
    let with = |change: fn(&mut TlsSettings)| {
        let mut settings = right.clone();
        change(settings.tls.as_mut().unwrap());
        let end = AmqpBus::connect(settings, Duration::from_secs(1));
        end.map(drop).unwrap_err().to_string()
    };
    let unknown = with(|tls| tls.authority = None);
    assert!(unknown.contains("UnknownIssuer"), "{unknown}");
    let nobody = with(|tls| tls.identity = None);
    assert!(nobody.contains("no connection"), "{nobody}");
    let missing = with(|tls| tls.authority = Some("nowhere.pem".into()));
    assert!(missing.contains("`nowhere.pem`"), "{missing}");
    let mut elsewhere = right.clone();
    elsewhere.host = "127.0.0.1".to_owned();
    let end = AmqpBus::connect(elsewhere, Duration::from_secs(1));
    let other = end.map(drop).unwrap_err().to_string();
    assert!(other.contains("not valid for name"), "{other}");
}

#[test]
fn an_idle_bus_uses_next_to_nothing() {
    if !is_own_process("life::an_idle_bus_uses_next_to_nothing") {
        return;
    }
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let bus = connect(settings(&vhost.url()));
    let _subscriptions: Vec<_> = (0..20)
        .map(|n| subscribe(&bus, &format!("t{n}"), all(10)))
        .collect();
    let _publishers: Vec<_> = (0..20)
        .map(|n| publisher(&bus, &format!("t{n}"), events()))
        .collect();
    let _serving = bus.serve("there", 1, Arc::new(Notifier::new())).unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let (used, at) = (processor_time(), Instant::now());
    std::thread::sleep(Duration::from_secs(4));
    let share = (processor_time() - used).as_secs_f64() / at.elapsed().as_secs_f64();
    println!("{:.2} % of a core", share * 100.0);
    assert!(share < 0.02, "{share}");
}

/// CPU time of this process so far; the kernel counts in ticks of 10 ms.
fn processor_time() -> Duration {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit_once(')').map_or("", |(_, fields)| fields);
    let ticks = fields.split_whitespace().skip(11).take(2);
    Duration::from_millis(10)
        * ticks
            .filter_map(|field| field.parse::<u32>().ok())
            .sum::<u32>()
}
