//! The planner in a running system.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "tests"
)]

use std::sync::{Arc, Mutex};

use asmotion_component::{
    Activity, CallError, Component, Cycle, Fault, Interface, Provided, Required, Span, Time, Wire,
};
use asmotion_geometry::{FREE, Grid, GridLayout, OCCUPIED, Point, Pose, heading, message};
use asmotion_messages::{GetMap, Obstacles, OccupancyGrid, Path, Plan, PlanRequest, Vertex};
use asmotion_planner::TrajectoryPlanner;
use asmotion_runtime::{Log, Run, System};

/// A hall of 6 m × 4 m with a wall in the middle, open at both ends.
fn hall() -> OccupancyGrid {
    let layout = GridLayout::new(0.1, 60, 40, Pose::identity()).unwrap();
    let mut grid = Grid::new(layout, FREE);
    grid.stroke(&[Point::new(3.0, 1.2), Point::new(3.0, 2.8)], 0.2, OCCUPIED);
    message::occupancy_grid(&grid, 0, "map")
}

fn request(map: OccupancyGrid, from: (f64, f64), to: (f64, f64)) -> PlanRequest {
    let stamped = |(x, y)| message::pose_stamped(&heading(Point::new(x, y), 0.0), 0, "map");
    PlanRequest {
        map,
        start: stamped(from),
        goal: stamped(to),
    }
}

type Answers = Arc<Mutex<Vec<Result<Path, CallError>>>>;

struct Client {
    planning: Required<Plan>,
    requests: Vec<PlanRequest>,
    answers: Answers,
}

impl Component for Client {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        if cycle.number() > 2 && !self.requests.is_empty() {
            cycle.call(self.planning, self.requests.remove(0));
        }
        let answers = cycle
            .replies(self.planning)
            .into_iter()
            .map(|reply| reply.result);
        self.answers.lock().unwrap().extend(answers);
        Ok(())
    }
}

struct Maps(Provided<GetMap>);

impl Component for Maps {
    fn update(&mut self, cycle: &mut Cycle<'_>) -> Result<(), Fault> {
        for request in cycle.requests(self.0) {
            cycle.reply(self.0, request.id, Ok(hall()));
        }
        Ok(())
    }
}

fn system(requests: Vec<PlanRequest>) -> (System, Answers, Log) {
    let (mut system, log, answers) = (System::new(), Log::new(), Answers::default());
    system.observe(log.clone());
    let planner = |interface: &mut Interface| -> Box<dyn Component> {
        Box::new(TrajectoryPlanner::new(interface))
    };
    system.add("Planner", Activity::event(), planner).unwrap();
    let theirs = Arc::clone(&answers);
    let client = move |interface: &mut Interface| -> Box<dyn Component> {
        Box::new(Client {
            planning: interface.require("planning", "a path"),
            requests,
            answers: theirs,
        })
    };
    system
        .add("Client", Activity::periodic(10.ms()), client)
        .unwrap();
    system
        .wire("Client.planning", "Planner.planning", Wire::default())
        .unwrap();
    (system, answers, log)
}

fn wire_maps(system: &mut System) {
    let maps = |interface: &mut Interface| -> Box<dyn Component> {
        Box::new(Maps(interface.serve("maps", "one map")))
    };
    system.add("Maps", Activity::event(), maps).unwrap();
    system
        .wire("Planner.maps", "Maps.maps", Wire::default())
        .unwrap();
}

/// Distance of a path above the middle where it passes the wall, m; negative below.
fn side(path: &Path) -> f64 {
    let points = path.poses.iter().map(|stamped| &stamped.pose.position);
    let nearest = points.min_by(|one, other| (one.x - 3.0).abs().total_cmp(&(other.x - 3.0).abs()));
    nearest.unwrap().y - 2.0
}

#[test]
fn it_plans_on_the_map_of_the_request_and_publishes_what_it_found() {
    let (system, answers, log) = system(vec![request(hall(), (1.0, 2.3), (5.0, 2.3))]);
    system.simulate().run_for(1.s());
    let answers = answers.lock().unwrap();
    let path = answers[0].as_ref().unwrap();
    assert_eq!(path.header.frame_id, "map");
    assert!(side(path) > 0.8);
    let published = log.samples::<Path>("Planner.trajectory");
    assert_eq!(
        published.iter().map(|(_, path)| path).collect::<Vec<_>>(),
        [path]
    );
}

#[test]
fn it_asks_for_the_map_that_a_request_does_not_bring() {
    let none = OccupancyGrid::default();
    let (mut system, answers, _) = system(vec![request(none, (1.0, 2.3), (5.0, 2.3))]);
    wire_maps(&mut system);
    system.simulate().run_for(1.s());
    assert!(side(answers.lock().unwrap()[0].as_ref().unwrap()) > 0.8);
}

#[test]
fn it_says_that_nobody_gives_a_map() {
    let none = OccupancyGrid::default();
    let (system, answers, _) = system(vec![request(none, (1.0, 2.3), (5.0, 2.3))]);
    system.simulate().run_for(1.s());
    let fault = answers.lock().unwrap()[0].clone().unwrap_err().to_string();
    assert!(
        fault.starts_with("BAD_MAP: the request has no map"),
        "{fault}"
    );
}

#[test]
fn it_goes_round_what_the_robot_saw() {
    let (system, answers, _) = system(vec![request(hall(), (1.0, 2.3), (5.0, 2.3))]);
    let mut run = system.simulate();
    // closes the upper opening; a point in the cell of the robot itself is ignored
    let across = (0..=24).map(|step| (3.0, 2.8 + 0.05 * f64::from(step)));
    let points = across.chain([(1.01, 2.31)]).map(|(x, y)| Vertex { x, y });
    let seen = Obstacles {
        points: points.collect(),
        ..Obstacles::default()
    };
    run.inject(Time::ZERO, "Planner.obstacles", seen).unwrap();
    run.run_for(1.s());
    assert!(side(answers.lock().unwrap()[0].as_ref().unwrap()) < -0.8);
}

/// The answer to a request in a hall whose upper opening is closed but for `open` cells; the lower one is closed.
fn through_a_gap(open: u32) -> Result<Path, CallError> {
    let (system, answers, _) = system(vec![request(hall(), (1.0, 2.3), (5.0, 2.3))]);
    let mut run = system.simulate();
    let closed = (0..40).filter(|row| !(32..32 + open).contains(row));
    let points = closed.map(|row| Vertex {
        x: 3.05,
        y: 0.05 + 0.1 * f64::from(row),
    });
    let seen = Obstacles {
        points: points.collect(),
        ..Obstacles::default()
    };
    run.inject(Time::ZERO, "Planner.obstacles", seen).unwrap();
    run.run_for(1.s());
    answers.lock().unwrap().remove(0)
}

#[test]
fn it_squeezes_through_a_gap_that_is_too_narrow_by_less_than_a_cell() {
    // from the middle of five open cells it is 0.3 m to the closed ones, which is not more than the inflation
    assert!(through_a_gap(5).is_ok());
    let Err(CallError::Fault(fault)) = through_a_gap(4) else {
        panic!("it is 0.2 m on one side");
    };
    assert_eq!(fault.code, Plan::NO_PATH);
}

#[test]
fn it_answers_with_the_fault_codes_of_the_service() {
    let goal = (1.0, 2.0);
    let (system, answers, log) = system(vec![
        request(hall(), goal, (3.0, 2.0)),
        request(hall(), (3.0, 2.0), goal),
        request(hall(), goal, (9.0, 2.0)),
    ]);
    system.simulate().run_for(1.s());
    let answers = answers.lock().unwrap();
    let codes = answers.iter().map(|answer| match answer {
        Err(CallError::Fault(fault)) => fault.code.clone(),
        other => panic!("{other:?}"),
    });
    assert_eq!(
        codes.collect::<Vec<_>>(),
        [Plan::GOAL_OCCUPIED, Plan::START_OCCUPIED, Plan::OUTSIDE]
    );
    assert!(log.samples::<Path>("Planner.trajectory").is_empty());
}
