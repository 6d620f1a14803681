//! Simulated time, with a node of rospy that lives in it.

use asmotion_ros1::{RosClock, clock_message};

use asmotion_ros_master::{Master, eventually, notifier, topic_type};

#[test]
fn the_clock_is_followed_by_rospy_and_by_this_library() {
    let Some(master) = Master::start() else {
        return;
    };
    let (simulator, follower) = (master.node("/simulator"), master.node("/follower"));
    let of = topic_type("rosgraph_msgs/Clock");
    let publisher = simulator
        .node
        .publisher("/clock", of.clone(), 1, false)
        .unwrap();
    let mut clock = RosClock::follow(&follower.node, of, notifier()).unwrap();
    assert_eq!(clock.now(), None);
    simulator.registered();
    let mut peer = master.peer("clock", &["peer"]);
    assert_eq!(peer.line(), "ready");
    eventually("both follow", || {
        (publisher.counts().subscribers.len() == 2).then_some(())
    });
    // forwards, and back: a simulator was reset
    for time in [1_500_000_000, 3_000_000_001, 2_000_000_000] {
        publisher.publish(&clock_message(time)).unwrap();
        eventually("this library has the time", || {
            (clock.now() == Some(time)).then_some(())
        });
        eventually("rospy has the time", || {
            peer.tell("time");
            (peer.line() == time.to_string()).then_some(())
        });
    }
}
