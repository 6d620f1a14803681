//! The guarantees of planners, tested for every row of `PLANNERS`.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

mod reference;

use asmotion_geometry::{
    Cell, FREE, Grid, GridLayout, OCCUPIED, Point, Pose, UNKNOWN, Vector, heading, yaw,
};
use asmotion_planner::{NoPath, PLANNERS, PlannedPath, Planner, PlannerSettings};
use proptest::prelude::*;
use reference::Reference;

const RESOLUTION: f64 = 0.1;

/// Runs a check for every planner, with and without a preference for clearance.
fn each(check: impl Fn(&str, &PlannerSettings, &mut dyn Planner)) {
    let settings = PlannerSettings {
        inflation_m: 0.2,
        comfort_m: 0.3,
        ..PlannerSettings::default()
    };
    for (name, make) in PLANNERS {
        for settings in [settings.clone(), settings.clone().shortest()] {
            check(name, &settings, make(&settings).as_mut());
        }
    }
}

/// Creates a grid from a picture: rows from top to bottom, `#` occupied, `?` unknown, anything else free.
fn picture(rows: &[&str]) -> Grid {
    let layout = GridLayout::new(
        RESOLUTION,
        rows[0].len() as u32,
        rows.len() as u32,
        Pose::identity(),
    );
    let mut grid = Grid::new(layout.unwrap(), FREE);
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
    grid
}

fn centre(grid: &Grid, cell: (u32, u32), yaw: f64) -> Pose {
    heading(grid.layout().centre(Cell::new(cell.0, cell.1)), yaw)
}

fn place(pose: &Pose) -> Point {
    Point::from(pose.translation.vector)
}

/// Checks all guarantees for a path from `start` to `goal`.
fn check_plan(
    grid: &Grid,
    settings: &PlannerSettings,
    start: &Pose,
    goal: &Pose,
    plan: &PlannedPath,
) {
    let (first, last) = (plan.poses.first().unwrap(), plan.poses.last().unwrap());
    assert_eq!(place(first), place(start));
    assert_eq!(place(last), place(goal));
    assert!((yaw(last) - yaw(goal)).abs() < 1e-9);
    let points: Vec<Point> = plan.poses.iter().map(place).collect();
    let steps: f64 = points
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).norm())
        .sum();
    assert!(
        (steps - plan.length).abs() < 1e-6,
        "{steps} {}",
        plan.length
    );
    for (pose, pair) in plan.poses.iter().zip(points.windows(2)) {
        let step = pair[1] - pair[0];
        assert!(step.norm() <= settings.step_m + 1e-9);
        let ahead = step.y.atan2(step.x) - yaw(pose);
        assert!(
            step.norm() < 1e-9 || ahead.sin().abs() < 1e-6,
            "looks elsewhere"
        );
    }
    check_clear(grid, settings, &points);
}

/// Checks that no touched cell is occupied or unknown, and none is too near unless the robot started there and has not
/// left yet. (On its way out it may touch the corner of a cell that is clear.)
fn check_clear(grid: &Grid, settings: &PlannerSettings, points: &[Point]) {
    let reference = Reference::new(grid, settings);
    let tight = |point: Point| {
        let cell = grid.layout().cell(point).expect("leaves the map");
        assert!(!reference.wall(cell), "through a wall at {point}");
        reference.tight(cell)
    };
    let leaves = tight(points[0]);
    let mut clear = if leaves { 0.0 } else { f64::INFINITY };
    for pair in points.windows(2) {
        let step = (pair[1] - pair[0]) / 20.0;
        for piece in 0..=20 {
            let point = pair[0] + step * f64::from(piece);
            if tight(point) {
                assert!(clear < 1.5 * RESOLUTION, "too near at {point}");
                clear = 0.0;
            } else {
                clear += step.norm();
            }
        }
    }
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

#[test]
fn n8_it_goes_from_room_to_room() {
    each(|_, settings, planner| {
        let grid = picture(ROOMS);
        let (start, goal) = (centre(&grid, (4, 8), 1.0), centre(&grid, (24, 4), -2.0));
        let plan = planner.plan(&grid, &start, &goal).unwrap();
        check_plan(&grid, settings, &start, &goal, &plan);
    });
}

#[test]
fn it_goes_straight_where_nothing_is() {
    each(|_, _, planner| {
        let layout =
            GridLayout::new(RESOLUTION, 60, 50, heading(Point::new(-3.0, 7.0), 0.4)).unwrap();
        let grid = Grid::new(layout, FREE);
        let (start, goal) = (centre(&grid, (3, 5), 0.0), centre(&grid, (55, 31), 0.0));
        let plan = planner.plan(&grid, &start, &goal).unwrap();
        let straight = (place(&goal) - place(&start)).norm();
        assert!((plan.length - straight).abs() < 1e-9);
    });
}

#[test]
fn it_ends_exactly_where_it_was_asked_to() {
    each(|_, settings, planner| {
        let grid = picture(ROOMS);
        let (start, goal) = (
            heading(Point::new(0.412, 0.833), 0.0),
            heading(Point::new(2.487, 0.561), 3.0),
        );
        let plan = planner.plan(&grid, &start, &goal).unwrap();
        check_plan(&grid, settings, &start, &goal, &plan);
    });
}

#[test]
fn it_is_there_already() {
    each(|_, _, planner| {
        let grid = picture(ROOMS);
        let (start, goal) = (centre(&grid, (5, 6), 0.0), centre(&grid, (5, 6), 2.0));
        let plan = planner.plan(&grid, &start, &goal).unwrap();
        assert_eq!((plan.length, plan.poses.len()), (0.0, 1));
        assert!((yaw(&plan.poses[0]) - 2.0).abs() < 1e-12);
    });
}

#[test]
fn n8_it_says_why_there_is_no_path() {
    each(|_, _, planner| {
        let grid = picture(&[
            "####################",
            "#........#.........#",
            "#........#.........#",
            "#........#.........#",
            "#........#........?#",
            "#........#.........#",
            "#........#.........#",
            "####################",
        ]);
        let mut code = |from: (f64, f64), to: (f64, f64)| {
            let [from, to] = [from, to].map(|(x, y)| heading(Point::new(x, y), 0.0));
            planner.plan(&grid, &from, &to).unwrap_err().code()
        };
        assert_eq!(code((0.45, 0.35), (1.45, 0.35)), "NO_PATH");
        assert_eq!(code((0.45, 0.35), (0.95, 0.35)), "GOAL_OCCUPIED");
        assert_eq!(code((0.45, 0.35), (0.15, 0.35)), "GOAL_OCCUPIED");
        assert_eq!(code((1.45, 0.35), (1.85, 0.35)), "GOAL_OCCUPIED");
        assert_eq!(code((0.05, 0.35), (0.45, 0.35)), "START_OCCUPIED");
        assert_eq!(code((0.45, 0.35), (9.0, 0.35)), "OUTSIDE");
        assert_eq!(code((-0.01, 0.35), (0.45, 0.35)), "OUTSIDE");
        assert_eq!(code((f64::NAN, 0.35), (0.45, 0.35)), "OUTSIDE");
    });
}

#[test]
fn it_leaves_where_it_stands_too_near_a_wall() {
    each(|_, settings, planner| {
        let grid = picture(ROOMS);
        let (start, goal) = (centre(&grid, (1, 6), 0.0), centre(&grid, (24, 5), 0.0));
        let plan = planner.plan(&grid, &start, &goal).unwrap();
        check_plan(&grid, settings, &start, &goal, &plan);
        // straight away from the wall, not along it
        assert!(place(&plan.poses[2]).x > place(&start).x + 0.1);
    });
}

#[test]
fn it_crosses_the_unknown_only_if_it_may() {
    let grid = picture(&[
        "####################",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "#........??........#",
        "####################",
    ]);
    let (start, goal) = (centre(&grid, (4, 3), 0.0), centre(&grid, (15, 3), 0.0));
    for (_, make) in PLANNERS {
        let settings = PlannerSettings {
            inflation_m: 0.2,
            ..PlannerSettings::default()
        };
        let refused = make(&settings).plan(&grid, &start, &goal);
        assert!(matches!(refused, Err(NoPath::Unreachable { .. })));
        let allowed = PlannerSettings {
            allow_unknown: true,
            ..settings
        };
        assert!(make(&allowed).plan(&grid, &start, &goal).is_ok());
    }
}

#[test]
fn it_keeps_to_the_middle_where_that_costs_little() {
    for (_, make) in PLANNERS {
        let layout = GridLayout::new(0.05, 400, 40, Pose::identity()).unwrap();
        let mut grid = Grid::new(layout, FREE);
        let wall = |y: f64| [Point::new(0.0, y), Point::new(20.0, y)];
        grid.stroke(&wall(0.0), 0.0, OCCUPIED);
        grid.stroke(&wall(1.99), 0.0, OCCUPIED);
        let [start, goal] = [1.0, 19.0].map(|x| heading(Point::new(x, 0.4), 0.0));
        let plan = make(&PlannerSettings::default())
            .plan(&grid, &start, &goal)
            .unwrap();
        let middle = plan
            .poses
            .iter()
            .filter(|pose| (pose.translation.y - 1.0).abs() < 0.35);
        assert!(middle.count() * 10 > plan.poses.len() * 8, "hugs the wall");
    }
}

#[test]
fn it_answers_an_empty_map() {
    each(|_, _, planner| {
        let empty = Grid::new(GridLayout::new(1.0, 0, 0, Pose::identity()).unwrap(), FREE);
        let refused = planner.plan(&empty, &Pose::identity(), &Pose::identity());
        assert_eq!(refused.unwrap_err().code(), "OUTSIDE");
    });
}

fn random_grid() -> impl Strategy<Value = Grid> {
    let size = (4u32..40, 4u32..40, 3u8..30);
    size.prop_flat_map(|(width, height, rarity)| {
        let cells = (width * height) as usize;
        let dice = prop::collection::vec(0..rarity, cells);
        dice.prop_map(move |dice| {
            let layout = GridLayout::new(RESOLUTION, width, height, Pose::identity()).unwrap();
            let cells = dice
                .iter()
                .map(|dice| if *dice == 0 { OCCUPIED } else { FREE });
            Grid::with_cells(layout, cells.collect()).unwrap()
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// A path is found if and only if a breadth-first search finds one; it is clear, and not much longer than the
    /// shortest one on the grid.
    #[test]
    fn it_finds_what_there_is(grid in random_grid(), ends in prop::array::uniform4(0.0..1.0f64), inflation in 0..3u8) {
        let (_, far) = grid.layout().bounds();
        let start = heading(Point::new(ends[0] * far.x, ends[1] * far.y), 0.0);
        let goal = heading(Point::new(ends[2] * far.x, ends[3] * far.y), 1.0);
        for (_, make) in PLANNERS {
            let wishes = PlannerSettings { inflation_m: f64::from(inflation) * RESOLUTION, comfort_m: 0.3, ..PlannerSettings::default() };
            for settings in [wishes.clone(), wishes.shortest()] {
                let mut planner = make(&settings);
                let answer = planner.plan(&grid, &start, &goal);
                let reference = Reference::new(&grid, &settings);
                let optimal = reference.shortest(place(&start), place(&goal));
                prop_assert_eq!(answer.is_ok(), optimal.is_some(), "{:?}", answer);
                if let (Ok(plan), Some(optimal)) = (&answer, optimal) {
                    check_plan(&grid, &settings, &start, &goal, plan);
                    // the ends may be half a cell off the centres between which the optimum is measured
                    let bound = 1.05 * (1.0 + settings.clearance_weight) * optimal + 1.5 * RESOLUTION;
                    // a robot that is too near to an obstacle leaves first, however long that takes
                    let leaves = grid.layout().cell(place(&start)).is_some_and(|cell| reference.tight(cell));
                    prop_assert!(leaves || plan.length <= bound, "{} > {}", plan.length, bound);
                }
                prop_assert_eq!(&answer, &planner.plan(&grid, &start, &goal));
                prop_assert_eq!(&answer, &make(&settings).plan(&grid, &start, &goal));
            }
        }
    }

    /// A planner that has worked on another map gives the same result as a new one.
    #[test]
    fn it_forgets(one in random_grid(), other in random_grid()) {
        let ends = [heading(Point::new(0.15, 0.15), 0.0), heading(Point::new(0.35, 0.35), 0.0)];
        for (_, make) in PLANNERS {
            let settings = PlannerSettings { inflation_m: 0.1, ..PlannerSettings::default() };
            let mut used = make(&settings);
            let _ = used.plan(&one, &ends[0], &ends[1]);
            prop_assert_eq!(used.plan(&other, &ends[0], &ends[1]), make(&settings).plan(&other, &ends[0], &ends[1]));
        }
    }

    #[test]
    fn it_takes_any_pose(numbers in prop::array::uniform6(prop::num::f64::ANY)) {
        let grid = picture(ROOMS);
        let pose = |at: usize| Pose::new(Vector::new(numbers[at], numbers[at + 1]), numbers[at + 2]);
        for (_, make) in PLANNERS {
            let _ = make(&PlannerSettings::default()).plan(&grid, &pose(0), &pose(3));
        }
    }
}
