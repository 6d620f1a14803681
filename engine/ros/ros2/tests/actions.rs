//! Actions and simulated time.

use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros2::{
    ActionServer, Goal, GoalEvent, GoalId, GoalRequest, GoalStatus, ServiceMapping,
};

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

fn sequence(numbers: &[i64]) -> Datum {
    let numbers = numbers.iter().map(|it| Datum::Int(*it));
    Datum::record([("sequence", Datum::List(numbers.collect()))])
}

/// The next goal that a server is asked for.
fn asked(server: &mut ActionServer) -> (GoalId, Datum) {
    wait("goal", || match server.take().pop()? {
        GoalRequest::Goal { goal, content } => Some((goal, content)),
        GoalRequest::Cancel { goal } => panic!("{goal:?}"),
    })
}

/// The end of a goal. The server answers requests for results meanwhile.
fn end(goal: &mut Goal, server: &mut ActionServer) -> (GoalStatus, Datum) {
    wait("end", || {
        server.take();
        match goal.take()? {
            GoalEvent::Finished(status, result) => Some((status, result)),
            GoalEvent::Accepted
            | GoalEvent::Feedback(_)
            | GoalEvent::Status(_)
            | GoalEvent::CancelAnswered(0) => None,
            other @ (GoalEvent::Rejected
            | GoalEvent::CancelAnswered(_)
            | GoalEvent::CancelFailed(_)
            | GoalEvent::Failed(_)) => panic!("{other:?}"),
        }
    })
}

#[test]
fn a_server_accepts_rejects_ends_and_cancels_goals() {
    let domain = domain();
    let (one, other) = (node("server", domain), node("client", domain));
    let mapping = ServiceMapping::OfPeer;
    let of = named(FIBONACCI);
    let mut server = one.action_server("/fibonacci", &of, mapping).unwrap();
    let client = other.action_client("/fibonacci", &of, mapping).unwrap();

    let mut goal = client.send(order(3), LONG, LONG);
    let (id, content) = asked(&mut server);
    assert_eq!(content.get("order").unwrap().as_int(), Some(3));
    server.accept(id);
    assert_eq!(event(&mut goal), GoalEvent::Accepted);
    server.tell(id, sequence(&[0, 1])).unwrap();
    wait("feedback", || {
        server.take();
        matches!(goal.take(), Some(GoalEvent::Feedback(_))).then_some(())
    });
    server
        .end(id, GoalStatus::Succeeded, sequence(&[0, 1, 1, 2]))
        .unwrap();
    let (status, result) = end(&mut goal, &mut server);
    assert_eq!(status, GoalStatus::Succeeded);
    assert_eq!(result.get("sequence").unwrap().count(), Some(4));

    let mut refused = client.send(order(-1), LONG, LONG);
    let (id, _) = asked(&mut server);
    server.reject(id);
    assert_eq!(event(&mut refused), GoalEvent::Rejected);

    let mut goal = client.send(order(9), LONG, LONG);
    let (id, _) = asked(&mut server);
    server.accept(id);
    assert_eq!(event(&mut goal), GoalEvent::Accepted);
    goal.cancel(LONG);
    let request = wait("cancellation", || server.take().pop());
    assert_eq!(request, GoalRequest::Cancel { goal: id });
    server.end(id, GoalStatus::Canceled, sequence(&[])).unwrap();
    let (status, _) = end(&mut goal, &mut server);
    assert_eq!(status, GoalStatus::Canceled);

    // without a request to cancel, a goal does not end as cancelled
    let mut goal = client.send(order(9), LONG, LONG);
    let (id, _) = asked(&mut server);
    server.accept(id);
    server.end(id, GoalStatus::Canceled, sequence(&[])).unwrap();
    let (status, _) = end(&mut goal, &mut server);
    assert_eq!(status, GoalStatus::Aborted);
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
