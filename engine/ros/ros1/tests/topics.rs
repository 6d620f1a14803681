//! Topics, with publishers and subscribers of rospy.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use asmotion_bus::{Notifier, Subscription};
use asmotion_datum::Datum;
use asmotion_ros1::{RosError, RosNotice, TypeMismatch};

use asmotion_ros_master::{Master, SOON, all, eventually, notifier, string, topic_type};

fn text(subscription: &Subscription) -> (String, String) {
    let envelope = subscription.next_within(SOON).expect("a message");
    let datum = envelope.payload.to_datum().unwrap();
    let text = datum.get("data").unwrap().as_text().unwrap().to_owned();
    (envelope.source.to_string(), text)
}

#[test]
fn r12_rospy_receives_each_message_once_and_in_order() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/talker");
    let publisher = node
        .node
        .publisher("chatter", topic_type("std_msgs/String"), 100, false)
        .unwrap();
    node.registered();
    let peers = ["/one", "/two"]
        .map(|name| master.peer("listener", &[name, "/chatter", "std_msgs", "String", "0"]));
    for peer in &peers {
        assert_eq!(peer.line(), "connected");
    }
    eventually("both are subscribers", || {
        (publisher.counts().subscribers.len() == 2).then_some(())
    });
    for number in 0..50 {
        publisher.publish(&string(&format!("n{number}"))).unwrap();
    }
    for peer in &peers {
        for number in 0..50 {
            assert_eq!(peer.line(), format!("data: \"n{number}\""));
        }
    }
    let counts = publisher.counts();
    assert_eq!(
        (counts.published, counts.sent, counts.dropped),
        (50, 100, 0)
    );
    let mut names: Vec<_> = counts.subscribers.iter().map(|it| &*it.node).collect();
    names.sort_unstable();
    assert_eq!(names, ["/one", "/two"]);
    let [one, two] = peers;
    drop(one);
    eventually("one has left", || {
        (publisher.counts().subscribers.len() == 1).then_some(())
    });
    drop(two);
}

#[test]
fn a_latched_message_reaches_late_subscribers_both_ways() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/latched");
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher("map", of.clone(), 1, true).unwrap();
    publisher.publish(&string("old")).unwrap();
    publisher.publish(&string("last")).unwrap();
    node.registered();
    let peer = master.peer("listener", &["/late", "/map", "std_msgs", "String", "0"]);
    let mut lines = [peer.line(), peer.line()];
    lines.sort_unstable();
    assert_eq!(lines, ["connected", "data: \"last\""]);
    let mut talker = master.peer("talker", &["/other", "/latch_2", "latch"]);
    assert_eq!(talker.line(), "ready");
    talker.tell("say kept");
    std::thread::sleep(Duration::from_millis(200));
    let late = node
        .node
        .subscribe("/latch_2", Some(of), all(10), notifier());
    let (source, said) = text(&late.unwrap());
    assert_eq!((&*source, &*said), ("/other", "kept"));
}

#[test]
fn r4_several_observers_see_every_message_of_several_publishers_once() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/observer");
    let of = || Some(topic_type("std_msgs/String"));
    let observers = [1, 2, 3].map(|_| {
        node.node
            .subscribe("/chatter", of(), all(1000), notifier())
            .unwrap()
    });
    node.registered();
    let mut peers = ["/one", "/two"].map(|name| master.peer("talker", &[name, "/chatter", "once"]));
    for peer in &mut peers {
        assert_eq!(peer.line(), "ready");
        peer.tell("await 1");
        assert_eq!(peer.line(), "connected");
    }
    eventually("both are connected", || {
        let counts = node.node.subscription_counts("/chatter").unwrap().unwrap();
        (counts.publishers == 2).then_some(())
    });
    for peer in &mut peers {
        peer.tell("count 200");
    }
    for observer in &observers {
        let mut next = [0, 0];
        for _ in 0..400 {
            let (source, said) = text(observer);
            let peer = usize::from(source == "/two");
            assert_eq!(said, next[peer].to_string(), "{source}");
            next[peer] += 1;
        }
        assert_eq!(next, [200, 200]);
        assert!(observer.try_next().is_none());
        assert_eq!(observer.dropped(), 0);
    }
    drop(observers);
    assert_eq!(node.node.subscription_counts("/chatter").unwrap(), None);
    eventually("it is unregistered", || {
        let topics = node.node.graph().unwrap().topics;
        topics["/chatter"].subscribers.is_empty().then_some(())
    });
}

#[test]
fn r5_an_observer_that_panics_is_isolated_and_counted() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/observer");
    let of = || Some(topic_type("std_msgs/String"));
    let calls = Arc::new(AtomicU64::new(0));
    let panicking = Notifier::calling({
        let calls = Arc::clone(&calls);
        move || {
            calls.fetch_add(1, Ordering::SeqCst);
            panic!("an observer of a test panics");
        }
    });
    let bad = node
        .node
        .subscribe("/chatter", of(), all(10), Arc::new(panicking));
    let bad = bad.unwrap();
    let good = node
        .node
        .subscribe("/chatter", of(), all(10), notifier())
        .unwrap();
    node.registered();
    let mut peer = master.peer("talker", &["/talker", "/chatter", "once"]);
    assert_eq!(peer.line(), "ready");
    peer.tell("await 1");
    assert_eq!(peer.line(), "connected");
    peer.tell("say one");
    peer.tell("say two");
    assert_eq!(text(&good).1, "one");
    assert_eq!(text(&good).1, "two");
    assert_eq!(calls.load(Ordering::SeqCst), 1);
    let counts = node.node.subscription_counts("/chatter").unwrap().unwrap();
    assert_eq!((counts.panicked, counts.received), (1, 2));
    drop(bad);
}

#[test]
fn a_subscriber_that_stops_reading_delays_no_other_and_its_drops_are_counted() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/talker");
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher("chatter", of, 8, false).unwrap();
    node.registered();
    let start = |name| master.peer("listener", &[name, "/chatter", "std_msgs", "String", "0"]);
    let (stopped, reading) = (start("/stopped"), start("/reading"));
    assert_eq!(
        (&*stopped.line(), &*reading.line()),
        ("connected", "connected")
    );
    eventually("both are subscribers", || {
        (publisher.counts().subscribers.len() == 2).then_some(())
    });
    stopped.signal("STOP");
    let large = "x".repeat(64 << 10);
    for number in 0..200 {
        publisher
            .publish(&string(&format!("{number} {large}")))
            .unwrap();
        let line = reading.line();
        assert!(
            line.starts_with(&format!("data: \"{number} x")),
            "{line:.20}"
        );
    }
    let counts = publisher.counts();
    let of = |name: &str| {
        counts
            .subscribers
            .iter()
            .find(|it| &*it.node == name)
            .unwrap()
    };
    let (stopped_counts, reading_counts) = (of("/stopped"), of("/reading"));
    assert_eq!((reading_counts.sent, reading_counts.dropped), (200, 0));
    assert!(stopped_counts.dropped > 50, "{stopped_counts:?}");
    assert!(stopped_counts.waiting <= 8, "{stopped_counts:?}");
    stopped.signal("CONT");
    // it goes on with the newest ones
    eventually("the last message arrives", || {
        stopped.line().starts_with("data: \"199 x").then_some(())
    });
}

fn mismatch(notice: &RosNotice) -> Option<TypeMismatch> {
    match notice {
        RosNotice::Mismatch(mismatch) => Some((**mismatch).clone()),
        RosNotice::Registered { .. }
        | RosNotice::Unregistered { .. }
        | RosNotice::Ended { .. }
        | RosNotice::Disconnected { .. }
        | RosNotice::Unreadable { .. } => None,
    }
}

#[test]
fn another_type_is_refused_with_both_definitions() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/typed");
    let publisher = node
        .node
        .publisher("chatter", topic_type("std_msgs/String"), 8, false);
    let publisher = publisher.unwrap();
    node.registered();
    let _listener = master.peer("listener", &["/wrong", "/chatter", "std_msgs", "Bool", "0"]);
    let found = node.notice("the subscriber has another type", mismatch);
    assert_eq!((&*found.of, &*found.there.node), ("/chatter", "/wrong"));
    assert_eq!(
        (&*found.here.name, &*found.there.name),
        ("std_msgs/String", "std_msgs/Bool")
    );
    assert_eq!(found.here.definition.trim(), "string data");
    assert!(found.there.definition.contains("bool data"), "{found}");
    assert!(publisher.counts().refused >= 1);
    assert!(publisher.counts().subscribers.is_empty());

    let other = master.node("/other");
    let wrong = Some(topic_type("geometry_msgs/Point"));
    let _subscription = other.node.subscribe("/spoken", wrong, all(1), notifier());
    let talker = master.peer("talker", &["/speaker", "/spoken", "once"]);
    assert_eq!(talker.line(), "ready");
    let found = other.notice("the publisher has another type", mismatch);
    assert_eq!((&*found.of, &*found.there.node), ("/spoken", "/speaker"));
    assert_eq!(&*found.there.name, "std_msgs/String");
    assert!(found.there.definition.contains("string data"), "{found}");
    assert!(found.here.definition.contains("float64 x"), "{found}");
    assert!(
        found.to_string().contains("\n  here: float64 x\n"),
        "{found}"
    );
    let counts = other.node.subscription_counts("/spoken").unwrap().unwrap();
    assert!(counts.refused >= 1 && counts.received == 0, "{counts:?}");
}

#[test]
fn a_subscription_without_a_type_reads_by_the_definition_of_the_publisher() {
    let Some(master) = Master::start() else {
        return;
    };
    let (from, to) = (master.node("/from"), master.node("/to"));
    let of = topic_type("geometry_msgs/PoseStamped");
    let publisher = from.node.publisher("pose", of.clone(), 1, true).unwrap();
    let pose = asmotion_datum::ros1::decode(&[0; 4 * 4 + 7 * 8], &of.schema).unwrap();
    publisher.publish(&pose).unwrap();
    from.registered();
    let any = to.node.subscribe("pose", None, all(1), notifier()).unwrap();
    let envelope = any.next_within(SOON).expect("a message");
    assert_eq!(&*envelope.type_name, "geometry_msgs/PoseStamped");
    assert_eq!(envelope.payload.to_datum().unwrap(), pose);
    let mut talker = master.peer("talker", &["/speaker", "/spoken", "latch"]);
    talker.tell("say hello");
    let any = to
        .node
        .subscribe("/spoken", None, all(1), notifier())
        .unwrap();
    assert_eq!(text(&any), ("/speaker".to_owned(), "hello".to_owned()));
}

#[test]
fn r3_a_topic_is_declared_once() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/a/b");
    let (text, flag) = (topic_type("std_msgs/String"), topic_type("std_msgs/Bool"));
    let publisher = node.node.publisher("c", text.clone(), 1, false).unwrap();
    let again = node
        .node
        .publisher("/a/c", flag.clone(), 1, false)
        .unwrap_err();
    let expected = RosError::Published {
        topic: "/a/c".to_owned(),
        declared: "std_msgs/String".to_owned(),
        again: "std_msgs/Bool".to_owned(),
    };
    assert_eq!(again, expected);
    drop(publisher);
    assert!(node.node.publisher("/a/c", flag.clone(), 1, false).is_ok());
    let _first = node
        .node
        .subscribe("d", Some(text), all(1), notifier())
        .unwrap();
    let again = node.node.subscribe("d", Some(flag), all(1), notifier());
    assert!(matches!(again, Err(RosError::SubscribedOtherwise { .. })));
    assert!(
        node.node
            .publisher("a b", topic_type("std_msgs/Bool"), 1, false)
            .is_err()
    );
}

#[test]
fn a_message_that_does_not_follow_the_type_is_an_error() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/typed");
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher("chatter", of, 1, false).unwrap();
    assert!(publisher.publish(&Datum::Int(1)).is_err());
    assert_eq!(publisher.counts().published, 0);
}
