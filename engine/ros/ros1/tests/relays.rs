//! Nodes that relay between topics, and the thread that reads topics.

use std::sync::mpsc::RecvTimeoutError;
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use asmotion_bus::Subscription;
use asmotion_ros_master::{Master, SOON, TestNode, all, eventually, notifier, string, topic_type};
use asmotion_ros1::{RosNode, RosNotice, RosPublisher};

/// A node that relays one topic to another, as far as others see.
struct Relay {
    node: TestNode,
    publisher: RosPublisher,
    heard: Subscription,
}

fn relay(master: &Master, name: &str, from: &str, to: &str) -> Relay {
    let node = TestNode::start(master.port, name, |settings| {
        settings.relays = vec![(from.to_owned(), to.to_owned())];
    });
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher(to, of.clone(), 10, false).unwrap();
    let heard = node.node.subscribe(from, Some(of), all(10), notifier());
    node.registered();
    Relay {
        publisher,
        heard: heard.unwrap(),
        node,
    }
}

impl Relay {
    /// Why it does not receive.
    fn refusal(&self) -> String {
        self.node.notice("a refusal", |notice| {
            let RosNotice::Disconnected { reason, .. } = notice else {
                return None;
            };
            reason.contains("go round").then(|| reason.clone())
        })
    }
}

#[test]
fn a_circle_of_three_relays_is_opened_by_those_that_notice_it() {
    let Some(master) = Master::start() else {
        return;
    };
    let first = relay(&master, "/first", "/a", "/b");
    let second = relay(&master, "/second", "/b", "/c");
    let count = |of: &Relay| of.publisher.counts().subscribers.len();
    eventually("the second hears the first", || {
        (count(&first) == 1).then_some(())
    });
    let third = relay(&master, "/third", "/c", "/a");
    assert_eq!(
        third.refusal(),
        "messages would go round: `/second` relays `/b` to `/c`, and this node `/c` to `/a`, from where they come through `/a`, `/b`"
    );
    assert_eq!(
        first.refusal(),
        "messages would go round: `/third` relays `/c` to `/a`, and this node `/a` to `/b`, from where they come through `/b`, `/c`"
    );
    first.publisher.publish(&string("word")).unwrap();
    let heard = second.heard.next_within(SOON).expect("a message");
    assert_eq!(heard.payload.to_datum().unwrap(), string("word"));
    for other in [&second, &third] {
        other.publisher.publish(&string("round")).unwrap();
        eventually("a look", || {
            (other.publisher.counts().published == 1).then_some(())
        });
    }
    assert!(
        first
            .heard
            .next_within(Duration::from_millis(300))
            .is_none()
    );
    assert!(third.heard.try_next().is_none());
}

#[test]
fn relays_that_lead_elsewhere_receive() {
    let Some(master) = Master::start() else {
        return;
    };
    let first = relay(&master, "/first", "/a", "/b");
    let second = relay(&master, "/second", "/b", "/c");
    let third = relay(&master, "/third", "/c", "/d");
    let of = topic_type("std_msgs/String");
    let rospy = master.node("/driver");
    let _other = rospy.node.publisher("/a", of, 1, false).unwrap();
    for (from, to) in [(&first, &second), (&second, &third)] {
        eventually("a subscriber", || {
            (from.publisher.counts().subscribers.len() == 1).then_some(())
        });
        from.publisher.publish(&string("word")).unwrap();
        assert!(to.heard.next_within(SOON).is_some());
    }
}

/// A node whose reading thread calls a function.
fn reading(
    master: &Master,
    after_reading: impl Fn() + Send + Sync + 'static,
) -> (RosNode, Subscription) {
    let node = TestNode::start(master.port, "/reader", |settings| {
        settings.after_reading = Some(Arc::new(after_reading));
    });
    let of = topic_type("std_msgs/String");
    let heard = node.node.subscribe("/said", Some(of), all(10), notifier());
    node.registered();
    (node.node, heard.unwrap())
}

#[test]
fn the_thread_that_reads_topics_calls_the_owner_after_each_message() {
    let Some(master) = Master::start() else {
        return;
    };
    let (sender, calls) = mpsc::channel();
    let (node, heard) = reading(&master, move || {
        let thread = std::thread::current();
        let is_async = tokio::runtime::Handle::try_current().is_ok();
        sender.send((thread.id(), is_async)).unwrap();
    });
    let talker = master.node("/talker");
    let of = topic_type("std_msgs/String");
    let publisher = talker.node.publisher("/said", of, 10, false).unwrap();
    eventually("a subscriber", || {
        (publisher.counts().subscribers.len() == 1).then_some(())
    });
    let mut threads = Vec::new();
    for text in ["one", "two", "three"] {
        publisher.publish(&string(text)).unwrap();
        let (thread, is_async) = calls.recv_timeout(SOON).unwrap();
        // it may block
        assert!(!is_async);
        threads.push(thread);
        let envelope = heard
            .try_next()
            .expect("the message is there before the call");
        assert_eq!(envelope.payload.to_datum().unwrap(), string(text));
    }
    threads.dedup();
    assert_eq!(threads.len(), 1);
    assert_ne!(threads[0], std::thread::current().id());
    drop((node, heard));
    // the thread is over, and its function with it
    assert_eq!(
        calls.recv_timeout(SOON),
        Err(RecvTimeoutError::Disconnected)
    );
}

#[test]
fn the_thread_that_reads_topics_may_drop_the_node() {
    let Some(master) = Master::start() else {
        return;
    };
    let kept: Arc<Mutex<Option<(RosNode, Subscription)>>> = Arc::default();
    let (taken, (sender, dropped)) = (Arc::clone(&kept), mpsc::channel());
    let node = reading(&master, move || {
        if taken.lock().unwrap().take().is_some() {
            sender.send(()).unwrap();
        }
    });
    *kept.lock().unwrap() = Some(node);
    let talker = master.node("/talker");
    let of = topic_type("std_msgs/String");
    let publisher = talker.node.publisher("/said", of, 10, false).unwrap();
    eventually("a subscriber", || {
        (publisher.counts().subscribers.len() == 1).then_some(())
    });
    publisher.publish(&string("end")).unwrap();
    dropped.recv_timeout(SOON).unwrap();
    eventually("the subscriber has left", || {
        publisher.counts().subscribers.is_empty().then_some(())
    });
    // the thread ends, too, and drops its function
    assert_eq!(
        dropped.recv_timeout(SOON),
        Err(RecvTimeoutError::Disconnected)
    );
}
