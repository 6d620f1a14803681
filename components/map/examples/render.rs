//! Draws a map, its named points, and optionally a path as a PNG.
//!
//! `cargo run -p asmotion-map --example render -- map.geojson out.png [x,y x,y | name name]…`

#![allow(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;
use std::fs::File;
use std::io::BufWriter;

use asmotion_geometry::{Grid, Occupancy, Point, Pose, heading};
use asmotion_map::{DiskFiles, Map, MapSettings, load};
use asmotion_planner::{AStar, Planner, PlannerSettings as Needs};
use png::{ColorType, Encoder};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, out, ends @ ..] = &arguments[..] else {
        return Err("expected a map, a PNG file, and pairs of ends".into());
    };
    let map = load(&DiskFiles, file, &MapSettings::default())?;
    let mut picture = draw(&map.grid);
    for point in &map.points {
        dot(
            &mut picture,
            &map.grid,
            place(&point.pose),
            3,
            [200, 0, 120],
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
            dot(&mut picture, &map.grid, place(pose), 1, [220, 60, 0]);
        }
    }
    println!("{:?} {:?} {:?}", map.grid.layout(), map.origin, map.notes);
    picture.save(out)
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

/// Red, green, blue.
type Rgb = [u8; 3];

/// Pixels in rows from the top.
struct Picture {
    width: u32,
    height: u32,
    samples: Vec<u8>,
}

impl Picture {
    fn set(&mut self, x: u32, y: u32, colour: Rgb) {
        let at = (y as usize * self.width as usize + x as usize) * 3;
        if let Some(pixel) = self.samples.get_mut(at..at + 3) {
            pixel.copy_from_slice(&colour);
        }
    }

    fn save(&self, path: &str) -> Result<(), Box<dyn Error>> {
        let mut encoder =
            Encoder::new(BufWriter::new(File::create(path)?), self.width, self.height);
        encoder.set_color(ColorType::Rgb);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.samples)?;
        Ok(writer.finish()?)
    }
}

fn draw(grid: &Grid) -> Picture {
    let layout = grid.layout();
    let (width, height) = (layout.width(), layout.height());
    let mut picture = Picture {
        width,
        height,
        samples: vec![0; layout.len() * 3],
    };
    for (index, value) in grid.cells().iter().enumerate() {
        let cell = layout.cell_at(index);
        let colour = match Occupancy::of(*value) {
            Occupancy::Occupied => [30, 30, 40],
            Occupancy::Free => [250, 250, 245],
            Occupancy::Unknown => [170, 175, 180],
        };
        picture.set(cell.column, height - 1 - cell.row, colour);
    }
    picture
}

fn dot(picture: &mut Picture, grid: &Grid, at: Point, radius: i64, colour: Rgb) {
    let Some(cell) = grid.layout().cell(at) else {
        return;
    };
    let (x, y) = (
        i64::from(cell.column),
        i64::from(picture.height - 1 - cell.row),
    );
    for (dx, dy) in (-radius..=radius).flat_map(|dx| (-radius..=radius).map(move |dy| (dx, dy))) {
        let (x, y) = (u32::try_from(x + dx), u32::try_from(y + dy));
        if let (Ok(x), Ok(y)) = (x, y)
            && x < picture.width
            && y < picture.height
        {
            picture.set(x, y, colour);
        }
    }
}
