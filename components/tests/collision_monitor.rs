//! The collision monitor between a follower without a laser and the rover: it alone prevents collisions.

use crate::course::{Course, Drive, block, nanos};
use asmotion_component::{Time, Transition};
use asmotion_datum::Datum;
use asmotion_geometry::{DECELERATION, Point};
use asmotion_messages::{Path, Pose};
use asmotion_runtime::Run;
use asmotion_world::Obstacle;

/// Radius of the robot, m.
const RADIUS: f64 = 0.2;

/// Time in s at which the world changes; the robot drives at full speed by then.
const CHANGE: f64 = 4.0;

/// Period of the laser and of the monitor together, s.
const LOOK: f64 = 0.07;

/// Time in s within which the wheels are braked after an obstacle has appeared within the stopping distance.
const STOP_TIME: f64 = 0.1;

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
    }
}

/// Time in s from a change of the world to the first wheel speeds of a braking rover.
fn brakes_after(drive: &Drive, change: f64, speed: f64) -> f64 {
    let mean = |wheels: &asmotion_messages::WheelSpeeds| 0.05 * (wheels.left + wheels.right) / 2.0;
    let before = drive.wheels.iter().rfind(|(at, _)| *at < change);
    assert!(
        (mean(&before.unwrap().1) - speed).abs() < 1e-3,
        "{before:?}"
    );
    let mut after = drive.wheels.iter().skip_while(|(at, _)| *at < change);
    let braked = after.find(|(_, wheels)| mean(wheels) < 0.99 * speed);
    braked.unwrap().0 - change
}

#[test]
fn the_wheels_are_braked_within_100_ms_whenever_a_wall_appears() {
    for (speed, phase) in [1.0, 2.0]
        .into_iter()
        .flat_map(|speed| (0..5).map(move |n| (speed, n)))
    {
        let change = CHANGE + 0.02 * f64::from(phase);
        // less than the distance that the monitor reckons with, so that its first look must stop the robot
        let stopping = speed * 0.15 + speed * speed / (2.0 * DECELERATION);
        let mut course = course(speed);
        course.obstacles.push(Obstacle {
            at_s: change,
            ..wall(RADIUS + 0.02 + stopping)
        });
        let drive = drive(&course, None);
        assert!(!drive.codes().contains(&"COLLISION"), "{:?}", drive.events);
        let braked = brakes_after(&drive, change, speed);
        assert!(braked <= STOP_TIME, "after {braked} s, from {change} s on");
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

/// The rover drives into a wall that nobody but the rover's own wheels notices.
fn bumps() -> crate::course::Running {
    let mut course = course(0.5);
    course.obstacles.push(wall(RADIUS + 0.2));
    course.unmonitored = true;
    let mut running = course.run();
    running.run.run_until(Time::from_nanos(nanos(1.0)));
    running.run.transition("Adapter", Transition::Stop).unwrap();
    running.run.run_until(Time::from_nanos(nanos(CHANGE + 2.0)));
    running
}

#[test]
fn n4_wheels_that_stall_are_a_contact_and_stand_although_the_follower_drives_on() {
    let running = bumps();
    let drive = running.drive.lock().unwrap();
    assert_eq!(drive.codes(), ["COLLISION", "CONTACT"]);
    let noticed = drive.at("CONTACT") - drive.at("COLLISION");
    assert!(noticed <= 0.14, "after {noticed} s");
    let (_, _, detail) = &drive.events[1];
    assert!(detail.starts_with("both wheels stall at ("), "{detail}");
    let stands_from = drive.wheels_stand_from(CHANGE);
    assert_eq!(stands_from, drive.at("CONTACT"));
    let (at, twist) = drive.twists.last().unwrap();
    assert!(*at > stands_from + 1.0 && twist.linear.x > 0.1, "{twist:?}");
}

#[test]
fn after_a_stop_a_rover_in_contact_drives_elsewhere() {
    let mut running = bumps();
    let mut order = |seconds: f64, path: Path| {
        let at = Time::from_nanos(nanos(seconds));
        running.run.inject(at, "Follower.path", path).unwrap();
    };
    let here = running.drive.lock().unwrap().end();
    let back = [here, Point::new(here.x - 1.0, here.y)];
    let poses = back.map(|at| Pose::planar(at.x, at.y, std::f64::consts::PI));
    order(CHANGE + 2.1, Path::stop(nanos(CHANGE + 2.1), "map"));
    order(
        CHANGE + 2.5,
        Path::from_poses(nanos(CHANGE + 2.5), "map", poses),
    );
    running
        .run
        .run_until(Time::from_nanos(nanos(CHANGE + 12.0)));
    let drive = running.drive.lock().unwrap();
    assert_eq!(
        drive.codes(),
        ["COLLISION", "CONTACT", "HALTED", "REACHED"],
        "{:?}",
        drive.events
    );
    assert!((drive.end() - back[1]).norm() < 0.1);
}

#[test]
fn a_scan_within_the_robot_is_a_contact() {
    let mut course = course(0.5);
    course.obstacles.push(wall(RADIUS + 0.3));
    let mut running = course.run();
    // the monitor takes the robot for larger than it is
    let larger = [("robot_radius_m".to_owned(), Datum::Float(0.6))];
    running.run.set_properties("Monitor", &larger).unwrap();
    running.run.run_until(Time::from_nanos(nanos(CHANGE + 2.0)));
    let drive = running.drive.lock().unwrap();
    let contacts = drive.events.iter().filter(|(_, code, _)| code == "CONTACT");
    let details: Vec<&str> = contacts.map(|(_, _, detail)| detail.as_str()).collect();
    assert_eq!(details, ["the scan ends within the robot"]);
    assert!(rolled(&drive, CHANGE + 1.5) < 0.01, "it stands");
}

#[test]
fn a_silent_laser_stops_the_robot() {
    let drive = drive(&course(2.0), Some("Laser"));
    let stops = slower(&drive, CHANGE, 0.01) - CHANGE;
    assert!(stops <= 0.3 + LOOK, "after {stops} s");
    assert!(rolled(&drive, CHANGE + 4.0) < 0.01, "it stands");
}
