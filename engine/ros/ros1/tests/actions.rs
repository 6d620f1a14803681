//! Actions, with a server of actionlib.

use std::time::Duration;

use asmotion_datum::{Datum, ros1};
use asmotion_ros_interface::{Catalogue, Distribution};
use asmotion_ros1::{
    ActionClient, ActionError, ActionEvent, ActionType, GoalId, GoalOutcome, GoalPhase,
};

use asmotion_ros_master::{Master, TestNode, eventually, notifier};

fn action_type() -> ActionType {
    let noetic = Catalogue::included(Distribution::Ros1);
    ActionType::of(&noetic, "move_base_msgs/MoveBase").unwrap()
}

/// A goal that takes `steps` tenths of a second, and fails if `y` is negative.
fn goal(steps: f64, y: f64) -> Datum {
    let noetic = Catalogue::included(Distribution::Ros1);
    let name = "move_base_msgs/MoveBaseGoal".parse().unwrap();
    let schema = noetic.schema(&name).unwrap();
    let mut bytes = [0; 16 + 7 * 8];
    bytes[16..24].copy_from_slice(&steps.to_le_bytes());
    bytes[24..32].copy_from_slice(&y.to_le_bytes());
    ros1::decode(&bytes, &schema).unwrap()
}

/// A client that is connected.
fn client(node: &TestNode) -> ActionClient {
    let mut client = ActionClient::new(&node.node, "/move", &action_type(), &notifier()).unwrap();
    assert_eq!(client.send(&goal(1.0, 0.0), 0), Err(ActionError::NoServer));
    eventually("the server is connected", || {
        client.update();
        client.is_connected().then_some(())
    });
    client
}

/// The phases, feedback (positions) and end of a goal.
#[derive(Debug, Default)]
struct History {
    phases: Vec<GoalPhase>,
    positions: Vec<f64>,
    end: Option<(GoalOutcome, String, Option<Datum>)>,
}

/// Follows goals to their ends.
fn follow<const N: usize>(client: &mut ActionClient, goals: [&GoalId; N]) -> [History; N] {
    let mut histories = goals.map(|_| History::default());
    let at = |goal: &GoalId| goals.iter().position(|it| *it == goal).unwrap();
    eventually("the goals have ended", || {
        for event in client.update() {
            match event {
                ActionEvent::Phase { goal, phase } => histories[at(&goal)].phases.push(phase),
                ActionEvent::Feedback { goal, feedback } => {
                    let x = feedback.get("base_position.pose.position.x").unwrap();
                    histories[at(&goal)].positions.push(x.as_float().unwrap());
                }
                ActionEvent::Done {
                    goal,
                    outcome,
                    text,
                    result,
                } => {
                    let history = &mut histories[at(&goal)];
                    assert!(history.end.is_none(), "{goal} ends twice");
                    history.end = Some((outcome, text, result));
                }
            }
        }
        histories.iter().all(|it| it.end.is_some()).then_some(())
    });
    histories
}

fn ended(history: &History) -> (GoalOutcome, &str) {
    let (outcome, text, result) = history.end.as_ref().unwrap();
    let empty: [(&str, Datum); 0] = [];
    assert_eq!(*result, Some(Datum::record(empty)));
    (*outcome, text)
}

#[test]
fn a_goal_is_followed_to_its_result() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/client");
    let server = master.peer("action_server", &["server"]);
    assert_eq!(server.line(), "ready");
    let mut client = client(&node);
    let first = client.send(&goal(8.0, 0.0), 5_000_000_000).unwrap();
    assert_eq!(client.phase(&first), Some(GoalPhase::WaitingForGoalAck));
    let [history] = follow(&mut client, [&first]);
    assert_eq!(ended(&history), (GoalOutcome::Succeeded, "arrived"));
    assert_eq!(
        history.positions,
        (1..=8).map(f64::from).collect::<Vec<_>>()
    );
    assert!(history.phases.contains(&GoalPhase::Active), "{history:?}");
    assert_eq!(client.phase(&first), None);
    assert!(!client.cancel(&first));
    let second = client.send(&goal(1.0, -1.0), 0).unwrap();
    assert_ne!(first, second);
    let [history] = follow(&mut client, [&second]);
    assert_eq!(ended(&history), (GoalOutcome::Aborted, "no path"));
    let counts = client.counts();
    assert_eq!(
        (counts.sent, counts.open, counts.unreadable, counts.dropped),
        (2, 0, 0, 0)
    );
}

#[test]
fn a_goal_is_cancelled_and_a_new_goal_replaces_the_one_before() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/client");
    let server = master.peer("action_server", &["server"]);
    assert_eq!(server.line(), "ready");
    let mut client = client(&node);
    let cancelled = client.send(&goal(600.0, 0.0), 0).unwrap();
    eventually("it is active", || {
        client.update();
        (client.phase(&cancelled) == Some(GoalPhase::Active)).then_some(())
    });
    assert!(client.cancel(&cancelled));
    assert_eq!(
        client.phase(&cancelled),
        Some(GoalPhase::WaitingForCancelAck)
    );
    let [history] = follow(&mut client, [&cancelled]);
    assert_eq!(ended(&history), (GoalOutcome::Preempted, "cancelled é"));
    assert!(!history.phases.contains(&GoalPhase::Active), "{history:?}");

    let replaced = client.send(&goal(600.0, 0.0), 0).unwrap();
    eventually("it is active", || {
        client.update();
        (client.phase(&replaced) == Some(GoalPhase::Active)).then_some(())
    });
    let newer = client.send(&goal(2.0, 0.0), 0).unwrap();
    let [old, new] = follow(&mut client, [&replaced, &newer]);
    assert_eq!(ended(&old), (GoalOutcome::Preempted, "cancelled é"));
    assert_eq!(ended(&new), (GoalOutcome::Succeeded, "arrived"));
}

#[test]
fn a_goal_is_lost_when_the_server_is_restarted_and_the_next_one_is_reached() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/client");
    let server = master.peer("action_server", &["server"]);
    assert_eq!(server.line(), "ready");
    let mut client = client(&node);
    let lost = client.send(&goal(600.0, 0.0), 0).unwrap();
    eventually("it is active", || {
        client.update();
        (client.phase(&lost) == Some(GoalPhase::Active)).then_some(())
    });
    drop(server);
    eventually("the server is silent and no longer connected", || {
        client.update();
        let is_silent = client
            .silence()
            .is_some_and(|it| it > Duration::from_secs(1));
        (is_silent && !client.is_connected()).then_some(())
    });
    assert_eq!(client.send(&goal(1.0, 0.0), 0), Err(ActionError::NoServer));
    let server = master.peer("action_server", &["server"]);
    assert_eq!(server.line(), "ready");
    let [history] = follow(&mut client, [&lost]);
    let (outcome, _, result) = history.end.unwrap();
    assert_eq!((outcome, result), (GoalOutcome::Lost, None));
    eventually("the new server is connected", || {
        client.update();
        client.is_connected().then_some(())
    });
    let next = client.send(&goal(1.0, 0.0), 0).unwrap();
    let [history] = follow(&mut client, [&next]);
    assert_eq!(ended(&history), (GoalOutcome::Succeeded, "arrived"));
}
