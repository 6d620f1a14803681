//! Draws a map, its named points, and if wanted a path, as a PNG to look at.
//!
//! `cargo run -p asmotion-map --example render -- map.geojson out.png [x,y x,y | name name]…`

#![allow(clippy::print_stdout, reason = "an example tells what it drew")]

use std::error::Error;

use asmotion_geometry::{Grid, Occupancy, Point, Pose, heading};
use asmotion_map::{Disk, Map, Settings, load};
use asmotion_planner::{AStar, Planner, Settings as Needs};
use image::{Rgb, RgbImage};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, ends @ ..] = &arguments[..] else {
        return Err("wants a map, a PNG file, and pairs of ends".into());
    };
    let map = load(&Disk, file, &Settings::default())?;
    let mut picture = draw(&map.grid);
    for point in &map.points {
        dot(
            &mut picture,
            &map.grid,
            place(&point.pose),
            3,
            Rgb([200, 0, 120]),
        );
        println!("{} at {}", point.name, place(&point.pose));
    }
    for pair in ends.chunks_exact(2) {
        let (start, goal) = (end(&map, &pair[0])?, end(&map, &pair[1])?);
        let plan = AStar::new(&Needs::default()).plan(&map.grid, &start, &goal)?;
        println!(
            "{:.2} m, {} poses, {} cells explored",
            plan.length,
            plan.poses.len(),
            plan.explored
        );
        for pose in &plan.poses {
            dot(&mut picture, &map.grid, place(pose), 1, Rgb([220, 60, 0]));
        }
    }
    println!("{:?} {:?} {:?}", map.grid.layout(), map.origin, map.notes);
    Ok(picture.save(out)?)
}

fn place(pose: &Pose) -> Point {
    Point::from(pose.translation.vector)
}

fn end(map: &Map, text: &str) -> Result<Pose, Box<dyn Error>> {
    if let Some(point) = map.point(text) {
        return Ok(point.pose);
    }
    let (x, y) = text.split_once(',').ok_or(format!("no place `{text}`"))?;
    Ok(heading(Point::new(x.parse()?, y.parse()?), 0.0))
}

fn draw(grid: &Grid) -> RgbImage {
    let layout = grid.layout();
    let mut picture = RgbImage::new(layout.width(), layout.height());
    for (index, value) in grid.cells().iter().enumerate() {
        let cell = layout.cell_at(index);
        let colour = match Occupancy::of(*value) {
            Occupancy::Occupied => Rgb([30, 30, 40]),
            Occupancy::Free => Rgb([250, 250, 245]),
            Occupancy::Unknown => Rgb([170, 175, 180]),
        };
        picture.put_pixel(cell.column, layout.height() - 1 - cell.row, colour);
    }
    picture
}

fn dot(picture: &mut RgbImage, grid: &Grid, at: Point, radius: i64, colour: Rgb<u8>) {
    let Some(cell) = grid.layout().cell(at) else {
        return;
    };
    let (x, y) = (
        i64::from(cell.column),
        i64::from(picture.height() - 1 - cell.row),
    );
    for (dx, dy) in (-radius..=radius).flat_map(|dx| (-radius..=radius).map(move |dy| (dx, dy))) {
        let (x, y) = (u32::try_from(x + dx), u32::try_from(y + dy));
        if let (Ok(x), Ok(y)) = (x, y)
            && x < picture.width()
            && y < picture.height()
        {
            picture.put_pixel(x, y, colour);
        }
    }
}
