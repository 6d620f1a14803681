//! The collision monitor between a follower without a laser and the rover: it alone prevents collisions.

#![allow(
    clippy::unwrap_used,
    dead_code,
    missing_docs,
    reason = "a test fails by panicking; not every test uses all of a course"
)]

mod course;

use asmotion_component::{Time, Transition};
use asmotion_geometry::DECELERATION;
use asmotion_runtime::Run;
use asmotion_world::Obstacle;
use course::{Course, Drive, block, nanos};

/// Radius of the robot, m.
const RADIUS: f64 = 0.2;

/// Time in s at which the world changes; the robot drives at full speed by then.
const CHANGE: f64 = 4.0;

/// Period of the laser and of the monitor together, s.
const LOOK: f64 = 0.12;

/// A straight corridor of 40 m for a follower that sees nothing.
fn course(speed: f64) -> Course {
    Course {
        walls: [
            [-1.0, 2.0, 40.0, 2.0],
            [-1.0, -2.0, 40.0, -2.0],
            [-1.0, -2.0, -1.0, 2.0],
        ]
        .concat(),
        path: vec![(0.0, 0.0), (39.0, 0.0)],
        speed: Some(speed),
        seed: 1,
        blind_follower: true,
        ..Course::default()
    }
}

/// A wall across the corridor that appears in front of the robot, with its near side at this distance (m).
fn wall(ahead: f64) -> Obstacle {
    Obstacle {
        frame: "robot".to_owned(),
        ..block(CHANGE, ahead + 0.1, 0.0, 0.2, 3.6)
    }
}

/// Drives; the adapter is stopped, so that nobody but the monitor knows of obstacles. `silent` is stopped later.
fn drive(course: &Course, silent: Option<&str>) -> Drive {
    let mut running = course.run();
    let mut run_until = |seconds: f64, component: Option<&str>| {
        running.run.run_until(Time::from_nanos(nanos(seconds)));
        if let Some(component) = component {
            running.run.transition(component, Transition::Stop).unwrap();
        }
    };
    run_until(1.0, Some("Adapter"));
    run_until(CHANGE, silent);
    run_until(CHANGE + 6.0, None);
    let drive = running.drive.lock().unwrap();
    drive.clone()
}

/// Time in s of the first command from a time on that is slower than this speed.
fn slower(drive: &Drive, from: f64, speed: f64) -> f64 {
    let mut passed = drive.passed.iter();
    let first = passed.find(|(at, twist)| *at >= from && twist.linear.x < speed);
    first.unwrap().0
}

/// The distance in m from the place at this time (s) to the end of the drive.
fn rolled(drive: &Drive, from: f64) -> f64 {
    (drive.end() - drive.place(from)).norm()
}

#[test]
fn it_stops_before_a_wall_that_appears_at_the_stopping_distance() {
    for speed in [1.0, 2.0] {
        let stopping = speed * 0.2 + speed * speed / (2.0 * DECELERATION);
        let ahead = RADIUS + stopping + 0.1;
        let mut course = course(speed);
        course.obstacles.push(wall(ahead));
        let drive = drive(&course, None);
        assert!(!drive.codes().contains(&"COLLISION"), "{:?}", drive.events);
        let clearance = drive.nearest - RADIUS;
        assert!(clearance > 0.0, "{clearance} m at {speed} m/s");
        assert!(rolled(&drive, CHANGE) > stopping / 2.0, "it was driving");
        assert!(rolled(&drive, CHANGE + 5.0) < 0.01, "it stands");
        let braking = slower(&drive, CHANGE, 0.9 * speed) - CHANGE;
        assert!(braking <= LOOK + 0.1, "after {braking} s");
    }
}

#[test]
fn without_it_the_robot_drives_into_the_wall() {
    let mut course = course(2.0);
    course.obstacles.push(wall(RADIUS + 2.5));
    course.unmonitored = true;
    let drive = drive(&course, None);
    assert!(drive.codes().contains(&"COLLISION"), "{:?}", drive.events);
}

#[test]
fn a_silent_laser_stops_the_robot() {
    let drive = drive(&course(2.0), Some("Laser"));
    let stops = slower(&drive, CHANGE, 0.01) - CHANGE;
    assert!(stops <= 0.3 + LOOK, "after {stops} s");
    assert!(rolled(&drive, CHANGE + 4.0) < 0.01, "it stands");
}
