//! Publishers and subscriptions.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use asmotion_datum::Datum;
use asmotion_ros2::{
    Durability, EndpointError, EndpointKind, Node, NodeOptions, Notice, Qos, Reliability,
    SubscriptionOptions,
};

use crate::peer::{
    LONG, Peer, catalogue, domain, encode, hex, named, node, python, text, topic_settings, wait,
};

#[test]
fn r12_cyclone_reads_what_a_publisher_sends() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let peer = Peer::start(
        &python,
        "subscribe",
        &topic_settings(domain, "/chatter", &string),
    );
    peer.expect("ready");
    let node = node("talker", domain);
    let publisher = node.publisher("chatter", &string, Qos::default()).unwrap();
    assert!(publisher.wait_for_matches(1, LONG));
    // the peer may match later
    std::thread::sleep(Duration::from_millis(200));
    let schema = catalogue().schema(&string).unwrap();
    for number in 0..100 {
        publisher.send(&text(&format!("number {number}"))).unwrap();
        std::thread::sleep(Duration::from_millis(1));
    }
    for number in 0..100 {
        let expected = encode(&text(&format!("number {number}")), &schema);
        peer.expect(&hex(&expected));
    }
    assert_eq!(publisher.counts().sent, 100);
    assert_eq!(publisher.counts().dropped, 0);
}

/// A reader that matches late would leave out what the first heartbeat announces before it is sent.
#[test]
fn the_first_message_after_a_match_goes_alone() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let settings = topic_settings(domain, "/chatter", &string);
    let peer = Peer::start(&python, "subscribe", &settings);
    peer.expect("ready");
    let node = node("talker", domain);
    let publisher = node.publisher("/chatter", &string, Qos::default()).unwrap();
    assert!(publisher.wait_for_matches(1, LONG));
    // it acknowledges nothing
    peer.signal("STOP");
    let begun = Instant::now();
    for number in 0..3 {
        publisher.send(&text(&number.to_string())).unwrap();
    }
    let counts = publisher.counts();
    // on a busy machine, the wait may be over
    if begun.elapsed() < Duration::from_millis(150) {
        assert_eq!((counts.sent, counts.waiting), (1, 2));
    }
    // a peer that stands still does not keep the others for long
    wait("the other messages", || {
        (publisher.counts().sent == 3).then_some(())
    });
    peer.signal("CONT");
}

#[test]
fn a_subscription_reads_what_cyclone_sends() {
    let Some(python) = python() else { return };
    for (reliability, reliable) in [
        (Reliability::Reliable, true),
        (Reliability::BestEffort, false),
    ] {
        let domain = domain();
        let twist = named("geometry_msgs/msg/Twist");
        let node = node("listener", domain);
        let qos = Qos {
            reliability,
            ..Qos::default().depth(200)
        };
        let subscription = node.subscription("/cmd_vel", &twist, qos).unwrap();
        let schema = catalogue().schema(&twist).unwrap();
        let vector = |x: f64| {
            Datum::record([
                ("x", Datum::Float(x)),
                ("y", Datum::Float(0.5)),
                ("z", Datum::Float(-x)),
            ])
        };
        let twist_of = |x| Datum::record([("linear", vector(x)), ("angular", vector(-x))]);
        let messages: Vec<Datum> = (0..100)
            .map(|number| twist_of(f64::from(number) / 3.0))
            .collect();
        let mut settings = topic_settings(domain, "/cmd_vel", &twist);
        let encoded: Vec<String> = messages
            .iter()
            .map(|it| hex(&encode(it, &schema)))
            .collect();
        settings["messages"] = encoded.into();
        settings["reliable"] = reliable.into();
        settings["pause"] = 0.002.into();
        let peer = Peer::start(&python, "publish", &settings);
        peer.expect("sent");
        let mut received = Vec::new();
        while let Some(message) = subscription.wait(Duration::from_secs(1)) {
            received.push(message.message);
        }
        let counts = subscription.counts();
        if reliable {
            assert_eq!(received, messages);
            assert_eq!(counts.lost, 0);
        } else {
            // discovery may end after the first messages; on loopback nothing else is lost
            assert!(received.len() > 50, "{counts:?}");
            assert_eq!(received, messages[100 - received.len()..]);
        }
        assert_eq!((counts.malformed, counts.dropped), (0, 0));
        assert_eq!(counts.received, received.len() as u64);
    }
}

#[test]
fn a_late_peer_gets_the_last_messages_of_a_transient_local_publisher() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let node = node("map_server", domain);
    let qos = Qos {
        durability: Durability::TransientLocal,
        ..Qos::default().depth(3)
    };
    let publisher = node.publisher("/map", &string, qos).unwrap();
    for number in 0..10 {
        publisher.send(&text(&format!("{number}"))).unwrap();
    }
    let mut settings = topic_settings(domain, "/map", &string);
    settings["transient"] = true.into();
    let late = Peer::start(&python, "subscribe", &settings);
    late.expect("ready");
    let schema = catalogue().schema(&string).unwrap();
    let mut lines = vec![late.line()];
    lines.extend(late.lines_for(Duration::from_secs(1)));
    let last = ["7", "8", "9"].map(|it| hex(&encode(&text(it), &schema)));
    // rustdds keeps more than the depth until it cleans up
    assert!(lines.ends_with(&last), "{lines:?}");
    publisher.send(&text("10")).unwrap();
    late.expect(&hex(&encode(&text("10"), &schema)));
}

#[test]
fn a_late_subscription_gets_the_last_messages_of_cyclone() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let schema = catalogue().schema(&string).unwrap();
    let mut settings = topic_settings(domain, "/map", &string);
    let all = (0..5).map(|number| hex(&encode(&text(&number.to_string()), &schema)));
    settings["messages"] = all.collect::<Vec<_>>().into();
    for (key, value) in [("transient", true), ("early", true)] {
        settings[key] = value.into();
    }
    settings["depth"] = 2.into();
    let peer = Peer::start(&python, "publish", &settings);
    peer.expect("sent");
    let node = node("late", domain);
    let transient = Qos {
        durability: Durability::TransientLocal,
        ..Qos::default()
    };
    let late = node.subscription("/map", &string, transient).unwrap();
    let volatile = node.subscription("/map", &string, Qos::default()).unwrap();
    let got: Vec<_> = (0..2)
        .map(|_| late.wait(LONG).expect("a message").message)
        .collect();
    assert_eq!(got, [text("3"), text("4")]);
    assert!(volatile.wait_for_matches(1, LONG));
}

#[test]
fn a_volatile_publisher_gives_late_peers_nothing_of_before() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let schema = catalogue().schema(&string).unwrap();
    let node = node("sensor", domain);
    let publisher = node.publisher("/word", &string, Qos::default()).unwrap();
    publisher.send(&text("before")).unwrap();
    let settings = topic_settings(domain, "/word", &string);
    let late = Peer::start(&python, "subscribe", &settings);
    late.expect("ready");
    assert!(publisher.wait_for_matches(1, LONG));
    // the peer may match later
    let (until, mut lines) = (Instant::now() + LONG, Vec::new());
    while lines.is_empty() {
        assert!(Instant::now() < until, "nothing arrives");
        publisher.send(&text("after")).unwrap();
        lines = late.lines_for(Duration::from_millis(200));
    }
    let after = hex(&encode(&text("after"), &schema));
    assert!(lines.iter().all(|line| *line == after), "{lines:?}");
    // one that requests earlier messages does not match, and both sides are named
    let mut settings = topic_settings(domain, "/word", &string);
    settings["transient"] = true.into();
    let transient = Peer::start(&python, "subscribe", &settings);
    transient.expect("ready");
    let until = Instant::now() + LONG;
    loop {
        let mut notices = node.take_notices().into_iter();
        let of_qos = notices.find(|it| matches!(it, Notice::Qos { .. }));
        if let Some(Notice::Qos {
            here, there, kind, ..
        }) = of_qos
        {
            assert_eq!(kind, EndpointKind::Reader);
            assert_ne!(here, there);
            break;
        }
        assert!(Instant::now() < until, "no notice");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(publisher.matches(), 1);
}

#[test]
fn large_messages_are_fragmented_both_ways() {
    let Some(python) = python() else { return };
    let domain = domain();
    let image = named("sensor_msgs/msg/Image");
    let schema = catalogue().schema(&image).unwrap();
    let pixels: Vec<u8> = (0..2_000_000_u32)
        .map(|index| (index * 7 % 251) as u8)
        .collect();
    let stamp = Datum::record([("sec", Datum::Int(1)), ("nanosec", Datum::Int(2))]);
    let header = Datum::record([("stamp", stamp), ("frame_id", Datum::text("camera"))]);
    let message = Datum::record([
        ("header", header),
        ("height", Datum::Int(1000)),
        ("width", Datum::Int(2000)),
        ("encoding", Datum::text("mono8")),
        ("is_bigendian", Datum::Int(0)),
        ("step", Datum::Int(2000)),
        ("data", Datum::Bytes(pixels.into())),
    ]);
    let peer = Peer::start(
        &python,
        "subscribe",
        &topic_settings(domain, "/image", &image),
    );
    peer.expect("ready");
    let (node, viewer) = (node("camera", domain), node("viewer", domain));
    let publisher = node.publisher("/image", &image, Qos::default()).unwrap();
    let subscription = viewer
        .subscription("/image", &image, Qos::default())
        .unwrap();
    assert!(publisher.wait_for_matches(2, LONG));
    std::thread::sleep(Duration::from_millis(200));
    publisher.send(&message).unwrap();
    assert_eq!(peer.line(), hex(&encode(&message, &schema)));
    assert_eq!(subscription.wait(LONG).expect("an image").message, message);
    // back: a scan of 20 000 ranges, since the peer takes its messages from its command line
    drop(subscription);
    let array = named("std_msgs/msg/Float64MultiArray");
    let schema = catalogue().schema(&array).unwrap();
    let numbers = (0..8000)
        .map(|number| Datum::Float(f64::from(number) / 7.0))
        .collect();
    let layout = Datum::record([("dim", Datum::List(vec![])), ("data_offset", Datum::Int(0))]);
    let message = Datum::record([("layout", layout), ("data", Datum::List(numbers))]);
    let bytes = encode(&message, &schema);
    assert!(bytes.len() > 60_000);
    let subscription = node.subscription("/array", &array, Qos::default()).unwrap();
    let mut settings = topic_settings(domain, "/array", &array);
    // an argument has at most 128 KiB
    settings["messages"] = vec![hex(&bytes[..])].into();
    let back = Peer::start(&python, "publish", &settings);
    back.expect("sent");
    let received = subscription.wait(LONG).expect("an array").message;
    assert_eq!(encode(&received, &schema), bytes);
}

#[test]
fn a_queue_that_is_full_drops_the_oldest_and_counts() {
    let domain = domain();
    let (sender, receiver) = (node("sender", domain), node("receiver", domain));
    let string = named("std_msgs/msg/String");
    let publisher = sender.publisher("/x", &string, Qos::default()).unwrap();
    let subscription = receiver
        .subscription("/x", &string, Qos::default().depth(4))
        .unwrap();
    assert!(publisher.wait_for_matches(1, LONG) && subscription.wait_for_matches(1, LONG));
    for number in 0..10 {
        publisher.send(&text(&number.to_string())).unwrap();
    }
    wait("ten messages", || {
        (subscription.counts().received == 10).then_some(())
    });
    let left: Vec<_> = std::iter::from_fn(|| subscription.take()).collect();
    let texts: Vec<_> = left.iter().map(|it| it.message.clone()).collect();
    assert_eq!(texts, ["6", "7", "8", "9"].map(text));
    let numbers: Vec<_> = left.iter().map(|it| it.sequence).collect();
    assert!(numbers.is_sorted() && left[0].writer == publisher.gid());
    assert_eq!(subscription.counts().dropped, 6);
    assert_eq!(subscription.counts().lost, 0);
}

#[test]
fn other_domains_are_not_seen() {
    let (one, other) = (node("one", domain()), node("other", domain()));
    let string = named("std_msgs/msg/String");
    let publisher = one.publisher("/x", &string, Qos::default()).unwrap();
    let _subscription = other.subscription("/x", &string, Qos::default()).unwrap();
    assert!(!publisher.wait_for_matches(1, Duration::from_secs(2)));
}

#[test]
fn what_is_not_a_message_is_refused() {
    let node = node("n", domain());
    let service = named("std_srvs/srv/Trigger");
    let refused = node.publisher("/x", &service, Qos::default()).map(drop);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "`std_srvs/srv/Trigger` is no message"
    );
    let undefined = node.subscription("/x", &named("no_msgs/msg/Thing"), Qos::default());
    assert!(matches!(
        undefined.map(drop),
        Err(EndpointError::Definition(_))
    ));
    let string = named("std_msgs/msg/String");
    let wrong = node.publisher("/a b", &string, Qos::default()).map(drop);
    assert!(
        wrong
            .unwrap_err()
            .to_string()
            .starts_with("`/a b` is not a name: it has signs")
    );
    let publisher = node.publisher("/x", &string, Qos::default()).unwrap();
    let twisted = publisher.send(&Datum::record([("data", Datum::Int(1))]));
    assert!(twisted.unwrap_err().to_string().starts_with("`data`: "));
}

#[test]
fn a_subscription_leaves_out_its_own_node_and_calls_its_waker() {
    let domain = domain();
    // all networks: on the loopback interface alone, a node does not hear itself
    let start = |name: &str| {
        let options = NodeOptions {
            domain,
            ..NodeOptions::named(name)
        };
        Node::start(options, catalogue()).unwrap()
    };
    let (own, other) = (start("own"), start("other"));
    let string = named("std_msgs/msg/String");
    let woken = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&woken);
    let options = SubscriptionOptions {
        ignores_own: true,
        waker: Some(Arc::new(move || {
            count.fetch_add(1, Ordering::SeqCst);
        })),
        ..SubscriptionOptions::default()
    };
    let others = own.subscription("/x", &string, options).unwrap();
    let all = own.subscription("/x", &string, Qos::default()).unwrap();
    let publishers = [&own, &other].map(|node| {
        let publisher = node.publisher("/x", &string, Qos::default()).unwrap();
        assert!(publisher.wait_for_matches(2, LONG));
        publisher
    });
    assert!(others.wait_for_matches(2, LONG) && all.wait_for_matches(2, LONG));
    publishers[0].send(&text("own")).unwrap();
    let received = all.wait(LONG).expect("a message");
    assert_eq!(
        (received.message, received.writer),
        (text("own"), publishers[0].gid())
    );
    publishers[1].send(&text("other")).unwrap();
    let received = others.wait(LONG).expect("a message");
    assert_eq!(received.message, text("other"));
    assert_eq!(others.take(), None);
    let counts = others.counts();
    assert_eq!((counts.received, counts.lost), (1, 0));
    // it is called after the message is there
    wait("a call", || {
        (woken.load(Ordering::SeqCst) == 1).then_some(())
    });
}

#[test]
fn each_gap_longer_than_the_deadline_is_noticed_once() {
    let domain = domain();
    let (one, other) = (node("one", domain), node("other", domain));
    let string = named("std_msgs/msg/String");
    let deadline = Qos {
        deadline: Some(Duration::from_millis(300)),
        ..Qos::default()
    };
    let woken = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&woken);
    one.wake_for_notices(Arc::new(move || {
        count.fetch_add(1, Ordering::SeqCst);
    }));
    let subscription = one.subscription("/x", &string, deadline).unwrap();
    // without a publisher there is no gap
    std::thread::sleep(Duration::from_millis(800));
    assert_eq!(subscription.counts().late, 0);
    let publisher = other.publisher("/x", &string, deadline).unwrap();
    assert!(publisher.wait_for_matches(1, LONG) && subscription.wait_for_matches(1, LONG));
    for gap in 1..=2 {
        for _ in 0..5 {
            publisher.send(&text("beat")).unwrap();
            std::thread::sleep(Duration::from_millis(100));
        }
        wait("a gap", || {
            (subscription.counts().late == gap).then_some(())
        });
        std::thread::sleep(Duration::from_millis(500));
        assert_eq!(subscription.counts().late, gap);
    }
    let is_gap =
        |notice: &Notice| matches!(notice, Notice::Deadline { topic, .. } if topic == "rt/x");
    let gaps = one.take_notices().iter().filter(|it| is_gap(it)).count();
    assert_eq!(gaps, 2);
    assert!(woken.load(Ordering::SeqCst) >= 2);
}
