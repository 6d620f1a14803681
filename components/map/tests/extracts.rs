//! Real extracts of OpenStreetMap: each is read, and a path across it is planned.
//!
//! The data are not part of the project (© OpenStreetMap contributors, ODbL 1.0); without them the tests print a notice

//! and pass.

use std::time::Instant;

use asmotion_geometry::{Occupancy, Point, heading};
use asmotion_map::{DiskFiles, Map, MapSettings, load};
use asmotion_planner::{AStar, Planner, PlannerSettings as Needs};

struct Expected {
    file: &'static str,
    /// Position of the map's origin, degrees east and north.
    origin: (f64, f64),
    /// Number of cells along x and y.
    size: (u32, u32),
    /// Minimum and maximum percentage of occupied cells.
    occupied: (usize, usize),
    /// Two places in the open, map frame, m.
    ends: [(f64, f64); 2],
}

fn check(expected: &Expected) {
    let Some(file) = asmotion_skip::shared(&format!("data/osm/{}", expected.file)) else {
        return;
    };
    let file = file.display().to_string();
    let begin = Instant::now();
    let map = load(&DiskFiles, &file, &MapSettings::default()).unwrap();
    let loaded = begin.elapsed();
    let layout = *map.grid.layout();
    let size = (layout.width(), layout.height());
    let share = share(&map);
    eprintln!(
        "{}: {size:?} cells, {share} % occupied, read in {loaded:?}, {:?} {:?}",
        expected.file, map.origin, map.notes
    );
    let origin = map.origin.unwrap();
    assert!((origin.longitude - expected.origin.0).abs() < 1e-3);
    assert!((origin.latitude - expected.origin.1).abs() < 1e-3);
    assert_eq!(size, expected.size);
    assert!(
        (expected.occupied.0..=expected.occupied.1).contains(&share),
        "{share} %"
    );
    check_way(&map, expected);
}

fn share(map: &Map) -> usize {
    let cells = map.grid.cells();
    let occupied = cells
        .iter()
        .filter(|value| Occupancy::of(**value) == Occupancy::Occupied);
    occupied.count() * 100 / cells.len()
}

fn check_way(map: &Map, expected: &Expected) {
    let [start, goal] = expected.ends.map(|(x, y)| heading(Point::new(x, y), 0.0));
    let needs = Needs {
        inflation_m: 0.5,
        comfort_m: 1.0,
        step_m: 0.5,
        ..Needs::default()
    };
    let begin = Instant::now();
    let plan = AStar::new(&needs).plan(&map.grid, &start, &goal).unwrap();
    eprintln!(
        "  {:.1} m with {} cells explored in {:?}",
        plan.length,
        plan.explored,
        begin.elapsed()
    );
    for pose in &plan.poses {
        let at = Point::from(pose.translation.vector);
        assert_eq!(
            map.grid.occupancy(at),
            Occupancy::Free,
            "through something at {at}"
        );
    }
}

#[cfg(feature = "maps")]
#[test]
fn it_crosses_bautzen() {
    check(&Expected {
        file: "gh_bautzen.osm",
        origin: (14.41195, 51.18955),
        size: (1134, 1046),
        occupied: (1, 3),
        ends: [(-230.0, -40.0), (270.0, 60.0)],
    });
}

#[cfg(feature = "maps")]
#[test]
fn it_crosses_berlin() {
    check(&Expected {
        file: "gh_berlin-siegessaeule.osm.gz",
        origin: (13.35021, 52.514385),
        size: (694, 604),
        occupied: (2, 6),
        ends: [(-143.5, -89.0), (-8.5, 51.0)],
    });
}

#[test]
fn it_crosses_rome() {
    check(&Expected {
        file: "vh_rome.osm.pbf",
        origin: (12.4838, 41.89652),
        size: (586, 366),
        occupied: (30, 42),
        ends: [(-121.5, -68.5), (53.5, 66.5)],
    });
}

#[test]
fn it_crosses_singapore() {
    check(&Expected {
        file: "vh_bayfront_singapore.osm.pbf",
        origin: (103.859, 1.28455),
        size: (980, 2810),
        occupied: (17, 27),
        ends: [(-21.0, 299.5), (23.5, -552.0)],
    });
}
