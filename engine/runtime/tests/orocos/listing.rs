//! T27: the example of task-component architectures.

use asmotion_component::{Span, Time};
use asmotion_runtime::{Log, Run};

#[path = "../../examples/trajectory_planner.rs"]
#[allow(dead_code, reason = "the example's main, which is for people")]
mod example;

use example::{Position, Trajectory};

#[test]
fn t27_a_trajectory_is_planned_for_each_new_goal_from_where_the_robot_is() {
    let mut system = example::system().unwrap();
    let log = Log::new();
    system.observe(log.clone());
    let mut run = system.simulate();
    let planned = || log.samples::<Trajectory>("Planner.trajectory");
    run.inject(run.now(), "Planner.goal", Position { x: 5.0, y: 2.0 })
        .unwrap();
    run.run_for(250.ms());
    assert_eq!(planned().len(), 0, "there is no pose yet");
    for (x, y) in [(5.0, 2.0), (0.0, 4.0)] {
        let from = Position { x: 1.0, y: 2.0 };
        run.inject(run.now(), "Planner.pose", from).unwrap();
        run.inject(run.now(), "Planner.goal", Position { x, y })
            .unwrap();
        run.run_for(500.ms());
    }
    let planned = planned();
    assert_eq!(planned.len(), 2, "once for each goal: {planned:?}");
    let cycle = Time::ZERO + 100.ms();
    assert!(
        planned
            .iter()
            .all(|(at, _)| at.nanos() % cycle.nanos() == 0)
    );
    for ((_, trajectory), (x, y)) in planned.iter().zip([(5.0, 2.0), (0.0, 4.0)]) {
        let points = &trajectory.points;
        assert_eq!(points.len(), 11);
        assert_eq!((points[0].x, points[0].y), (1.0, 2.0));
        assert_eq!((points[10].x, points[10].y), (x, y));
        let middle = (points[5].x, points[5].y);
        assert_eq!(middle, ((1.0 + x) / 2.0, (2.0 + y) / 2.0));
    }
}

#[test]
fn t27_the_component_has_fewer_than_40_lines() {
    let source = include_str!("../../examples/trajectory_planner.rs");
    let begin = source.find("/// Plans a straight").unwrap();
    let end = source.find("/// Creates a system").unwrap();
    let lines = source[begin..end].lines();
    let lines = lines.filter(|line| !line.trim().is_empty()).count();
    assert!(lines < 40, "{lines} lines");
}
