//! Peers of ROS 2 itself: rclpy on Fast DDS, in both directions.

use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros_domain::{RclpyNode, rclpy, test_definitions};
use asmotion_ros_interface::{Catalogue, Distribution};
use asmotion_ros2::{
    Durability, GoalEvent, GoalRequest, GoalStatus, Node, NodeOptions, Qos, ServiceMapping,
};
use serde_json::json;

use crate::peer::{LONG, domain, named, text, wait};

const SET: &str = "std_srvs/srv/SetBool";
const FIBONACCI: &str = "test_msgs/action/Fibonacci";
const STRING: &str = "std_msgs/msg/String";

/// A node that knows the definitions of `test_msgs` too.
fn node(name: &str, domain: u16) -> Node {
    let mut catalogue = Catalogue::included(Distribution::Ros2);
    catalogue.add_folder(&test_definitions()).unwrap();
    let options = NodeOptions {
        domain,
        networks: vec![Ipv4Addr::LOCALHOST.into()],
        ..NodeOptions::named(name)
    };
    Node::start(options, Arc::new(catalogue)).unwrap()
}

fn flag(data: bool) -> Datum {
    Datum::record([("data", Datum::Bool(data))])
}

fn answer(success: bool, message: &str) -> Datum {
    Datum::record([
        ("success", Datum::Bool(success)),
        ("message", Datum::text(message)),
    ])
}

fn sequence(number: i64) -> Datum {
    Datum::record([("sequence", Datum::List(vec![Datum::Int(number)]))])
}

#[test]
fn services_are_called_in_both_directions() {
    let Some(python) = rclpy() else { return };
    let domain = domain();
    let mut peer = RclpyNode::start(&python, domain, "peer");
    let reply = json!({"success": true, "message": "größe"});
    peer.obey(&json!(["provide", "/grip", SET, reply]));
    let node = node("here", domain);
    let client = node
        .client("/grip", &named(SET), ServiceMapping::OfPeer)
        .unwrap();
    for data in [true, false] {
        let reply = client.call(&flag(data), LONG).wait();
        assert_eq!(reply, Ok(answer(true, "größe")));
        assert_eq!(peer.event("request", "/grip"), [json!({"data": data})]);
    }
    let counts = client.counts();
    assert_eq!((counts.sent, counts.responses, counts.malformed), (2, 2, 0));

    let server = node
        .server("/stop", &named(SET), ServiceMapping::OfPeer, 64)
        .unwrap();
    // a burst: the replies are told apart by the numbers of their requests
    for number in 0..10 {
        let data = number % 2 == 0;
        peer.obey(&json!(["call", "/stop", SET, {"data": data}]));
    }
    let requests: Vec<_> = (0..10)
        .map(|_| server.wait(LONG).expect("a request"))
        .collect();
    for request in &requests {
        let data = request.request.get("data").unwrap().as_bool() == Some(true);
        let message = if data { "even" } else { "odd" };
        server
            .reply(&request.reply_to, &answer(data, message))
            .unwrap();
    }
    let mut replies: Vec<_> = (0..10)
        .map(|_| peer.event("response", "/stop")[0].to_string())
        .collect();
    replies.sort();
    let of = |success, message| json!({"success": success, "message": message}).to_string();
    assert_eq!(replies[..5], vec![of(true, "even"); 5]);
    assert_eq!(replies[5..], vec![of(false, "odd"); 5]);
    let counts = server.counts();
    assert_eq!(
        (counts.received, counts.malformed, counts.unreachable),
        (10, 0, 0)
    );
}

#[test]
fn goals_are_sent_in_both_directions() {
    let Some(python) = rclpy() else { return };
    let domain = domain();
    let mut peer = RclpyNode::start(&python, domain, "peer");
    peer.obey(&json!(["act", "/count", FIBONACCI, 5]));
    let node = node("here", domain);
    let (of, mapping) = (named(FIBONACCI), ServiceMapping::OfPeer);
    let client = node.action_client("/count", &of, mapping).unwrap();
    let order = |order| Datum::record([("order", Datum::Int(order))]);
    // the second goal is cancelled
    for (number, cancels) in [(7, false), (8, true)] {
        let mut goal = client.send(order(number), LONG, LONG);
        assert_eq!(wait("event", || goal.take()), GoalEvent::Accepted);
        let (mut feedback, mut is_cancelled) = (0, false);
        let (status, result) = wait("end", || match goal.take()? {
            GoalEvent::Finished(status, result) => Some((status, result)),
            GoalEvent::Feedback(_) => {
                feedback += 1;
                if cancels && !std::mem::replace(&mut is_cancelled, true) {
                    goal.cancel(LONG);
                }
                None
            }
            GoalEvent::Status(_) | GoalEvent::CancelAnswered(0) => None,
            other @ (GoalEvent::Accepted
            | GoalEvent::Rejected
            | GoalEvent::CancelAnswered(_)
            | GoalEvent::CancelFailed(_)
            | GoalEvent::Failed(_)) => panic!("{other:?}"),
        });
        if cancels {
            assert_eq!(status, GoalStatus::Canceled);
        } else {
            let number = result.get("sequence").unwrap().element(0).unwrap().as_int();
            assert_eq!((status, number), (GoalStatus::Succeeded, Some(7)));
            assert_eq!(feedback, 5);
        }
    }

    let mut server = node.action_server("/here", &of, mapping).unwrap();
    let mut sent = |number: i64| {
        peer.obey(&json!(["send", "/here", FIBONACCI, {"order": number}]));
        let goal = wait("goal", || match server.take().pop()? {
            GoalRequest::Goal { goal, content } => Some((goal, content)),
            GoalRequest::Cancel { goal } => panic!("{goal:?}"),
        });
        assert_eq!(goal.1, order(number));
        goal.0
    };
    let refused = sent(1);
    server.reject(refused);
    peer.event("rejected", "/here");
    let mut sent = |number: i64| {
        peer.obey(&json!(["send", "/here", FIBONACCI, {"order": number}]));
        let goal = wait("goal", || match server.take().pop()? {
            GoalRequest::Goal { goal, content } => Some((goal, content)),
            GoalRequest::Cancel { goal } => panic!("{goal:?}"),
        });
        assert_eq!(goal.1, order(number));
        server.accept(goal.0);
        peer.event("accepted", "/here");
        goal.0
    };
    let done = sent(2);
    server.tell(done, sequence(4)).unwrap();
    let end = |server: &mut asmotion_ros2::ActionServer, peer: &mut RclpyNode| {
        // the server answers requests for results while it is asked
        std::thread::scope(|scope| {
            let ended = scope.spawn(|| peer.event("end", "/here"));
            while !ended.is_finished() {
                server.take();
                std::thread::sleep(Duration::from_millis(2));
            }
            ended.join().unwrap()
        })
    };
    server
        .end(done, GoalStatus::Succeeded, sequence(9))
        .unwrap();
    assert_eq!(
        end(&mut server, &mut peer),
        [json!(4), json!({"sequence": [9]})]
    );
    assert_eq!(peer.event("feedback", "/here"), [json!({"sequence": [4]})]);
}

#[test]
fn messages_pass_in_both_directions_and_reach_late_subscriptions() {
    let Some(python) = rclpy() else { return };
    let domain = domain();
    let mut peer = RclpyNode::start(&python, domain, "peer");
    let node = node("here", domain);
    let latched = Qos {
        durability: Durability::TransientLocal,
        ..Qos::default().depth(1)
    };
    let publisher = node.publisher("/map", &named(STRING), latched).unwrap();
    publisher.send(&text("here")).unwrap();
    peer.obey(&json!(["subscribe", "/map", STRING, true]));
    assert_eq!(peer.event("message", "/map"), [json!({"data": "here"})]);

    peer.obey(&json!(["publish", "/there", STRING, {"data": "there"}, true]));
    let subscription = node
        .subscription("/there", &named(STRING), latched)
        .unwrap();
    let received = subscription.wait(LONG).expect("a message");
    assert_eq!(received.message, text("there"));

    // a burst right after the match: nothing is lost in either direction
    let (up, down) = (named(STRING), Qos::default().depth(200));
    let subscription = node.subscription("/up", &up, down).unwrap();
    peer.obey(&json!(["publish", "/up", STRING, null]));
    peer.obey(&json!(["matches", "/up", 1]));
    assert!(subscription.wait_for_matches(1, LONG));
    for number in 0..50 {
        let message = json!({"data": number.to_string()});
        peer.obey(&json!(["publish", "/up", STRING, message]));
    }
    for number in 0..50 {
        let received = subscription.wait(LONG).expect("a message");
        assert_eq!(received.message, text(&number.to_string()));
    }
    let publisher = node.publisher("/down", &up, down).unwrap();
    peer.obey(&json!(["subscribe", "/down", STRING]));
    peer.obey(&json!(["matches", "/down", 1]));
    assert!(publisher.wait_for_matches(1, LONG));
    for number in 0..50 {
        publisher.send(&text(&number.to_string())).unwrap();
    }
    for number in 0..50 {
        let expected = json!({"data": number.to_string()});
        assert_eq!(peer.event("message", "/down"), [expected]);
    }
}
