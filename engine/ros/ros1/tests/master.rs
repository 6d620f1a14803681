//! The master is killed and restarted.

use std::time::{Duration, Instant};

use asmotion_bus::{CallFailure, LinkState};
use asmotion_ros1::RosNotice;

use asmotion_ros_master::{
    Master, SOON, all, eventually, notifier, service_type, string, topic_type,
};

#[test]
fn all_registrations_are_made_again_when_the_master_restarts() {
    let Some(mut master) = Master::start() else {
        return;
    };
    let node = master.node("/robot");
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher("said", of.clone(), 100, false).unwrap();
    let heard = node
        .node
        .subscribe("heard", Some(of), all(100), notifier())
        .unwrap();
    let _served = node
        .node
        .serve("stop", service_type("std_srvs", "SetBool"), 1, notifier())
        .unwrap();
    let followed = node
        .node
        .follow_parameter("speed", all(10), notifier())
        .unwrap();
    node.registered();
    let listener = master.peer("listener", &["before", "/said", "std_msgs", "String", "0"]);
    assert_eq!(listener.line(), "connected");
    // its last call to the master is over when it has a header, and the publisher knows it after that
    eventually("the publisher has the listener", || {
        (publisher.counts().subscribers.len() == 1).then_some(())
    });
    assert!(followed.next_within(SOON).is_some());

    for round in 0..3 {
        master.kill();
        // the call that was under way ends in another way than those after it
        eventually("the loss is noticed", || {
            let LinkState::Down { reason } = node.node.health().link else {
                return None;
            };
            reason.contains("efused").then_some(())
        });
        // connections between nodes go on without a master
        publisher
            .publish(&string(&format!("without {round}")))
            .unwrap();
        assert_eq!(listener.line(), format!("data: \"without {round}\""));
        let failure = node
            .node
            .parameter("speed", SOON, notifier())
            .unwrap()
            .wait();
        assert_eq!(failure.unwrap_err(), CallFailure::Unavailable);
        // something new while it is down
        let late = node.node.publisher(
            &format!("late_{round}"),
            topic_type("std_msgs/Bool"),
            1,
            false,
        );
        master.restart();
        node.registered();
        let info = master.tool("rosnode", &["info", "/robot"]);
        for line in [
            "/said [std_msgs/String]",
            "/heard [",
            "* /stop",
            &format!("* /late_{round} ["),
        ] {
            assert!(info.contains(line), "{line}: {info}");
        }
        drop(late);
        // new nodes find it
        let name = format!("talker_{round}");
        let mut talker = master.peer("talker", &[&name, "/heard", "once"]);
        assert_eq!(talker.line(), "ready");
        talker.tell("await 1");
        assert_eq!(talker.line(), "connected");
        talker.tell("say again");
        let envelope = heard.next_within(SOON).expect("a message");
        assert_eq!(&*envelope.source, format!("/{name}"));
        assert!(heard.try_next().is_none());
        let mut parameters = master.peer("parameters", &["parameters"]);
        assert_eq!(parameters.line(), "ready");
        parameters.tell(&format!("set /speed {round}"));
        eventually("the parameter is followed again", || {
            let envelope = followed.try_next()?;
            let datum = envelope.payload.to_datum().unwrap();
            (datum.as_int() == Some(round)).then_some(())
        });
    }
    let notices = node.notices();
    let losses = notices
        .iter()
        .filter(|it| matches!(it, RosNotice::Unregistered { .. }));
    assert!(losses.count() >= 3, "{notices:?}");
    let gains = notices
        .iter()
        .filter(|it| matches!(it, RosNotice::Registered { .. }));
    assert_eq!(gains.count(), 4, "{notices:?}");
}

#[test]
fn attempts_are_bounded_while_the_master_is_down() {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let closed = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = closed.local_addr().unwrap().port();
    let attempts = Arc::new(AtomicUsize::new(0));
    std::thread::spawn({
        let attempts = Arc::clone(&attempts);
        move || {
            // accepts, and closes
            for stream in closed.incoming() {
                drop(stream);
                attempts.fetch_add(1, Ordering::SeqCst);
            }
        }
    });
    let begun = Instant::now();
    let node = asmotion_ros_master::TestNode::start(port, "/robot", |_| ());
    let flags: Vec<_> = (0..50)
        .map(|number| {
            node.node.publisher(
                &format!("flag_{number}"),
                topic_type("std_msgs/Bool"),
                1,
                false,
            )
        })
        .collect();
    let attempted = eventually("six attempts", || {
        let count = attempts.load(Ordering::SeqCst);
        (count >= 6).then(|| (count, begun.elapsed()))
    });
    // the second one 0.1 s after the first, then 0.2, 0.4, 0.5 and 0.5 s
    let (count, elapsed) = attempted;
    assert!(
        elapsed > Duration::from_millis(1650),
        "{count} in {elapsed:?}"
    );
    assert_eq!(flags.iter().filter(|it| it.is_ok()).count(), 50);
    assert!(!node.node.health().is_up());
}
