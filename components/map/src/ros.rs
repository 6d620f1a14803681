//! ROS maps: a YAML file that refers to an image (map_server's format,
//! <https://docs.nav2.org/configuration/packages/map_server/configuring-map-server.html>).
//!
//! The image's lower left corner is the origin; darker pixels are more occupied unless `negate` is set.

mod description;
mod netpbm;
mod picture;

use asmotion_geometry::{Grid, GridLayout, GridLayoutError, Occupancy, Point, heading};
use description::{MapDescription, ThresholdMode};
use picture::{MapPicture, Pixel};

use crate::drawing::fitting;
use crate::error::{MapError, MapFault};
use crate::format::{MapFormat, MapSettings, MapSource};
use crate::map::Map;

/// The reader of ROS maps.
pub struct RosMap;

impl MapFormat for RosMap {
    fn endings(&self) -> &'static [&'static str] {
        &[".yaml", ".yml"]
    }

    fn load(&self, source: &MapSource<'_>, settings: &MapSettings) -> Result<Map, MapError> {
        let about = description::read(source)?;
        let beside = source.beside(&about.image);
        let image = picture::read(&beside, settings)?;
        let grid = grid(&about, &image).map_err(|error| source.error(error.into()))?;
        let fine = (grid.layout().width(), grid.layout().height());
        fit(grid, settings)
            .map(|grid| note(grid, fine))
            .map_err(|fault| beside.error(fault))
    }
}

fn grid(about: &MapDescription, image: &MapPicture) -> Result<Grid, GridLayoutError> {
    let [x, y, yaw] = about.origin;
    let origin = heading(Point::new(x, y), yaw);
    let layout = GridLayout::new(about.resolution, image.width, image.height, origin)?;
    let cells = image.upwards().map(|pixel| about.cell(&pixel)).collect();
    Grid::with_cells(layout, cells)
}

impl Pixel {
    /// Brightness from 0 to 1, the mean of the channels.
    fn shade(&self, with_alpha: bool) -> f64 {
        let colour: u32 = self.colour.iter().copied().map(u32::from).sum();
        match self.alpha {
            Some(alpha) if with_alpha => f64::from(colour + u32::from(alpha)) / (4.0 * 255.0),
            _ => f64::from(colour) / (3.0 * 255.0),
        }
    }
}

impl MapDescription {
    /// The cell value of a pixel, computed as in nav2's map_server (map_io.cpp, `loadMapFromFile`).
    fn cell(&self, pixel: &Pixel) -> i8 {
        let trinary = matches!(self.mode, ThresholdMode::Trinary);
        let shade = pixel.shade(trinary);
        let occupied = if self.negate { shade } else { 1.0 - shade };
        let certain = if self.occupied_thresh < occupied {
            Some(Occupancy::Occupied)
        } else if occupied < self.free_thresh {
            Some(Occupancy::Free)
        } else {
            None
        };
        match self.mode {
            ThresholdMode::Trinary => certain.unwrap_or(Occupancy::Unknown).value(),
            ThresholdMode::Scale if pixel.alpha.is_some_and(|alpha| alpha < 255) => {
                asmotion_geometry::UNKNOWN
            }
            ThresholdMode::Scale => {
                certain.map_or_else(|| self.between(occupied), Occupancy::value)
            }
            ThresholdMode::Raw => match (shade * 255.0).round() as i64 {
                raw @ 0..=100 => raw as i8,
                _ => asmotion_geometry::UNKNOWN,
            },
        }
    }

    /// Position between the free and the occupied threshold, in percent.
    fn between(&self, occupied: f64) -> i8 {
        let way = (self.occupied_thresh - self.free_thresh).max(f64::MIN_POSITIVE);
        let percent = (occupied - self.free_thresh) / way * 100.0;
        percent.round_ties_even().clamp(0.0, 100.0) as i8
    }
}

/// Reduces the grid's resolution to that of the settings, and checks its size.
fn fit(grid: Grid, settings: &MapSettings) -> Result<Grid, MapFault> {
    let fine = *grid.layout();
    let requested = settings.resolution.unwrap_or(0.0);
    let factor = (requested / fine.resolution() - 1e-6)
        .ceil()
        .clamp(1.0, 1e6) as u32;
    let grid = if factor > 1 {
        grid.coarsened(factor)?
    } else {
        grid
    };
    let layout = grid.layout();
    if layout.len() as u64 > settings.max_cells {
        let (width, height) = (f64::from(fine.width()), f64::from(fine.height()));
        let metres = fine.resolution();
        return Err(MapFault::TooLarge {
            width: f64::from(layout.width()),
            height: f64::from(layout.height()),
            resolution: layout.resolution(),
            limit: settings.max_cells,
            fits: fitting(width * metres, height * metres, settings.max_cells),
        });
    }
    Ok(grid)
}

fn note(grid: Grid, fine: (u32, u32)) -> Map {
    let (width, height) = (grid.layout().width(), grid.layout().height());
    let mut map = Map::of(grid);
    if (width, height) != fine {
        let (from_width, from_height) = fine;
        map.notes.push(format!(
            "made coarser: {from_width} × {from_height} cells became {width} × {height}"
        ));
    }
    map
}

/// Saves a grid like map_saver. Returns the text of the YAML file, which refers to `image`, and the image as PNG. Cells
/// become occupied, free or unknown.
///
/// # Errors
/// The image cannot be written as PNG.
pub fn save(grid: &Grid, image: &str) -> Result<(String, Vec<u8>), MapFault> {
    let layout = grid.layout();
    let origin = layout.origin();
    let yaml = format!(
        "image: {image}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        layout.resolution(),
        origin.translation.x,
        origin.translation.y,
        asmotion_geometry::yaw(origin),
    );
    let width = layout.width().max(1) as usize;
    let rows = grid.cells().chunks(width).rev().flatten();
    // map_server's grey values, which the thresholds above map back to the same occupancy
    let shades = rows.map(|value| match Occupancy::of(*value) {
        Occupancy::Occupied => 0,
        Occupancy::Unknown => 205,
        Occupancy::Free => 254,
    });
    let shades: Vec<u8> = shades.collect();
    let png = picture::write_png(layout.width(), layout.height(), &shades)?;
    Ok((yaml, png))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::FilesInMemory;
    use crate::formats::load;

    /// Reads a map with one row of pixels of the given brightness.
    fn cells(shades: &[u8], more: &str) -> Vec<i8> {
        let mut pgm = format!("P5 {} 1 255\n", shades.len()).into_bytes();
        pgm.extend_from_slice(shades);
        let yaml = format!("image: row.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n{more}");
        let files = FilesInMemory::new([("m/row.yaml", yaml.into_bytes()), ("m/row.pgm", pgm)]);
        load(&files, "m/row.yaml", &MapSettings::default())
            .unwrap()
            .grid
            .cells()
            .to_vec()
    }

    #[test]
    fn it_reads_three_values() {
        let shades = [0, 80, 100, 205, 210, 254];
        let thresholds = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        assert_eq!(cells(&shades, thresholds), [100, 100, -1, -1, 0, 0]);
    }

    #[test]
    fn it_reads_the_negative() {
        let thresholds = "negate: true\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        assert_eq!(cells(&[0, 100, 255], thresholds), [0, -1, 100]);
    }

    #[test]
    fn it_reads_probabilities() {
        let scale = "negate: 0\nmode: scale\noccupied_thresh: 0.9\nfree_thresh: 0.1\n";
        assert_eq!(cells(&[0, 128, 255], scale), [100, 50, 0]);
    }

    #[test]
    fn it_reads_raw_values() {
        let raw = "negate: 0\nmode: raw\noccupied_thresh: 0.9\nfree_thresh: 0.1\n";
        assert_eq!(cells(&[0, 42, 100, 101, 255], raw), [0, 42, 100, -1, -1]);
    }

    #[test]
    fn it_takes_transparency_for_the_unknown_when_it_scales() {
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, 2, 1);
        encoder.set_color(png::ColorType::Rgba);
        let mut writer = encoder.write_header().unwrap();
        writer
            .write_image_data(&[0, 0, 0, 255, 0, 0, 0, 10])
            .unwrap();
        writer.finish().unwrap();
        let yaml = "image: a.png\nresolution: 1\norigin: [0, 0, 0]\nmode: scale\nnegate: 0\noccupied_thresh: 0.9\nfree_thresh: 0.1\n";
        let files = FilesInMemory::new([("a.yaml", yaml.as_bytes().to_vec()), ("a.png", png)]);
        let map = load(&files, "a.yaml", &MapSettings::default()).unwrap();
        assert_eq!(map.grid.cells(), [100, -1]);
    }

    #[test]
    fn it_lies_as_its_origin_says() {
        let yaml = "image: a.pgm\nresolution: 0.5\norigin: [-1, 2, 1.5707963]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        let pgm = b"P2 2 2 255\n0 254\n254 254\n".to_vec();
        let files = FilesInMemory::new([("a.yaml", yaml.as_bytes().to_vec()), ("a.pgm", pgm)]);
        let map = load(&files, "a.yaml", &MapSettings::default()).unwrap();
        // the upper left pixel is cell (0, 1), turned about the origin by 90°
        assert_eq!(
            map.grid.occupancy(Point::new(-1.75, 2.25)),
            Occupancy::Occupied
        );
        assert_eq!(map.grid.occupancy(Point::new(-1.25, 2.25)), Occupancy::Free);
    }

    #[test]
    fn it_reads_what_it_wrote() {
        let layout = GridLayout::new(0.05, 3, 2, heading(Point::new(-1.5, 0.25), 0.5)).unwrap();
        let grid = Grid::with_cells(layout, vec![0, 100, -1, -1, 0, 100]).unwrap();
        let (yaml, png) = save(&grid, "a.png").unwrap();
        let files = FilesInMemory::new([("a.yaml", yaml.into_bytes()), ("a.png", png)]);
        assert_eq!(
            load(&files, "a.yaml", &MapSettings::default())
                .unwrap()
                .grid,
            grid
        );
    }

    #[test]
    fn it_says_what_is_wrong_and_where() {
        let error = |yaml: &str| {
            let files = FilesInMemory::new([("m.yaml", yaml)]);
            load(&files, "m.yaml", &MapSettings::default())
                .unwrap_err()
                .to_string()
        };
        let head = "image: m.png\nresolution: 0.1\n";
        let tail = "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        assert!(error(&format!("{head}{tail}")).contains("origin"));
        assert!(error(&format!("{head}origin: [0, 0]\n{tail}")).contains("x, y (m) and yaw (rad)"));
        assert!(error("image: [}").starts_with("m.yaml:1:"));
        let missing = error(&format!("{head}origin: [0, 0, 0]\n{tail}"));
        assert_eq!(missing, "m.png: file not found");
        assert!(
            error(&format!(
                "{head}origin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.2\nfree_thresh: 0.5"
            ))
            .contains("`free_thresh` is 0.5")
        );
        let whole = format!("{head}origin: [0, 0, 0]\n{tail}");
        let with = |line: &str| error(&format!("{whole}{line}"));
        assert_eq!(
            with("mode: binary"),
            "m.yaml:7:1: `mode` is binary; it must be `trinary`, `scale` or `raw`"
        );
        assert!(with("resolution: 1").contains("m.yaml:7:1: "));
        assert!(with("resolution: 1").contains("the key `resolution` is repeated"));
        let instead = |from: &str, to: &str| error(&whole.replace(from, to));
        for value in [
            ".inf", "nan", "1e999", "[1]", "{a: 1}", "*anchor", "'0.1 m'", "",
        ] {
            let found = instead("resolution: 0.1", &format!("resolution: {value}"));
            assert!(found.starts_with("m.yaml:2:"), "{value}: {found}");
        }
        assert!(instead("[0, 0, 0]", "[0, [0], 0]").contains("`origin` is a nested list"));
        assert!(instead("negate: 0", "negate: maybe").contains("`negate` is maybe"));
        assert!(error("").contains("expected keys with values"));
        assert!(error("- image: m.png").contains("expected keys with values"));
    }

    #[test]
    fn it_reads_what_other_map_servers_read() {
        let files = |yaml: &str| {
            let error = load(
                &FilesInMemory::new([("m.yaml", yaml)]),
                "m.yaml",
                &MapSettings::default(),
            );
            error.unwrap_err().to_string()
        };
        let yaml = "%YAML 1.1\n---\n# saved by hand\nimage: \"m.png\"\nresolution: 5.0e-2\norigin:\n  - -1.\n  - .5\n  - 0\nnegate: No\noccupied_thresh: '0.65'\nfree_thresh: 0.196\nlayers: {walls: [a, {b: [c]}], ? [x] : y}\n? [complex, key]\n: [1, 2]\n...\n";
        assert_eq!(files(yaml), "m.png: file not found");
    }
}
