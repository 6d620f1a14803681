//! Planning time on 400 × 400 cells: an open hall, a hall with many pillars, a serpentine, and a map without a path.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a bench fails by panicking"
)]

use std::hint::black_box;

use asmotion_geometry::{Cell, FREE, Grid, GridLayout, OCCUPIED, Point, Pose, heading};
use asmotion_planner::{PLANNERS, PlannerSettings};
use criterion::{Criterion, criterion_group, criterion_main};

const SIZE: u32 = 400;
const RESOLUTION: f64 = 0.05;

fn hall() -> Grid {
    let layout = GridLayout::new(RESOLUTION, SIZE, SIZE, Pose::identity());
    Grid::new(layout.expect("a lawful layout"), FREE)
}

fn pillars() -> Grid {
    let mut grid = hall();
    let mut dice = 1_u32;
    for _ in 0..120 {
        let mut roll = || {
            dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(dice >> 8) / f64::from(1_u32 << 24)
        };
        let centre = Point::new(1.0 + 18.0 * roll(), 1.0 + 18.0 * roll());
        grid.disc(centre, 0.1 + 0.3 * roll(), OCCUPIED);
    }
    grid.disc(Point::new(0.5, 0.5), 0.8, FREE);
    grid.disc(Point::new(19.5, 19.5), 0.8, FREE);
    grid
}

fn serpentine() -> Grid {
    let mut grid = hall();
    for wall in 1..10 {
        let (row, gap) = (
            wall * SIZE / 10,
            if wall % 2 == 0 {
                0..30
            } else {
                SIZE - 30..SIZE
            },
        );
        for column in (0..SIZE).filter(|column| !gap.contains(column)) {
            grid.set(Cell::new(column, row), OCCUPIED);
        }
    }
    grid
}

fn no_way() -> Grid {
    let mut grid = hall();
    grid.stroke(
        &[Point::new(0.0, 18.0), Point::new(20.0, 18.0)],
        0.0,
        OCCUPIED,
    );
    grid
}

fn plan(criterion: &mut Criterion) {
    let [start, goal] = [0.5, 19.5].map(|at| heading(Point::new(at, at), 0.0));
    for (name, make) in PLANNERS {
        let maps = [
            ("hall", hall()),
            ("pillars", pillars()),
            ("serpentine", serpentine()),
            ("no way", no_way()),
        ];
        for (map, grid) in maps {
            let mut planner = make(&PlannerSettings::default());
            // alternates with another map, so that the costs are recomputed each time
            let mut other = grid.clone();
            other.set(Cell::new(0, 0), OCCUPIED);
            let mut turn = false;
            criterion.bench_function(&format!("{name}/{map}/new map"), |bencher| {
                bencher.iter(|| {
                    turn = !turn;
                    let grid = if turn { &grid } else { &other };
                    let _ = black_box(planner.plan(grid, &start, &goal));
                });
            });
            criterion.bench_function(&format!("{name}/{map}/same map"), |bencher| {
                bencher.iter(|| black_box(planner.plan(&grid, &start, &goal).is_ok()));
            });
        }
    }
}

criterion_group!(benches, plan);
criterion_main!(benches);
