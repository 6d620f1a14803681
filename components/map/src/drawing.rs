//! Common base of the vector formats: shapes in metres, drawn on a grid layer by layer.

use asmotion_geometry::{Grid, GridLayout, Occupancy, Point, Pose, Vector, heading};

use crate::error::MapFault;
use crate::format::MapSettings;
use crate::rules::FeatureRule;

/// Shapes in the map frame, with their layers.
#[derive(Default)]
pub struct Drawing {
    shapes: Vec<DrawnShape>,
}

/// Extent and resolution of a drawing in the map frame.
pub struct DrawingFrame {
    /// The smallest x and y, m.
    pub low: Point,
    /// The largest x and y, m.
    pub high: Point,
    /// Side length of a cell, m.
    pub resolution: f64,
    /// Occupancy of places that no shape covers.
    pub ground: Occupancy,
}

struct DrawnShape {
    layer: u8,
    value: i8,
    outline: Outline,
}

enum Outline {
    /// Points, and the width of the line through them.
    Line(Vec<Point>, f64),
    /// The rings of a polygon; holes are rings too.
    Area(Vec<Vec<Point>>),
    /// Centre and diameter.
    Spot(Point, f64),
}

impl Drawing {
    /// Adds a line of this width in m.
    pub fn line(&mut self, points: Vec<Point>, width: f64, rule: &FeatureRule) {
        self.add(rule, Outline::Line(points, width));
    }

    /// Adds an area; rings within others are holes.
    pub fn area(&mut self, rings: Vec<Vec<Point>>, rule: &FeatureRule) {
        self.add(rule, Outline::Area(rings));
    }

    /// Adds a disc of this diameter in m; without a diameter, nothing is drawn.
    pub fn spot(&mut self, at: Point, diameter: Option<f64>, rule: &FeatureRule) {
        if let Some(diameter) = diameter {
            self.add(rule, Outline::Spot(at, diameter));
        }
    }

    fn add(&mut self, rule: &FeatureRule, outline: Outline) {
        if let Some(occupancy) = rule.occupancy {
            self.shapes.push(DrawnShape {
                layer: rule.layer,
                value: occupancy.value(),
                outline,
            });
        }
    }

    /// The smallest and largest x and y of all shapes; `None` without shapes.
    pub fn bounds(&self) -> Option<(Point, Point)> {
        let mut points = self.shapes.iter().flat_map(|shape| shape.outline.points());
        let first = *points.next()?;
        Some(points.fold((first, first), |(low, high), point| {
            (low.inf(point), high.sup(point))
        }))
    }

    /// Draws the shapes on a grid. Within a layer, later shapes cover earlier ones.
    pub fn grid(mut self, frame: &DrawingFrame, settings: &MapSettings) -> Result<Grid, MapFault> {
        let mut grid = Grid::new(frame.layout(settings.max_cells)?, frame.ground.value());
        self.shapes.sort_by_key(|shape| shape.layer);
        for shape in &self.shapes {
            shape.draw(&mut grid);
        }
        Ok(grid)
    }
}

impl Outline {
    fn points(&self) -> impl Iterator<Item = &Point> {
        let (points, rings, spot) = match self {
            Self::Line(points, _) => (&points[..], &[][..], None),
            Self::Area(rings) => (&[][..], &rings[..], None),
            Self::Spot(at, _) => (&[][..], &[][..], Some(at)),
        };
        points.iter().chain(rings.iter().flatten()).chain(spot)
    }
}

impl DrawnShape {
    fn draw(&self, grid: &mut Grid) {
        match &self.outline {
            Outline::Line(points, width) => grid.stroke(points, *width, self.value),
            Outline::Spot(at, diameter) => grid.disc(*at, diameter / 2.0, self.value),
            Outline::Area(rings) => {
                grid.fill(rings, self.value);
                if Occupancy::of(self.value) == Occupancy::Occupied {
                    self.draw_border(grid, rings);
                }
            }
        }
    }

    /// Draws the border of an occupied area on all cells that it touches, so that thin shapes are not lost between cell
    /// centres.
    fn draw_border(&self, grid: &mut Grid, rings: &[Vec<Point>]) {
        for ring in rings {
            grid.stroke(ring, 0.0, self.value);
            if let [first, .., last] = ring[..] {
                grid.stroke(&[last, first], 0.0, self.value);
            }
        }
    }
}

impl DrawingFrame {
    /// The frame extended by `margin` metres on each side.
    pub fn widened(self, margin: f64) -> Self {
        let margin = Vector::repeat(margin);
        Self {
            low: self.low - margin,
            high: self.high + margin,
            ..self
        }
    }

    /// The grid that covers the frame. The map's origin is a corner of one of its cells.
    fn layout(&self, max_cells: u64) -> Result<GridLayout, MapFault> {
        let resolution = self.resolution;
        if !(resolution.is_finite() && resolution > 0.0) {
            return Err(MapFault::Layout(
                asmotion_geometry::GridLayoutError::Resolution { resolution },
            ));
        }
        // rounding errors must not add a row of cells
        let steps = |value: f64, round: fn(f64) -> f64, hair: f64| round(value / resolution + hair);
        let first = Vector::new(
            steps(self.low.x, f64::floor, 1e-6),
            steps(self.low.y, f64::floor, 1e-6),
        );
        let width = (steps(self.high.x, f64::ceil, -1e-6) - first.x).max(1.0);
        let height = (steps(self.high.y, f64::ceil, -1e-6) - first.y).max(1.0);
        let most = max_cells.min(GridLayout::MAX_CELLS);
        let cells = width * height;
        if cells.is_nan() || cells > most as f64 {
            return Err(MapFault::TooLarge {
                width,
                height,
                resolution,
                limit: most,
                fits: fitting(width * resolution, height * resolution, most),
            });
        }
        let origin: Pose = heading(Point::from(first * resolution), 0.0);
        Ok(GridLayout::new(
            resolution,
            width as u32,
            height as u32,
            origin,
        )?)
    }
}

/// A resolution at which `width` × `height` metres need at most `limit` cells, rounded up to two digits.
pub fn fitting(width: f64, height: f64, limit: u64) -> f64 {
    let limit = limit.max(4) as f64;
    // each side may need one cell more than its length implies
    let exact = (width * height / limit)
        .sqrt()
        .max(width.max(height) / limit)
        * 1.02
        + (width + height) / limit;
    let digit = 10_f64.powf(exact.log10().floor() - 1.0);
    let rounded = (exact / digit).ceil() * digit;
    // the shortest decimal, not 0.15000000000000002
    format!("{rounded:.6}").parse().unwrap_or(rounded)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: f64, height: f64, resolution: f64) -> DrawingFrame {
        DrawingFrame {
            low: Point::new(-0.5, 0.0),
            high: Point::new(width - 0.5, height),
            resolution,
            ground: Occupancy::Free,
        }
    }

    #[test]
    fn it_covers_its_frame_and_no_more() {
        let layout = frame(31.0, 21.0, 0.05).layout(1 << 20).unwrap();
        assert_eq!((layout.width(), layout.height()), (620, 420));
        assert!((layout.origin().translation.x + 0.5).abs() < 1e-12);
    }

    #[test]
    fn it_proposes_a_resolution_that_fits() {
        for (width, height) in [(31.0, 21.0), (1e6, 3.0), (0.01, 1e5), (1e7, 1e7)] {
            match frame(width, height, 1e-3).layout(10_000) {
                Err(MapFault::TooLarge { fits, .. }) => {
                    assert!(frame(width, height, fits).layout(10_000).is_ok(), "{fits}");
                    assert!(
                        frame(width, height, fits / 4.0).layout(10_000).is_err(),
                        "{fits}"
                    );
                }
                other => panic!("{other:?}"),
            }
        }
    }
}
