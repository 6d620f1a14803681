//! An action server of this library, with a client of actionlib.

use std::time::{SystemTime, UNIX_EPOCH};

use asmotion_datum::{Datum, ros1};
use asmotion_ros_interface::{Catalogue, Distribution};
use asmotion_ros1::{
    ActionRequest, ActionServer, ActionType, GoalId, GoalOutcome, ServedGoalError,
};

use asmotion_ros_master::{Master, Process, eventually, notifier};

fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    since.as_nanos() as i64
}

/// The next request of the client.
fn next(server: &mut ActionServer) -> ActionRequest {
    eventually("a request", || {
        let mut requests = server.update(now());
        assert!(requests.len() < 2, "{requests:?}");
        requests.pop()
    })
}

fn next_goal(server: &mut ActionServer, x: f64) -> GoalId {
    let ActionRequest::Goal { goal, content } = next(server) else {
        panic!("no goal");
    };
    let found = content.get("target_pose.pose.position.x").unwrap();
    assert_eq!(found.as_float(), Some(x));
    goal
}

/// A line of the client, during which the server goes on.
fn line(server: &mut ActionServer, peer: &Process) -> String {
    eventually("a line of the client", || {
        assert_eq!(server.update(now()), []);
        peer.try_line()
    })
}

fn empty() -> Datum {
    Datum::Record(Vec::new())
}

#[test]
fn a_client_of_actionlib_reaches_cancels_and_fails() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/server");
    let noetic = Catalogue::included(Distribution::Ros1);
    let of = ActionType::of(&noetic, "move_base_msgs/MoveBase").unwrap();
    let mut server = ActionServer::new(&node.node, "/move", &of, &notifier()).unwrap();
    let mut peer = master.peer("action_client", &["client"]);
    assert_eq!(line(&mut server, &peer), "ready");

    peer.tell("goal 3.5");
    let goal = next_goal(&mut server, 3.5);
    let wrong = server.end(&goal, GoalOutcome::Succeeded, empty(), "");
    assert!(
        matches!(wrong, Err(ServedGoalError::State { .. })),
        "{wrong:?}"
    );
    server.accept(&goal).unwrap();
    assert_eq!(line(&mut server, &peer), "active");
    let name = "move_base_msgs/MoveBaseFeedback".parse().unwrap();
    let schema = noetic.schema(&name).unwrap();
    let mut bytes = [0; 16 + 7 * 8];
    bytes[16..24].copy_from_slice(&1.5_f64.to_le_bytes());
    let feedback = ros1::decode(&bytes, &schema).unwrap();
    server.tell(&goal, feedback).unwrap();
    assert_eq!(line(&mut server, &peer), "feedback 1.5");
    assert!(server.tell(&goal, Datum::Int(1)).is_err());
    server
        .end(&goal, GoalOutcome::Succeeded, empty(), "there")
        .unwrap();
    peer.tell("wait");
    assert_eq!(line(&mut server, &peer), "SUCCEEDED there");
    let again = server.end(&goal, GoalOutcome::Aborted, empty(), "");
    assert_eq!(again, Err(ServedGoalError::Unknown(goal)));

    peer.tell("goal 1");
    let goal = next_goal(&mut server, 1.0);
    server.accept(&goal).unwrap();
    assert_eq!(line(&mut server, &peer), "active");
    peer.tell("cancel");
    assert_eq!(
        next(&mut server),
        ActionRequest::Cancel { goal: goal.clone() }
    );
    server
        .end(&goal, GoalOutcome::Preempted, empty(), "stopped")
        .unwrap();
    peer.tell("wait");
    assert_eq!(line(&mut server, &peer), "PREEMPTED stopped");

    peer.tell("goal 2");
    let goal = next_goal(&mut server, 2.0);
    peer.tell("cancel");
    assert_eq!(
        next(&mut server),
        ActionRequest::Cancel { goal: goal.clone() }
    );
    server
        .end(&goal, GoalOutcome::Recalled, empty(), "not begun")
        .unwrap();
    peer.tell("wait");
    assert_eq!(line(&mut server, &peer), "RECALLED not begun");

    peer.tell("goal 9");
    let goal = next_goal(&mut server, 9.0);
    server
        .end(&goal, GoalOutcome::Rejected, empty(), "too far")
        .unwrap();
    peer.tell("wait");
    assert_eq!(line(&mut server, &peer), "REJECTED too far");

    peer.tell("goal 4");
    let goal = next_goal(&mut server, 4.0);
    server.accept(&goal).unwrap();
    assert_eq!(line(&mut server, &peer), "active");
    server
        .end(&goal, GoalOutcome::Aborted, empty(), "no path")
        .unwrap();
    peer.tell("wait");
    assert_eq!(line(&mut server, &peer), "ABORTED no path");
    assert_eq!(server.unreadable(), 0);
}
