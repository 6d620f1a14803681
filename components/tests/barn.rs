//! The worlds of a benchmark of local navigation, driven at several speeds: the robot touches nothing.
//!
//! `barn/README.md` tells where the worlds come from.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    dead_code,
    missing_docs,
    reason = "a test fails by panicking and prints its figures; not every test uses all of a course"
)]

mod course;

use asmotion_component::Time;
use asmotion_geometry::{FREE, Grid, GridLayout, OCCUPIED, Point, heading, message};
use asmotion_messages::Event;
use asmotion_runtime::Run;
use course::{Course, disc, nanos};

const WORLDS: &str = include_str!("barn/worlds.txt");

/// Radius of a cylinder, m.
const CYLINDER: f64 = 0.075;

/// Distance between two rows or columns, m.
const PITCH: f64 = 0.15;

/// Radius of the robot, m.
const RADIUS: f64 = 0.215;

/// Goal, m.
const GOAL: (f64, f64) = (-2.25, 13.0);

/// The worlds: number and centres of the cylinders.
fn worlds() -> Vec<(u32, Vec<Point>)> {
    WORLDS
        .split("world ")
        .skip(1)
        .map(|world| {
            let (number, rows) = world.split_once('\n').unwrap();
            let rows = rows.lines().rev().enumerate();
            let cylinders = rows.flat_map(|(row, line)| {
                let marks = line.chars().enumerate().filter(|(_, mark)| *mark == '#');
                marks.map(move |(column, _)| {
                    Point::new(-4.425 + PITCH * column as f64, 0.075 + PITCH * row as f64)
                })
            });
            (number.parse().unwrap(), cylinders.collect())
        })
        .collect()
}

/// A hall around the cylinders, with a map that shows only its walls.
fn hall(cylinders: &[Point], speed: f64) -> Course {
    let corners = [(-10.0, -5.0), (6.0, -5.0), (6.0, 19.0), (-10.0, 19.0)];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let walls: Vec<[f64; 4]> = sides.map(|(a, b)| [a.0, a.1, b.0, b.1]).collect();
    let origin = heading(Point::new(-10.5, -5.5), 0.0);
    let mut grid = Grid::new(GridLayout::new(0.05, 340, 500, origin).unwrap(), FREE);
    for [x1, y1, x2, y2] in &walls {
        grid.stroke(&[Point::new(*x1, *y1), Point::new(*x2, *y2)], 0.0, OCCUPIED);
    }
    Course {
        walls: walls.concat(),
        obstacles: cylinders
            .iter()
            .map(|at| disc(0.0, at.x, at.y, CYLINDER))
            .collect(),
        start: [-2.25, 3.0, std::f64::consts::FRAC_PI_2],
        map: Some(message::occupancy_grid(&grid, 0, "map")),
        seed: 1,
        speed: Some(speed),
        radius: Some(RADIUS),
        ..Course::default()
    }
}

/// The end of a drive.
#[derive(Debug)]
struct Outcome {
    reached: bool,
    touched: bool,
    seconds: f64,
    clearance: f64,
}

fn drive(course: &Course) -> Outcome {
    let mut running = course.mission(GOAL);
    let reached = |_, event: &asmotion_runtime::Event<'_>| {
        let asmotion_runtime::Event::Published {
            component: "Follower",
            port: "event",
            sample,
            ..
        } = event
        else {
            return false;
        };
        sample
            .downcast_ref::<Event>()
            .is_some_and(|event| event.code == Event::REACHED)
    };
    let end = Time::from_nanos(nanos(100.0));
    running.run.run_until_event(end, &mut { reached });
    let drive = running.drive.lock().unwrap();
    let faults = drive.faults.iter();
    let no_path = faults.clone().all(|fault| fault.contains("NO_PATH"));
    assert!(no_path, "{:?}", drive.faults);
    println!("{:?}", drive.events);
    Outcome {
        reached: drive.codes().contains(&"REACHED"),
        touched: drive.codes().contains(&"COLLISION"),
        seconds: drive.track.last().unwrap().0,
        clearance: drive.nearest - RADIUS,
    }
}

/// Drives every world; prints the outcomes.
fn all(speed: f64, change: impl Fn(Course) -> Course) -> Vec<Outcome> {
    let outcomes = worlds().into_iter().map(|(number, cylinders)| {
        let outcome = drive(&change(hall(&cylinders, speed)));
        println!("{speed} m/s, world {number}: {outcome:?}");
        outcome
    });
    let outcomes: Vec<Outcome> = outcomes.collect();
    let count = |test: fn(&&Outcome) -> bool| outcomes.iter().filter(test).count();
    println!(
        "{speed} m/s: {} reached, {} of {} touched something",
        count(|it| it.reached),
        count(|it| it.touched),
        outcomes.len()
    );
    outcomes
}

/// Drives every world; it must touch nothing, and reach the goal in at least `least` worlds.
fn touches_nothing(speed: f64, least: usize) {
    let outcomes = all(speed, |course| course);
    assert!(outcomes.iter().all(|it| !it.touched), "{outcomes:?}");
    let reached = outcomes.iter().filter(|it| it.reached).count();
    assert!(reached >= least, "{reached} reached");
}

#[test]
fn at_half_a_metre_per_second_it_touches_nothing() {
    touches_nothing(0.5, 14);
}

#[test]
fn at_one_metre_per_second_it_touches_nothing() {
    touches_nothing(1.0, 13);
}

#[test]
fn at_two_metres_per_second_it_touches_nothing() {
    touches_nothing(2.0, 13);
}

#[test]
fn without_scan_and_monitor_it_touches_something() {
    let outcomes = all(2.0, |course| Course {
        blind_follower: true,
        unmonitored: true,
        ..course
    });
    assert!(outcomes.iter().any(|it| it.touched));
}
