//! The demo's floor plan: every place can be reached from every other, even if a corridor is blocked.

use asmotion_geometry::{Grid, OCCUPIED, Point};
use asmotion_map::{DiskFiles, Map, MapSettings, load};
use asmotion_planner::{AStar, Planner, PlannerSettings as Needs};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../specs/navigation/maps");

fn office() -> Map {
    load(
        &DiskFiles,
        &format!("{FOLDER}/office.geojson"),
        &MapSettings::default(),
    )
    .unwrap()
}

/// The map with an obstacle as wide as a corridor at a place.
fn blocked(map: &Map, place: &str) -> Grid {
    let mut grid = map.grid.clone();
    let at = map.point(place).unwrap().pose.translation.vector;
    grid.disc(Point::from(at), 0.8, OCCUPIED);
    grid
}

fn length(map: &Map, grid: &Grid, from: &str, to: &str) -> Option<f64> {
    let (from, to) = (map.point(from).unwrap(), map.point(to).unwrap());
    let plan = AStar::new(&Needs::default()).plan(grid, &from.pose, &to.pose);
    plan.ok().map(|plan| plan.length)
}

/// All places in rooms.
fn rooms(map: &Map) -> Vec<String> {
    let names = map.points.iter().map(|point| point.name.clone());
    names.filter(|name| !name.starts_with("corridor")).collect()
}

#[test]
fn it_has_its_places() {
    let map = office();
    assert_eq!(
        map.points
            .iter()
            .map(|point| point.name.as_str())
            .collect::<Vec<_>>(),
        [
            "dock",
            "lab",
            "office_a",
            "office_b",
            "meeting",
            "kitchen",
            "server_room",
            "archive",
            "library",
            "workshop",
            "office_c",
            "office_d",
            "lobby",
            "corridor_north",
            "corridor_south"
        ]
    );
    assert_eq!(
        (map.grid.layout().width(), map.grid.layout().height()),
        (620, 420)
    );
    assert!(map.notes.is_empty());
}

#[test]
fn every_place_is_reached_from_every_other() {
    let map = office();
    for from in rooms(&map) {
        for to in rooms(&map) {
            assert!(
                length(&map, &map.grid, &from, &to).is_some(),
                "{from} to {to}"
            );
        }
    }
}

#[test]
fn a_blocked_corridor_can_be_passed_by() {
    let map = office();
    for corridor in ["corridor_north", "corridor_south"] {
        let grid = blocked(&map, corridor);
        for to in rooms(&map) {
            assert!(
                length(&map, &grid, "dock", &to).is_some(),
                "dock to {to} past {corridor}"
            );
        }
    }
    let straight = length(&map, &map.grid, "lab", "kitchen").unwrap();
    let detour = length(&map, &blocked(&map, "corridor_north"), "lab", "kitchen").unwrap();
    assert!(
        straight < 27.0 && (34.0..45.0).contains(&detour),
        "{straight} {detour}"
    );
}

#[test]
#[cfg(feature = "maps")]
fn its_ros_map_is_the_same_map() {
    let ros = load(
        &DiskFiles,
        &format!("{FOLDER}/office.yaml"),
        &MapSettings::default(),
    )
    .unwrap();
    assert!(
        ros.grid == office().grid,
        "run `cargo run -p asmotion-map --example export -- {FOLDER}/office.geojson {FOLDER}`"
    );
}
