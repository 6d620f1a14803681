//! Actions and simulated time.

use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros2::{Goal, GoalEvent, GoalStatus, ServiceMapping};

use crate::peer::{
    LONG, Peer, action_kinds, catalogue, domain, encode, hex, named, node, python, topic_settings,
    wait,
};

const FIBONACCI: &str = "example_interfaces/action/Fibonacci";

fn settings(domain: u16) -> serde_json::Value {
    let (kinds, _) = action_kinds(FIBONACCI);
    serde_json::json!({ "domain": domain, "action": "/fibonacci", "kinds": kinds })
}

fn order(order: i64) -> Datum {
    Datum::record([("order", Datum::Int(order))])
}

fn event(goal: &mut Goal) -> GoalEvent {
    wait("event", || goal.take())
}

#[test]
fn a_goal_is_accepted_and_gives_feedback_and_a_result() {
    let Some(python) = python() else { return };
    let domain = domain();
    let peer = Peer::start(&python, "action", &settings(domain));
    peer.expect("ready");
    let node = node("coordinator", domain);
    let of_peer = ServiceMapping::OfPeer;
    let client = node
        .action_client("/fibonacci", &named(FIBONACCI), of_peer)
        .unwrap();
    let mut goal = client.send(order(6), LONG, LONG);
    assert_eq!(event(&mut goal), GoalEvent::Accepted);
    let mut feedback = Vec::new();
    let (status, result) = loop {
        match event(&mut goal) {
            GoalEvent::Feedback(datum) => feedback.push(datum.get("sequence").unwrap().count()),
            GoalEvent::Status(_) => {}
            GoalEvent::Finished(status, result) => break (status, result),
            other @ (GoalEvent::Accepted
            | GoalEvent::Rejected
            | GoalEvent::CancelAnswered(_)
            | GoalEvent::CancelFailed(_)
            | GoalEvent::Failed(_)) => panic!("{other:?}"),
        }
    };
    assert_eq!(status, GoalStatus::Succeeded);
    let sequence = result.get("sequence").unwrap();
    let numbers: Vec<i64> = (0..7)
        .map(|index| sequence.element(index).unwrap().as_int().unwrap())
        .collect();
    assert_eq!(numbers, [0, 1, 1, 2, 3, 5, 8]);
    assert_eq!(feedback, [3, 4, 5, 6, 7].map(Some));
    assert!(goal.is_over() && goal.take().is_none());
    assert_eq!(client.malformed(), 0);

    let mut refused = client.send(order(-1), LONG, LONG);
    assert_eq!(event(&mut refused), GoalEvent::Rejected);
    assert!(refused.is_over());
}

#[test]
fn a_goal_is_cancelled() {
    let Some(python) = python() else { return };
    let domain = domain();
    let peer = Peer::start(&python, "action", &settings(domain));
    peer.expect("ready");
    let node = node("coordinator", domain);
    let of_peer = ServiceMapping::OfPeer;
    let client = node
        .action_client("/fibonacci", &named(FIBONACCI), of_peer)
        .unwrap();
    let mut goal = client.send(order(1000), LONG, LONG);
    assert_eq!(event(&mut goal), GoalEvent::Accepted);
    while !matches!(event(&mut goal), GoalEvent::Feedback(_)) {}
    goal.cancel(LONG);
    let (mut answer, mut statuses) = (None, Vec::new());
    let end = loop {
        match event(&mut goal) {
            GoalEvent::CancelAnswered(code) => answer = Some(code),
            GoalEvent::Status(status) => statuses.push(status),
            GoalEvent::Feedback(_) => {}
            GoalEvent::Finished(status, _) => break status,
            other @ (GoalEvent::Accepted
            | GoalEvent::Rejected
            | GoalEvent::CancelFailed(_)
            | GoalEvent::Failed(_)) => panic!("{other:?}"),
        }
    };
    assert_eq!((answer, end), (Some(0), GoalStatus::Canceled));
    assert_eq!(statuses.last(), Some(&GoalStatus::Canceled));
}

#[test]
fn an_action_without_a_server_fails_at_its_deadline() {
    let node = node("coordinator", domain());
    let of_peer = ServiceMapping::OfPeer;
    let client = node
        .action_client("/fibonacci", &named(FIBONACCI), of_peer)
        .unwrap();
    let mut goal = client.send(order(1), Duration::from_millis(200), LONG);
    assert!(matches!(event(&mut goal), GoalEvent::Failed(_)));
}

#[test]
fn simulated_time_is_that_of_cyclone() {
    let Some(python) = python() else { return };
    let domain = domain();
    let node = node("coordinator", domain);
    let clock = node.simulated_clock().unwrap();
    assert_eq!(clock.now(), None);
    let of = named("rosgraph_msgs/msg/Clock");
    let schema = catalogue().schema(&of).unwrap();
    let mut settings = topic_settings(domain, "/clock", &of);
    let tick = |sec: i64, nanosec: i64| {
        let time = Datum::record([("sec", Datum::Int(sec)), ("nanosec", Datum::Int(nanosec))]);
        hex(&encode(&Datum::record([("clock", time)]), &schema))
    };
    let ticks: Vec<_> = (1..=50).map(|second| tick(second, 5)).collect();
    settings["messages"] = ticks.into();
    settings["pause"] = 0.01.into();
    let peer = Peer::start(&python, "publish", &settings);
    peer.expect("sent");
    let last = Duration::new(50, 5);
    wait("the last tick", || {
        (clock.now() == Some(last)).then_some(())
    });
}
