//! The worlds of a benchmark of local navigation, driven at several speeds: the robot touches nothing.
//!

//! `barn/README.md` tells where the worlds come from.

use crate::course::{Course, disc, nanos};
use asmotion_component::Time;
use asmotion_geometry::{
    FREE, Grid, GridLayout, OCCUPIED, ObstacleScene, Point, RoundObstacle, heading, message,
};
use asmotion_messages::Event;
use asmotion_runtime::Run;

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
    #[expect(dead_code, reason = "printed")]
    clearance: f64,
    /// `true` if a request found no path.
    no_path: bool,
}

fn drive(course: &Course) -> Outcome {
    let radius = course.radius.unwrap();
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
    Outcome {
        reached: drive.codes().contains(&"REACHED"),
        touched: drive.codes().contains(&"COLLISION"),
        seconds: drive.track.last().unwrap().0,
        clearance: drive.nearest - radius,
        no_path: !drive.faults.is_empty(),
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
    touches_nothing(0.5, 15);
}

#[test]
fn at_one_metre_per_second_it_touches_nothing() {
    touches_nothing(1.0, 15);
}

#[test]
fn at_two_metres_per_second_it_touches_nothing() {
    touches_nothing(2.0, 15);
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

/// Radii of the robot and the margins it keeps, m.
const ROBOTS: [(f64, f64); 3] = [(0.2, 0.08), (RADIUS, 0.08), (0.3, 0.06)];

/// Columns and rows of a generated world.
const FIELD: (usize, usize) = (30, 56);

/// Generates a world in the manner of BARN: cells filled at random, then smoothed by a cellular automaton, between two walls.
fn generated(seed: u64) -> Vec<Point> {
    let (columns, rows) = FIELD;
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    let mut roll = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    for _ in 0..8 {
        roll();
    }
    let mut filled: Vec<bool> = (0..columns * rows).map(|_| roll() < 0.2).collect();
    for _ in 0..3 {
        filled = (0..columns * rows).map(|at| is_kept(&filled, at)).collect();
    }
    let is_wall = |at: usize| at.is_multiple_of(columns) || at % columns == columns - 1;
    let cylinders = (0..columns * rows).filter(|at| filled[*at] || is_wall(*at));
    cylinders
        .map(|at| {
            let (column, row) = (at % columns, at / columns);
            Point::new(-4.425 + PITCH * column as f64, 4.0 + PITCH * row as f64)
        })
        .collect()
}

/// Returns whether a cell is filled in the next generation: with five filled neighbours, or filled with two.
fn is_kept(filled: &[bool], at: usize) -> bool {
    let (columns, rows) = (FIELD.0 as i64, FIELD.1 as i64);
    let (column, row) = (at as i64 % columns, at as i64 / columns);
    let nearby = (-1..=1).flat_map(|up| (-1..=1).map(move |side| (column + side, row + up)));
    let neighbours = nearby.filter(|(x, y)| {
        let inside = (0..columns).contains(x) && (0..rows).contains(y);
        inside && (*x, *y) != (column, row) && filled[(y * columns + x) as usize]
    });
    let count = neighbours.count();
    count >= 5 || filled[at] && count >= 2
}

/// Returns whether a way leads between the cylinders to the goal at this distance (m) from all of them.
fn has_way(cylinders: &[Point], distance: f64) -> bool {
    const STEP: f64 = 0.05;
    let at =
        |(x, y): (i32, i32)| Point::new(-2.25 + STEP * f64::from(x), 3.0 + STEP * f64::from(y));
    let discs = cylinders.iter().map(|centre| RoundObstacle {
        centre: *centre,
        radius: CYLINDER,
    });
    let scene = ObstacleScene::new(Vec::new(), Vec::new(), discs.collect());
    let mut seen = std::collections::BTreeSet::from([(0_i32, 0_i32)]);
    let mut queue = vec![(0_i32, 0_i32)];
    while let Some((x, y)) = queue.pop() {
        for next in [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)] {
            let inside = next.0.abs() < 42 && (0..=200).contains(&next.1);
            if inside && scene.clearance(at(next)) >= distance && seen.insert(next) {
                queue.push(next);
            }
        }
    }
    seen.contains(&(0, 200))
}

#[test]
fn where_a_way_is_wide_enough_it_is_found() {
    for (radius, margin) in ROBOTS {
        let all = (1..=20).map(|seed| (seed, generated(seed)));
        let worlds: Vec<_> = all
            .filter(|(_, cylinders)| has_way(cylinders, radius + margin))
            .collect();
        println!("{radius} m: {} worlds", worlds.len());
        assert!(worlds.len() >= 8, "{} worlds", worlds.len());
        for (seed, cylinders) in worlds {
            let course = Course {
                radius: Some(radius),
                margin: Some(margin),
                ..hall(&cylinders, 1.0)
            };
            let outcome = drive(&course);
            let done = outcome.reached && !outcome.touched && !outcome.no_path;
            assert!(done, "world {seed}, {radius} m: {outcome:?}");
        }
    }
}

/// Reads the worlds of a folder, `world_<number>.world`, whose number is a multiple of `every`.
fn folder(path: &std::path::Path, every: u32) -> Vec<(u32, Vec<Point>)> {
    let entries = std::fs::read_dir(path).unwrap();
    let mut worlds: Vec<(u32, Vec<Point>)> = entries
        .filter_map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name()?.to_str()?;
            let number = name.strip_prefix("world_")?.strip_suffix(".world")?;
            let number: u32 = number.parse().ok()?;
            number
                .is_multiple_of(every)
                .then(|| (number, cylinders(&path)))
        })
        .collect();
    worlds.sort_by_key(|(number, _)| *number);
    worlds
}

/// The centres of the static cylinders of a Gazebo world.
fn cylinders(path: &std::path::Path) -> Vec<Point> {
    let text = std::fs::read_to_string(path).unwrap();
    let models = text.split("<model name='unit_cylinder").skip(1);
    models
        .filter(|model| {
            let end = model.find("<link").unwrap_or(0);
            model[..end].contains("<static>1</static>")
        })
        .map(|model| {
            let (_, pose) = model.split_once("<pose frame=''>").unwrap();
            let mut numbers = pose.split(' ').map(|number| number.parse().unwrap());
            Point::new(numbers.next().unwrap(), numbers.next().unwrap())
        })
        .collect()
}

/// `BARN_WORLDS=FOLDER cargo test -p asmotion-components --test main -- barn:: --ignored --nocapture` drives the worlds of a folder
/// whose number is a multiple of six.
#[test]
#[ignore = "needs the worlds of the BARN challenge"]
fn the_worlds_of_a_folder() {
    let Some(path) = std::env::var_os("BARN_WORLDS") else {
        println!("*** SKIPPED: set BARN_WORLDS to jackal_helper/worlds/BARN of the BARN challenge");
        return;
    };
    let worlds = folder(path.as_ref(), 6);
    assert!(!worlds.is_empty(), "no world in {}", path.display());
    println!("| radius, m | speed, m/s | reached | touched | no path | mean time, s |");
    println!("|---|---|---|---|---|---|");
    for (radius, margin) in ROBOTS {
        for speed in [0.5, 1.0, 2.0] {
            let outcomes = worlds.iter().map(|(number, cylinders)| {
                let course = Course {
                    radius: Some(radius),
                    margin: Some(margin),
                    ..hall(cylinders, speed)
                };
                (*number, drive(&course))
            });
            print_row(radius, speed, &outcomes.collect::<Vec<_>>());
        }
    }
}

/// Prints a row of the table, and the outcomes of the worlds that went wrong.
fn print_row(radius: f64, speed: f64, outcomes: &[(u32, Outcome)]) {
    let count = |test: fn(&Outcome) -> bool| outcomes.iter().filter(|(_, it)| test(it)).count();
    let succeeded = |it: &Outcome| it.reached && !it.touched;
    let arrived: Vec<f64> = outcomes
        .iter()
        .filter(|(_, it)| succeeded(it))
        .map(|(_, it)| it.seconds)
        .collect();
    println!(
        "| {radius} | {speed} | {} / {} | {} | {} | {:.1} |",
        arrived.len(),
        outcomes.len(),
        count(|it| it.touched),
        count(|it| it.no_path),
        arrived.iter().sum::<f64>() / arrived.len().max(1) as f64
    );
    for (number, outcome) in outcomes.iter().filter(|(_, it)| !succeeded(it)) {
        println!("world {number}: {outcome:?}");
    }
}
