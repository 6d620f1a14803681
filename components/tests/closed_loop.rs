//! The reactive layer in the simulated world without a coordinator: the paths are given by the tests.

use crate::course::{Course, Drive, GO, block, disc, nanos};
use asmotion_component::{Span, Time, Transition};
use asmotion_datum::Datum;
use asmotion_geometry::Point;
use asmotion_messages::Path;
use asmotion_runtime::Run;
use asmotion_world::Obstacle;

/// Radius of the robot, m.
const RADIUS: f64 = 0.2;

fn goal() -> Point {
    Point::new(10.0, 5.0)
}

/// Drives with 20 seeds, and prints the largest distance from the goal and the smallest clearance.
fn arrives_with_every_seed(course: &Course) {
    let (mut farthest, mut nearest): (f64, f64) = (0.0, f64::INFINITY);
    for seed in 0..20 {
        let drive = course.clone().seed(seed).drive(60.0);
        assert_eq!(drive.faults, [""; 0]);
        assert_eq!(
            drive.codes(),
            ["REACHED"],
            "seed {seed}: {:?}",
            drive.events
        );
        farthest = farthest.max((drive.end() - goal()).norm());
        nearest = nearest.min(drive.nearest - RADIUS);
    }
    println!("at most {farthest:.3} m from the goal, at least {nearest:.3} m from everything");
    assert!(farthest <= 0.1, "{farthest} m from the goal");
    assert!(nearest > 0.03, "{nearest} m from an obstacle");
}

#[test]
fn n3_it_reaches_the_end_of_a_free_path() {
    arrives_with_every_seed(&Course::corridor());
}

#[test]
fn it_bends_around_a_thing_in_the_middle() {
    arrives_with_every_seed(&Course::corridor().with(disc(0.0, 5.0, 0.0, 0.3)));
}

#[test]
fn it_winds_through_several_things() {
    let course = Course::corridor()
        .with(disc(0.0, 3.0, 0.3, 0.2))
        .with(disc(0.0, 5.0, -0.3, 0.2))
        .with(disc(0.0, 7.0, 0.3, 0.2))
        .with(disc(0.0, 10.0, 2.0, 0.25));
    arrives_with_every_seed(&course);
}

#[test]
fn it_squeezes_through_a_gap_beside_a_block() {
    arrives_with_every_seed(&Course::corridor().with(block(3.0, 6.0, -0.4, 0.4, 1.2)));
}

#[test]
fn it_evades_a_thing_that_appears_close_in_front() {
    let pops_up = Obstacle {
        frame: "robot".to_owned(),
        ..disc(5.0, 0.8, 0.0, 0.2)
    };
    arrives_with_every_seed(&Course::corridor().with(pops_up));
}

#[test]
fn it_goes_back_to_the_path_when_the_thing_has_gone() {
    let leaves = Obstacle {
        until_s: Some(6.0),
        ..disc(0.0, 5.0, 0.0, 0.4)
    };
    let drive = Course::corridor().with(leaves).drive(60.0);
    assert_eq!(drive.codes(), ["REACHED"]);
    let passing = drive
        .track
        .iter()
        .find(|(_, pose)| pose.translation.x >= 5.0)
        .unwrap();
    assert!(passing.1.translation.y.abs() < 0.1);
}

#[test]
fn n4_it_is_blocked_by_a_closed_corridor_and_stands_still_before_it() {
    for seed in 0..20 {
        let course = Course::corridor()
            .with(block(3.0, 6.0, 0.0, 0.4, 2.0))
            .seed(seed);
        let drive = course.drive(20.0);
        assert_eq!(drive.codes(), ["BLOCKED", "HALTED"], "{:?}", drive.events);
        assert!(drive.nearest > RADIUS + 0.3);
        // the adapter reports the place, so that a planner can avoid it
        let wall = drive
            .obstacles
            .iter()
            .filter(|point| (point.x - 5.8).abs() < 0.1);
        let (low, high) = wall.fold((9.0_f64, -9.0_f64), |(low, high), point| {
            (low.min(point.y), high.max(point.y))
        });
        assert!(low < -0.9 && high > 0.9, "told from {low} to {high}");
        // the robot really stands still
        let (halted, end) = (drive.place(drive.at("HALTED")), drive.end());
        assert!((halted - end).norm() < 0.005);
        assert!(drive.paths.last().unwrap().1.poses.is_empty());
    }
}

#[test]
fn it_stops_before_a_wall_that_appears_close_in_front() {
    let pops_up = Obstacle {
        frame: "robot".to_owned(),
        ..block(6.0, 0.8, 0.0, 0.2, 3.0)
    };
    for seed in 0..20 {
        let drive = Course::corridor()
            .with(pops_up.clone())
            .seed(seed)
            .drive(30.0);
        assert!(drive.codes().contains(&"BLOCKED") && !drive.codes().contains(&"COLLISION"));
        assert!(
            drive.nearest > RADIUS + 0.05,
            "{} m",
            drive.nearest - RADIUS
        );
    }
}

#[test]
fn a_new_path_after_a_block_is_followed() {
    let mut running = Course::corridor()
        .with(block(3.0, 6.0, 0.0, 0.4, 2.0))
        .run();
    running.run.run_until(Time::from_nanos(nanos(10.0)));
    let back = Course {
        path: vec![(1.5, 0.0), (0.0, 0.0)],
        ..Course::corridor()
    };
    let mut path = back.message();
    path.header.stamp = asmotion_messages::Time::from_nanos(nanos(10.0));
    running
        .run
        .inject(Time::from_nanos(nanos(10.0)), "Adapter.path", path)
        .unwrap();
    running.run.run_for(20.s());
    let drive = running.drive.lock().unwrap();
    assert_eq!(drive.codes(), ["BLOCKED", "HALTED", "REACHED"]);
    assert!(drive.end().coords.norm() < 0.1);
}

#[test]
fn an_empty_path_stops_it_and_it_says_so_once() {
    let mut running = Course::corridor().run();
    let stop = Path::stop(nanos(5.0), "map");
    running
        .run
        .inject(Time::from_nanos(nanos(5.0)), "Adapter.path", stop)
        .unwrap();
    running.run.run_until(Time::from_nanos(nanos(10.0)));
    let drive = running.drive.lock().unwrap();
    assert_eq!(drive.codes(), ["HALTED"]);
    assert!(drive.at("HALTED") < 6.5);
    assert!((drive.place(drive.at("HALTED")) - drive.end()).norm() < 0.005);
    // afterwards the follower leaves the wheels to others
    assert!(drive.twists.last().unwrap().0 < 7.0);
}

/// Cuts the connection to the rover driver, whose own time limit stops the wheels.
#[test]
fn n1_without_commands_the_wheels_stop_within_200_ms() {
    let mut running = Course::corridor().run();
    running.run.run_until(Time::from_nanos(nanos(5.0)));
    let speed = |drive: &Drive| drive.twists.last().unwrap().1.linear.x;
    assert!(
        speed(&running.drive.lock().unwrap()) > 0.3,
        "it was driving"
    );
    running
        .run
        .disconnect("Monitor.twist", "Rover.twist")
        .unwrap();
    running.run.run_until(Time::from_nanos(nanos(8.0)));
    let drive = running.drive.lock().unwrap();
    assert!(drive.twists.last().unwrap().0 > 7.9, "the follower goes on");
    let after = drive.wheels_stand_from(5.0) - 5.0;
    println!("wheels stopped {after:.3} s after the last command");
    assert!((0.1..=0.2).contains(&after), "{after} s");
    assert!((drive.place(5.0) - drive.end()).norm() < 0.1);
}

/// The follower's last sample is to stand still, so the rover need not wait for its time limit.
#[test]
fn a_follower_that_stops_stops_the_wheels_at_once() {
    let mut running = Course::corridor().run();
    running.run.run_until(Time::from_nanos(nanos(5.0)));
    let stop = running.run.transition("Follower", Transition::Stop);
    stop.unwrap();
    running.run.run_until(Time::from_nanos(nanos(8.0)));
    let drive = running.drive.lock().unwrap();
    let (at, last) = drive.twists.last().unwrap();
    assert_eq!((last.linear.x, last.angular.z), (0.0, 0.0));
    assert!(*at <= 5.0, "{at} s");
    // it brakes with its deceleration
    let standing = drive.wheels_stand_from(5.0);
    assert!(standing < 6.0, "{standing} s");
}

#[test]
fn without_odometry_it_does_not_drive() {
    let mut running = Course::corridor().run();
    running.run.run_until(Time::from_nanos(nanos(5.0)));
    running.run.transition("World", Transition::Stop).unwrap();
    running.run.run_until(Time::from_nanos(nanos(8.0)));
    let drive = running.drive.lock().unwrap();
    let later = drive.twists.iter().filter(|(at, _)| *at > 5.25);
    assert!(
        later.clone().count() > 10
            && later
                .clone()
                .all(|(_, twist)| twist.linear.x == 0.0 && twist.angular.z == 0.0)
    );
}

#[test]
fn with_odometry_in_another_frame_it_does_not_drive() {
    let mut running = Course::corridor().run();
    running.run.run_until(Time::from_nanos(nanos(5.0)));
    let mut locate_in = |frame: &str, until: f64| {
        let frame = vec![("frame".to_owned(), Datum::text(frame))];
        running.run.set_properties("Rover", &frame).unwrap();
        running.run.run_until(Time::from_nanos(nanos(until)));
    };
    locate_in("odom", 7.0);
    locate_in("map", 9.0);
    let drive = running.drive.lock().unwrap();
    let speeds = |from: f64, until: f64| -> Vec<f64> {
        let twists = drive.twists.iter();
        let between = twists.filter(|(at, _)| *at > from && *at < until);
        between.map(|(_, twist)| twist.linear.x).collect()
    };
    assert!(
        speeds(4.5, 5.0).iter().all(|speed| *speed > 0.3),
        "it was driving"
    );
    let without_place = speeds(5.1, 7.0);
    assert!(
        without_place.len() > 30,
        "it commands a stop in every cycle"
    );
    assert!(
        without_place.iter().all(|speed| *speed == 0.0),
        "{without_place:?}"
    );
    assert!(
        speeds(7.5, 9.0).iter().all(|speed| *speed > 0.3),
        "it goes on"
    );
}

#[test]
fn a_closed_path_is_driven_once_round() {
    let round = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0)];
    let walls = [
        [-2.0, -2.0, 6.0, -2.0],
        [6.0, -2.0, 6.0, 5.0],
        [6.0, 5.0, -2.0, 5.0],
        [-2.0, 5.0, -2.0, -2.0],
    ];
    let course = Course {
        walls: walls.concat(),
        path: round.to_vec(),
        start: [0.0; 3],
        seed: 1,
        ..Course::default()
    };
    // once as planned, once with a detour
    for course in [course.clone(), course.with(disc(0.0, 2.0, 3.0, 0.2))] {
        let drive = course.drive(90.0);
        assert_eq!(drive.codes(), ["REACHED"], "{:?}", drive.events);
        for (x, y) in round {
            let corner = Point::new(x, y);
            let distance = |(_, pose): &(f64, asmotion_geometry::Pose)| {
                (Point::from(pose.translation.vector) - corner).norm()
            };
            let nearest = drive
                .track
                .iter()
                .map(distance)
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.4, "{nearest} m from ({x}, {y})");
        }
        assert!((drive.end() - Point::origin()).norm() < 0.1);
        assert!(drive.at("REACHED") > 14.0 / 0.5, "{:?}", drive.events);
    }
}

#[test]
fn without_eyes_it_stops_and_with_them_it_goes_on() {
    let mut running = Course::corridor().run();
    running.run.run_until(Time::from_nanos(nanos(5.0)));
    running.run.transition("Laser", Transition::Stop).unwrap();
    running.run.run_until(Time::from_nanos(nanos(9.0)));
    let stood = running.drive.lock().unwrap().end();
    running.run.run_until(Time::from_nanos(nanos(10.0)));
    assert!((running.drive.lock().unwrap().end() - stood).norm() < 1e-3);
    running.run.transition("Laser", Transition::Start).unwrap();
    running.run.run_until(Time::from_nanos(nanos(60.0)));
    let drive = running.drive.lock().unwrap();
    assert_eq!(drive.codes(), ["HALTED", "REACHED"]);
}

#[test]
fn with_a_map_its_walls_are_no_news() {
    let course = Course::corridor().with(disc(0.0, 5.0, 0.0, 0.3)).with_map();
    arrives_with_every_seed(&course);
    let drive = course.drive(20.0);
    assert!(!drive.obstacles.is_empty());
    for reported in &drive.obstacles {
        let off = (reported - Point::new(5.0, 0.0)).norm();
        assert!((off - 0.3).abs() <= 0.05, "{reported:?} is not the disc");
    }
}

/// Two parallel corridors, connected at both ends.
fn ring() -> Course {
    let walls = [
        [-1.0, -1.0, 11.0, -1.0],
        [-1.0, 5.0, 11.0, 5.0],
        [-1.0, -1.0, -1.0, 5.0],
        [11.0, -1.0, 11.0, 5.0],
    ];
    let middle = [
        [1.0, 1.0, 9.0, 1.0],
        [1.0, 3.0, 9.0, 3.0],
        [1.0, 1.0, 1.0, 3.0],
        [9.0, 1.0, 9.0, 3.0],
    ];
    Course {
        walls: [walls, middle].concat().concat(),
        path: Vec::new(),
        start: [0.0; 3],
        ..Course::corridor()
    }
}

#[test]
fn a_planner_that_hears_of_the_block_finds_another_way() {
    for seed in 0..5 {
        let course = ring()
            .with(block(4.0, 6.0, 0.0, 0.4, 2.0))
            .with_map()
            .seed(seed);
        let mut running = course.mission((10.0, 0.0));
        running.run.run_until(Time::from_nanos(nanos(90.0)));
        let drive = running.drive.lock().unwrap();
        assert_eq!(drive.faults, [""; 0]);
        assert_eq!(drive.codes(), ["BLOCKED", "REACHED"], "{:?}", drive.events);
        assert!((drive.end() - Point::new(10.0, 0.0)).norm() < 0.1);
        assert!(drive.nearest > RADIUS + 0.03);
        assert!(
            drive.track.iter().any(|(_, pose)| pose.translation.y > 3.3),
            "through the other corridor"
        );
    }
}

#[test]
fn it_goes_through_the_office_of_the_demo_although_a_corridor_gets_closed() {
    let office = Course::office();
    let from_lab = Course {
        start: [4.2, 15.6, 0.0],
        ..office
    };
    let course = from_lab
        .with(disc(6.0, 22.0, 13.0, 0.8))
        .with(disc(0.0, 10.0, 13.2, 0.25));
    let mut running = course.mission((27.8, 15.4));
    running.run.run_until(Time::from_nanos(nanos(150.0)));
    let drive = running.drive.lock().unwrap();
    assert_eq!(drive.faults, [""; 0]);
    assert_eq!(drive.codes(), ["BLOCKED", "REACHED"], "{:?}", drive.events);
    assert!((drive.end() - Point::new(27.8, 15.4)).norm() < 0.1);
    assert!(drive.nearest > RADIUS + 0.03);
}

#[test]
fn the_same_seed_gives_the_same_drive() {
    let course = Course::corridor().with(disc(0.0, 5.0, 0.0, 0.3));
    let (first, second) = (course.drive(20.0), course.drive(20.0));
    assert!(
        first.track == second.track && first.twists == second.twists && first.paths == second.paths
    );
    assert!(first.track != course.seed(2).drive(20.0).track);
}

#[test]
fn nothing_moves_before_the_path_comes() {
    let drive = Course::corridor().drive(GO - 0.01);
    assert!(drive.twists.is_empty() && drive.wheels.iter().all(|(_, wheels)| wheels.left == 0.0));
}
