//! Layout of a grid: converts between points in the map frame and cells.

use serde::{Deserialize, Serialize};

use crate::pose::{Point, Pose};

/// The position of a cell: column along the grid's x axis, row along its y axis, (0, 0) at the origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Index along the grid's x axis.
    pub column: u32,
    /// Index along the grid's y axis.
    pub row: u32,
}

impl Cell {
    /// Creates the cell in this column and row.
    pub fn new(column: u32, row: u32) -> Self {
        Self { column, row }
    }
}

/// Size, resolution and origin of a grid (as in `nav_msgs/MapMetaData`), without its cells.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "LayoutNumbers")]
pub struct GridLayout {
    resolution: f64,
    width: u32,
    height: u32,
    /// Lower left corner of cell (0, 0), map frame.
    origin: Pose,
    /// Inverse of `origin`, stored to make look-ups cheap.
    #[serde(skip_serializing)]
    inverse: Pose,
}

/// Serialised form of a layout.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayoutNumbers {
    resolution: f64,
    width: u32,
    height: u32,
    origin: Pose,
}

impl TryFrom<LayoutNumbers> for GridLayout {
    type Error = GridLayoutError;

    fn try_from(numbers: LayoutNumbers) -> Result<Self, GridLayoutError> {
        Self::new(
            numbers.resolution,
            numbers.width,
            numbers.height,
            numbers.origin,
        )
    }
}

/// Values that define no valid layout.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridLayoutError {
    /// The size of a cell is not positive and finite.
    #[error("a cell's side must be a positive number of metres, not {resolution}")]
    Resolution {
        /// The given cell size, m.
        resolution: f64,
    },
    /// The origin is not finite.
    #[error("the grid's origin has a coordinate that is not finite")]
    Origin,
    /// The number of cells exceeds the limit.
    #[error("a grid of {width} × {height} cells is too large (at most {limit} cells)", limit = GridLayout::MAX_CELLS)]
    TooLarge {
        /// Number of cells along x.
        width: u64,
        /// Number of cells along y.
        height: u64,
    },
    /// The number of values differs from the number of cells.
    #[error("a grid of {width} × {height} cells came with {found} values")]
    Cells {
        /// Number of cells along x.
        width: u32,
        /// Number of cells along y.
        height: u32,
        /// Number of values given.
        found: usize,
    },
}

impl GridLayout {
    /// Limit on the number of cells.
    pub const MAX_CELLS: u64 = 1 << 30;

    /// Creates a layout of `width` × `height` cells of `resolution` metres; `origin` is the lower left corner of cell
    /// (0, 0) in the map frame.
    ///
    /// # Errors
    /// [`GridLayoutError::Resolution`] if the resolution is not a positive number, [`GridLayoutError::Origin`] if the
    /// origin is not finite, [`GridLayoutError::TooLarge`] beyond [`Self::MAX_CELLS`].
    pub fn new(
        resolution: f64,
        width: u32,
        height: u32,
        origin: Pose,
    ) -> Result<Self, GridLayoutError> {
        if !(resolution.is_finite() && resolution > 0.0) {
            return Err(GridLayoutError::Resolution { resolution });
        }
        let numbers = [
            origin.translation.x,
            origin.translation.y,
            origin.rotation.angle(),
        ];
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(GridLayoutError::Origin);
        }
        let (width64, height64) = (u64::from(width), u64::from(height));
        if width64 * height64 > Self::MAX_CELLS {
            return Err(GridLayoutError::TooLarge {
                width: width64,
                height: height64,
            });
        }
        Ok(Self {
            resolution,
            width,
            height,
            origin,
            inverse: origin.inverse(),
        })
    }

    /// Side length of a cell, m.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Number of cells along the grid's x axis.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of cells along the grid's y axis.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Lower left corner of cell (0, 0), map frame.
    pub fn origin(&self) -> &Pose {
        &self.origin
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns whether the grid has no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Converts a point from the map frame to cells, with (0, 0) at the origin.
    pub fn to_cells(&self, point: Point) -> Point {
        Point::from((self.inverse * point).coords / self.resolution)
    }

    /// Converts a point from cells to the map frame, m.
    pub fn to_map(&self, cells: Point) -> Point {
        self.origin * Point::from(cells.coords * self.resolution)
    }

    /// The cell that contains a point of the map frame; `None` outside the grid.
    pub fn cell(&self, point: Point) -> Option<Cell> {
        self.cell_of(self.to_cells(point))
    }

    /// The cell that contains a point given in cells; `None` outside the grid.
    pub fn cell_of(&self, cells: Point) -> Option<Cell> {
        let inside = |value: f64, size: u32| {
            (value >= 0.0 && value < f64::from(size)).then_some(value as u32)
        };
        Some(Cell::new(
            inside(cells.x, self.width)?,
            inside(cells.y, self.height)?,
        ))
    }

    /// The centre of a cell, map frame, m.
    pub fn centre(&self, cell: Cell) -> Point {
        self.to_map(Point::new(
            f64::from(cell.column) + 0.5,
            f64::from(cell.row) + 0.5,
        ))
    }

    /// Row-major index of a cell; `None` outside the grid.
    pub fn index(&self, cell: Cell) -> Option<usize> {
        (cell.column < self.width && cell.row < self.height)
            .then(|| cell.row as usize * self.width as usize + cell.column as usize)
    }

    /// The cell at an index below [`GridLayout::len`]; the inverse of [`GridLayout::index`].
    pub fn cell_at(&self, index: usize) -> Cell {
        let width = self.width.max(1) as usize;
        Cell::new((index % width) as u32, (index / width) as u32)
    }

    /// The smallest and the largest x and y of the grid's corners, map frame, m.
    pub fn bounds(&self) -> (Point, Point) {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let corners = [(0.0, 0.0), (width, 0.0), (0.0, height), (width, height)]
            .map(|(x, y)| self.to_map(Point::new(x, y)));
        corners
            .iter()
            .fold((corners[0], corners[0]), |(low, high), corner| {
                (low.inf(corner), high.sup(corner))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::heading;

    fn turned() -> GridLayout {
        GridLayout::new(
            0.5,
            4,
            3,
            heading(Point::new(10.0, -2.0), std::f64::consts::FRAC_PI_2),
        )
        .unwrap()
    }

    #[test]
    fn it_finds_every_cell_from_its_centre() {
        let layout = turned();
        for index in 0..layout.len() {
            let cell = layout.cell_at(index);
            assert_eq!(layout.index(cell), Some(index));
            assert_eq!(layout.cell(layout.centre(cell)), Some(cell));
        }
    }

    #[test]
    fn it_turns_with_its_origin() {
        let centre = turned().centre(Cell::new(3, 0));
        assert!((centre - Point::new(9.75, -0.25)).norm() < 1e-12);
    }

    #[test]
    fn it_has_no_cell_outside_or_nowhere() {
        let layout = GridLayout::new(1.0, 2, 2, Pose::identity()).unwrap();
        for (x, y) in [
            (-1e-9, 1.0),
            (2.0, 1.0),
            (1.0, 2.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
        ] {
            assert_eq!(layout.cell(Point::new(x, y)), None);
        }
    }

    #[test]
    fn it_refuses_numbers_that_are_no_grid() {
        for resolution in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(GridLayout::new(resolution, 1, 1, Pose::identity()).is_err());
        }
        assert!(GridLayout::new(1.0, u32::MAX, u32::MAX, Pose::identity()).is_err());
        let nowhere = heading(Point::new(f64::NAN, 0.0), 0.0);
        assert_eq!(
            GridLayout::new(1.0, 1, 1, nowhere),
            Err(GridLayoutError::Origin)
        );
    }
}
