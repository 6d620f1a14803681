//! The guarantees of a planner, as a test suite that every planner passes.
//!
//! A case plans in small worlds and returns a description of the failure, if any. Most cases run with and without a
//! preference for clearance.

mod reference;

use std::panic::{AssertUnwindSafe, catch_unwind};

use asmotion_geometry::{
    Cell, FREE, Grid, GridLayout, OCCUPIED, Point, Pose, UNKNOWN, Vector, heading, yaw,
};

use crate::planner::{NoPath, PlannedPath, PlannerSettings};
use crate::planners::MakePlanner;
use reference::Reference;

/// Side of a cell of the worlds, m.
const RESOLUTION: f64 = 0.1;

/// Number of random worlds in which a planner is compared with an exhaustive search.
const WORLDS: u64 = 300;

type Case = fn(MakePlanner) -> Result<(), String>;

const CASES: &[(&str, Case)] = &[
    ("a path leads from room to room", goes_from_room_to_room),
    ("a path is straight where nothing is", goes_straight),
    ("a path begins and ends exactly at the poses", ends_exactly),
    (
        "a robot at its goal has a path of one pose",
        is_there_already,
    ),
    ("a refusal has the code of its reason", says_why),
    (
        "a robot that is too near to a wall leaves it",
        leaves_the_wall,
    ),
    ("the unknown is crossed only if allowed", avoids_the_unknown),
    (
        "a wide corridor is driven in its middle",
        keeps_to_the_middle,
    ),
    ("an empty map is refused", refuses_an_empty_map),
    (
        "a path is found if there is one, and is near the shortest",
        finds_what_there_is,
    ),
    ("a plan does not depend on earlier ones", forgets),
    ("any pose is answered", takes_any_pose),
];

/// Runs the suite; a planner keeps the contract if this is empty. A violation is the case, and the observed behaviour.
pub fn violations(make: MakePlanner) -> Vec<String> {
    let run = |(case, check): &(&str, Case)| {
        let checked = catch_unwind(AssertUnwindSafe(|| check(make)));
        let observed = checked
            .unwrap_or_else(|_| Err("panicked".to_owned()))
            .err()?;
        Some(format!("{case}: {observed}"))
    };
    CASES.iter().filter_map(run).collect()
}

const ROOMS: &[&str] = &[
    "##############################",
    "#............#...............#",
    "#............#...............#",
    "#............#.......#########",
    "#............................#",
    "#............................#",
    "#............................#",
    "#............................#",
    "#............................#",
    "#............#...............#",
    "#............#...............#",
    "##############################",
];

/// The settings of most cases: with and without a preference for clearance.
fn settings() -> [PlannerSettings; 2] {
    let settings = PlannerSettings {
        inflation_m: 0.2,
        comfort_m: 0.3,
        ..PlannerSettings::default()
    };
    [settings.clone(), settings.shortest()]
}

fn goes_from_room_to_room(make: MakePlanner) -> Result<(), String> {
    let grid = picture(ROOMS)?;
    let (start, goal) = (centre(&grid, (4, 8), 1.0), centre(&grid, (24, 4), -2.0));
    for settings in settings() {
        let path = plan(make, &settings, &grid, &start, &goal)?;
        check_path(&grid, &settings, &start, &goal, &path)?;
    }
    Ok(())
}

fn goes_straight(make: MakePlanner) -> Result<(), String> {
    let grid = free(GridLayout::new(
        RESOLUTION,
        60,
        50,
        heading(Point::new(-3.0, 7.0), 0.4),
    ))?;
    let (start, goal) = (centre(&grid, (3, 5), 0.0), centre(&grid, (55, 31), 0.0));
    let straight = (place(&goal) - place(&start)).norm();
    for settings in settings() {
        let path = plan(make, &settings, &grid, &start, &goal)?;
        require((path.length - straight).abs() < 1e-9, || {
            format!("{} m instead of {straight} m", path.length)
        })?;
    }
    Ok(())
}

fn ends_exactly(make: MakePlanner) -> Result<(), String> {
    let grid = picture(ROOMS)?;
    let start = heading(Point::new(0.412, 0.833), 0.0);
    let goal = heading(Point::new(2.487, 0.561), 3.0);
    for settings in settings() {
        let path = plan(make, &settings, &grid, &start, &goal)?;
        check_path(&grid, &settings, &start, &goal, &path)?;
    }
    Ok(())
}

fn is_there_already(make: MakePlanner) -> Result<(), String> {
    let grid = picture(ROOMS)?;
    let (start, goal) = (centre(&grid, (5, 6), 0.0), centre(&grid, (5, 6), 2.0));
    for settings in settings() {
        let path = plan(make, &settings, &grid, &start, &goal)?;
        require((path.length, path.poses.len()) == (0.0, 1), || {
            format!("{} m with {} poses", path.length, path.poses.len())
        })?;
        let turned = path.poses.first().map(yaw).unwrap_or_default();
        require((turned - 2.0).abs() < 1e-12, || {
            format!("the robot faces {turned} rad instead of 2 rad")
        })?;
    }
    Ok(())
}

fn says_why(make: MakePlanner) -> Result<(), String> {
    let grid = picture(&[
        "####################",
        "#........#.........#",
        "#........#.........#",
        "#........#.........#",
        "#........#........?#",
        "#........#.........#",
        "#........#.........#",
        "####################",
    ])?;
    let requests = [
        ((0.45, 0.35), (1.45, 0.35), "NO_PATH"),
        ((0.45, 0.35), (0.95, 0.35), "GOAL_OCCUPIED"),
        ((0.45, 0.35), (0.15, 0.35), "GOAL_OCCUPIED"),
        ((1.45, 0.35), (1.85, 0.35), "GOAL_OCCUPIED"),
        ((0.05, 0.35), (0.45, 0.35), "START_OCCUPIED"),
        ((0.45, 0.35), (9.0, 0.35), "OUTSIDE"),
        ((-0.01, 0.35), (0.45, 0.35), "OUTSIDE"),
        ((f64::NAN, 0.35), (0.45, 0.35), "OUTSIDE"),
    ];
    for settings in settings() {
        for (from, to, expected) in requests {
            let [start, goal] = [from, to].map(|(x, y)| heading(Point::new(x, y), 0.0));
            let answer = make(&settings).plan(&grid, &start, &goal);
            let observed = answer.err().map(|error| error.code());
            require(observed == Some(expected), || {
                format!("from {from:?} to {to:?}: {observed:?} instead of {expected}")
            })?;
        }
    }
    Ok(())
}

fn leaves_the_wall(make: MakePlanner) -> Result<(), String> {
    let grid = picture(ROOMS)?;
    let (start, goal) = (centre(&grid, (1, 6), 0.0), centre(&grid, (24, 5), 0.0));
    for settings in settings() {
        let path = plan(make, &settings, &grid, &start, &goal)?;
        check_path(&grid, &settings, &start, &goal, &path)?;
        let third = path.poses.get(2).map(place);
        let leaves = third.is_some_and(|third| third.x > place(&start).x + 0.1);
        require(leaves, || {
            "the path leads along the wall, not straight away from it".to_owned()
        })?;
    }
    Ok(())
}

fn avoids_the_unknown(make: MakePlanner) -> Result<(), String> {
    let grid = picture(&[
        "####################",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "####################",
    ])?;
    let (start, goal) = (centre(&grid, (4, 3), 0.0), centre(&grid, (15, 3), 0.0));
    let settings = PlannerSettings {
        inflation_m: 0.2,
        ..PlannerSettings::default()
    };
    let refused = make(&settings).plan(&grid, &start, &goal);
    require(matches!(refused, Err(NoPath::Unreachable { .. })), || {
        format!("{refused:?} instead of `Unreachable`")
    })?;
    let allowed = PlannerSettings {
        allow_unknown: true,
        ..settings
    };
    plan(make, &allowed, &grid, &start, &goal).map(drop)
}

fn keeps_to_the_middle(make: MakePlanner) -> Result<(), String> {
    let mut grid = free(GridLayout::new(0.05, 400, 40, Pose::identity()))?;
    let wall = |y: f64| [Point::new(0.0, y), Point::new(20.0, y)];
    grid.stroke(&wall(0.0), 0.0, OCCUPIED);
    grid.stroke(&wall(1.99), 0.0, OCCUPIED);
    let [start, goal] = [1.0, 19.0].map(|x| heading(Point::new(x, 0.4), 0.0));
    let path = plan(make, &PlannerSettings::default(), &grid, &start, &goal)?;
    let in_the_middle = |pose: &&Pose| (pose.translation.y - 1.0).abs() < 0.35;
    let middle = path.poses.iter().filter(in_the_middle).count();
    require(middle * 10 > path.poses.len() * 8, || {
        format!("{middle} of {} poses are in the middle", path.poses.len())
    })
}

fn refuses_an_empty_map(make: MakePlanner) -> Result<(), String> {
    let empty = free(GridLayout::new(1.0, 0, 0, Pose::identity()))?;
    for settings in settings() {
        let answer = make(&settings).plan(&empty, &Pose::identity(), &Pose::identity());
        let observed = answer.err().map(|error| error.code());
        require(observed == Some("OUTSIDE"), || format!("{observed:?}"))?;
    }
    Ok(())
}

/// A path is found if and only if a search of all cells finds one; it is clear, and not much longer than the shortest one on
/// the grid.
fn finds_what_there_is(make: MakePlanner) -> Result<(), String> {
    for seed in 0..WORLDS {
        let mut random = Random(seed);
        let grid = random.grid()?;
        let (_, far) = grid.layout().bounds();
        let mut pose = |yaw| {
            let (x, y) = (random.fraction() * far.x, random.fraction() * far.y);
            heading(Point::new(x, y), yaw)
        };
        let (start, goal) = (pose(0.0), pose(1.0));
        let preferred = PlannerSettings {
            inflation_m: random.below(3) as f64 * RESOLUTION,
            comfort_m: 0.3,
            ..PlannerSettings::default()
        };
        for settings in [preferred.clone(), preferred.shortest()] {
            compare(make, &settings, &grid, &start, &goal)
                .map_err(|observed| format!("random world {seed}: {observed}"))?;
        }
    }
    Ok(())
}

fn compare(
    make: MakePlanner,
    settings: &PlannerSettings,
    grid: &Grid,
    start: &Pose,
    goal: &Pose,
) -> Result<(), String> {
    let mut planner = make(settings);
    let answer = planner.plan(grid, start, goal);
    let reference = Reference::new(grid, settings);
    let shortest = reference.shortest(place(start), place(goal));
    match (&answer, shortest) {
        (Ok(path), Some(shortest)) => {
            check_path(grid, settings, start, goal, path)?;
            // the ends may be half a cell off the centres between which the shortest path is measured
            let bound = 1.05 * (1.0 + settings.clearance_weight) * shortest + 1.5 * RESOLUTION;
            let cell = grid.layout().cell(place(start));
            // a robot that is too near to an obstacle leaves first, however long that takes
            let leaves = cell.is_some_and(|cell| reference.tight(cell));
            require(leaves || path.length <= bound, || {
                format!("{} m, the shortest path has {shortest} m", path.length)
            })?;
        }
        (Err(_), None) => {}
        (Ok(_), None) => return Err("a path where there is none".to_owned()),
        (Err(error), Some(shortest)) => {
            return Err(format!("{error}, but there is a path of {shortest} m"));
        }
    }
    require(answer == planner.plan(grid, start, goal), || {
        "the same request has another answer".to_owned()
    })?;
    require(answer == make(settings).plan(grid, start, goal), || {
        "a new planner has another answer".to_owned()
    })
}

fn forgets(make: MakePlanner) -> Result<(), String> {
    let settings = PlannerSettings {
        inflation_m: 0.1,
        ..PlannerSettings::default()
    };
    let [start, goal] = [0.15, 0.35].map(|at| heading(Point::new(at, at), 0.0));
    for seed in 0..WORLDS {
        let mut random = Random(seed);
        let (one, other) = (random.grid()?, random.grid()?);
        let mut used = make(&settings);
        // only the effect on the next plan matters
        let _ = used.plan(&one, &start, &goal);
        let same = used.plan(&other, &start, &goal) == make(&settings).plan(&other, &start, &goal);
        require(same, || {
            format!("random worlds {seed}: another answer after another map")
        })?;
    }
    Ok(())
}

fn takes_any_pose(make: MakePlanner) -> Result<(), String> {
    let grid = picture(ROOMS)?;
    let numbers = [
        0.0,
        -0.0,
        0.5,
        -1.0,
        1e-300,
        1e300,
        f64::MAX,
        f64::MIN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    let known = centre(&grid, (4, 8), 0.0);
    for x in numbers {
        for y in numbers {
            for yaw in numbers {
                let pose = Pose::new(Vector::new(x, y), yaw);
                for (start, goal) in [(&pose, &known), (&known, &pose)] {
                    // any answer will do, but no panic
                    let _ = make(&PlannerSettings::default()).plan(&grid, start, goal);
                }
            }
        }
    }
    Ok(())
}

/// Checks all guarantees for a path from `start` to `goal`.
fn check_path(
    grid: &Grid,
    settings: &PlannerSettings,
    start: &Pose,
    goal: &Pose,
    path: &PlannedPath,
) -> Result<(), String> {
    let (Some(first), Some(last)) = (path.poses.first(), path.poses.last()) else {
        return Err("a path without poses".to_owned());
    };
    let exact = place(first) == place(start)
        && place(last) == place(goal)
        && (yaw(last) - yaw(goal)).abs() < 1e-9;
    require(exact, || {
        format!("from {first} to {last} instead of from {start} to {goal}")
    })?;
    let points: Vec<Point> = path.poses.iter().map(place).collect();
    let steps = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
    let steps: f64 = steps.sum();
    require((steps - path.length).abs() < 1e-6, || {
        format!("`length` is {} m, the steps have {steps} m", path.length)
    })?;
    for (pose, pair) in path.poses.iter().zip(points.windows(2)) {
        let step = pair[1] - pair[0];
        require(step.norm() <= settings.step_m + 1e-9, || {
            format!("a step of {} m at {}", step.norm(), pair[0])
        })?;
        let ahead = step.y.atan2(step.x) - yaw(pose);
        require(step.norm() < 1e-9 || ahead.sin().abs() < 1e-6, || {
            format!("the pose at {} does not face the next one", pair[0])
        })?;
    }
    check_clear(grid, settings, &points)
}

/// Checks that no touched cell is occupied or unknown, and none is too near unless the robot started there and has not
/// left yet. (On its way out it may touch the corner of a cell that is clear.)
fn check_clear(grid: &Grid, settings: &PlannerSettings, points: &[Point]) -> Result<(), String> {
    let reference = Reference::new(grid, settings);
    let tight = |point: Point| {
        let cell = grid.layout().cell(point);
        let cell = cell.ok_or_else(|| format!("the path leaves the map at {point}"))?;
        require(!reference.wall(cell), || {
            format!("the path leads through a wall at {point}")
        })?;
        Ok::<_, String>(reference.tight(cell))
    };
    let Some(first) = points.first() else {
        return Ok(());
    };
    let mut clear = if tight(*first)? { 0.0 } else { f64::INFINITY };
    for pair in points.windows(2) {
        let step = (pair[1] - pair[0]) / 20.0;
        for piece in 0..=20 {
            let point = pair[0] + step * f64::from(piece);
            if tight(point)? {
                require(clear < 1.5 * RESOLUTION, || {
                    format!("the path is too near to a wall at {point}")
                })?;
                clear = 0.0;
            } else {
                clear += step.norm();
            }
        }
    }
    Ok(())
}

fn plan(
    make: MakePlanner,
    settings: &PlannerSettings,
    grid: &Grid,
    start: &Pose,
    goal: &Pose,
) -> Result<PlannedPath, String> {
    let answer = make(settings).plan(grid, start, goal);
    answer.map_err(|error| format!("from {start} to {goal}: {error}"))
}

/// Creates a grid from a picture: rows from top to bottom, `#` occupied, `?` unknown, anything else free.
fn picture(rows: &[&str]) -> Result<Grid, String> {
    let width = rows.first().map_or(0, |row| row.len()) as u32;
    let mut grid = free(GridLayout::new(
        RESOLUTION,
        width,
        rows.len() as u32,
        Pose::identity(),
    ))?;
    for (row, line) in rows.iter().rev().enumerate() {
        for (column, letter) in line.chars().enumerate() {
            let value = match letter {
                '#' => OCCUPIED,
                '?' => UNKNOWN,
                _ => FREE,
            };
            grid.set(Cell::new(column as u32, row as u32), value);
        }
    }
    Ok(grid)
}

fn free<E: ToString>(layout: Result<GridLayout, E>) -> Result<Grid, String> {
    let layout = layout.map_err(|error| error.to_string())?;
    Ok(Grid::new(layout, FREE))
}

fn centre(grid: &Grid, (column, row): (u32, u32), yaw: f64) -> Pose {
    heading(grid.layout().centre(Cell::new(column, row)), yaw)
}

fn place(pose: &Pose) -> Point {
    Point::from(pose.translation.vector)
}

fn require(condition: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if condition { Ok(()) } else { Err(otherwise()) }
}

/// Random numbers that are the same on every machine (SplitMix64, Steele et al. 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }

    /// A number in 0..1.
    fn fraction(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A grid in which between every third and every thirtieth cell is occupied.
    fn grid(&mut self) -> Result<Grid, String> {
        let [width, height] = [4 + self.below(36), 4 + self.below(36)].map(|side| side as u32);
        let rarity = 3 + self.below(27);
        let mut grid = free(GridLayout::new(RESOLUTION, width, height, Pose::identity()))?;
        for row in 0..height {
            for column in 0..width {
                if self.below(rarity) == 0 {
                    grid.set(Cell::new(column, row), OCCUPIED);
                }
            }
        }
        Ok(grid)
    }
}
