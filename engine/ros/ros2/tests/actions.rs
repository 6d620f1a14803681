//! Actions and simulated time.

use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros2::{Goal, GoalEvent, GoalStatus, ServiceMapping};

use crate::peer::{
    LONG, Peer, catalogue, domain, encode, hex, named, node, python, topic_settings, wait,
};

const FIBONACCI: &str = "example_interfaces/action/Fibonacci";

fn settings(domain: u16) -> serde_json::Value {
    let jazzy = catalogue();
    let json = |name: &str| crate::peer::json(&jazzy.schema(&named(name)).unwrap());
    let parts = jazzy.schemas(&named(FIBONACCI)).unwrap();
    let [goal, result, feedback] = [0, 1, 2].map(|index: usize| crate::peer::json(&parts[index]));
    let id = json("unique_identifier_msgs/msg/UUID");
    let record = |fields: &[(&str, &serde_json::Value)]| {
        let fields = fields
            .iter()
            .map(|(name, schema)| serde_json::json!({"name": name, "doc": "", "schema": schema}));
        let fields: Vec<_> = fields.collect();
        serde_json::json!({"name": "", "shape": {"record": fields}})
    };
    let plain = |shape: &str| serde_json::json!({"name": "", "shape": shape});
    let of = |part: &str| format!("example_interfaces::action::dds_::Fibonacci_{part}_");
    let cancel = jazzy.schemas(&named("action_msgs/srv/CancelGoal")).unwrap();
    let [cancel, cancelled] = [0, 1].map(|index: usize| crate::peer::json(&cancel[index]));
    let (time, status) = (
        json("builtin_interfaces/msg/Time"),
        json("action_msgs/msg/GoalStatusArray"),
    );
    let kind = |schema, of: String| serde_json::json!({"schema": schema, "type": of});
    serde_json::json!({
        "domain": domain,
        "action": "/fibonacci",
        "kinds": {
            "goal": kind(record(&[("goal_id", &id), ("goal", &goal)]), of("SendGoal_Request")),
            "accepted": kind(
                record(&[("accepted", &plain("bool")), ("stamp", &time)]),
                of("SendGoal_Response"),
            ),
            "ask": kind(record(&[("goal_id", &id)]), of("GetResult_Request")),
            "result": kind(
                record(&[("status", &plain("i8")), ("result", &result)]),
                of("GetResult_Response"),
            ),
            "cancel": kind(cancel, "action_msgs::srv::dds_::CancelGoal_Request_".to_owned()),
            "cancelled": kind(cancelled, "action_msgs::srv::dds_::CancelGoal_Response_".to_owned()),
            "feedback": kind(
                record(&[("goal_id", &id), ("feedback", &feedback)]),
                of("FeedbackMessage"),
            ),
            "status": kind(status, "action_msgs::msg::dds_::GoalStatusArray_".to_owned()),
        },
    })
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
