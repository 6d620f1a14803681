//! Occupancy grids: `nav_msgs/OccupancyGrid` as a value with queries.

use crate::layout::{Cell, GridLayout, GridLayoutError};
use crate::pose::Point;

/// ROS value of a cell that has not been observed.
pub const UNKNOWN: i8 = -1;
/// ROS value of a free cell.
pub const FREE: i8 = 0;
/// ROS value of an occupied cell.
pub const OCCUPIED: i8 = 100;
/// The probability in percent from which a cell counts as occupied: map_server's default `occupied_thresh`.
pub const OCCUPIED_FROM: i8 = 65;

/// Meaning of a cell's value for planning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// Not observed, or outside the grid.
    Unknown,
    /// Free for a robot.
    Free,
    /// Occupied by an obstacle.
    Occupied,
}

impl Occupancy {
    /// Meaning of a ROS cell value: below 0 unknown, from [`OCCUPIED_FROM`] on occupied, else free.
    pub fn of(value: i8) -> Self {
        match value {
            ..0 => Self::Unknown,
            OCCUPIED_FROM.. => Self::Occupied,
            _ => Self::Free,
        }
    }

    /// The ROS value for certain knowledge of this occupancy.
    pub fn value(self) -> i8 {
        match self {
            Self::Unknown => UNKNOWN,
            Self::Free => FREE,
            Self::Occupied => OCCUPIED,
        }
    }
}

/// An occupancy grid: row-major cells with ROS values, -1 unknown, 0 (free) to 100 (occupied).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    layout: GridLayout,
    cells: Vec<i8>,
}

impl Grid {
    /// Creates a grid in which all cells have the same value.
    pub fn new(layout: GridLayout, value: i8) -> Self {
        Self {
            cells: vec![value; layout.len()],
            layout,
        }
    }

    /// Creates a grid with these cells, row by row from cell (0, 0).
    ///
    /// # Errors
    /// [`GridLayoutError::Cells`] if the layout has another number of cells.
    pub fn with_cells(layout: GridLayout, cells: Vec<i8>) -> Result<Self, GridLayoutError> {
        if cells.len() != layout.len() {
            return Err(GridLayoutError::Cells {
                width: layout.width(),
                height: layout.height(),
                found: cells.len(),
            });
        }
        Ok(Self { layout, cells })
    }

    /// Size, resolution and origin.
    pub fn layout(&self) -> &GridLayout {
        &self.layout
    }

    /// The values, row by row from cell (0, 0).
    pub fn cells(&self) -> &[i8] {
        &self.cells
    }

    /// Mutable access to the values.
    pub fn cells_mut(&mut self) -> &mut [i8] {
        &mut self.cells
    }

    /// The value of a cell; `None` outside the grid.
    pub fn get(&self, cell: Cell) -> Option<i8> {
        Some(self.cells[self.layout.index(cell)?])
    }

    /// Sets a cell; does nothing outside the grid.
    pub fn set(&mut self, cell: Cell, value: i8) {
        if let Some(index) = self.layout.index(cell) {
            self.cells[index] = value;
        }
    }

    /// Occupancy at a point in the map frame; unknown outside the grid.
    pub fn occupancy(&self, point: Point) -> Occupancy {
        self.layout
            .cell(point)
            .and_then(|cell| self.get(cell))
            .map_or(Occupancy::Unknown, Occupancy::of)
    }

    /// The grid with blocks of `factor` × `factor` cells merged. A merged cell has the value of its most occupied cell
    /// or, if none is occupied but one is unknown, is unknown. No obstacle is lost.
    ///
    /// # Errors
    /// [`GridLayoutError::Resolution`] if the coarser cells have no finite size.
    pub fn coarsened(&self, factor: u32) -> Result<Self, GridLayoutError> {
        let factor = factor.max(1);
        let layout = GridLayout::new(
            self.layout.resolution() * f64::from(factor),
            self.layout.width().div_ceil(factor),
            self.layout.height().div_ceil(factor),
            *self.layout.origin(),
        )?;
        let mut coarse = Self::new(layout, FREE);
        for (index, value) in self.cells.iter().enumerate() {
            let fine = self.layout.cell_at(index);
            let cell = Cell::new(fine.column / factor, fine.row / factor);
            if let Some(at) = layout.index(cell) {
                coarse.cells[at] = worse(coarse.cells[at], *value);
            }
        }
        Ok(coarse)
    }
}

/// The value that restricts a robot more: occupied, then unknown, then free.
fn worse(one: i8, other: i8) -> i8 {
    let rank = |value: i8| match Occupancy::of(value) {
        Occupancy::Free => (0, value),
        Occupancy::Unknown => (1, value),
        Occupancy::Occupied => (2, value),
    };
    if rank(other) > rank(one) { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;

    fn grid(width: u32, height: u32) -> Grid {
        Grid::new(
            GridLayout::new(0.1, width, height, Pose::identity()).unwrap(),
            FREE,
        )
    }

    #[test]
    fn it_reads_values_as_ros_means_them() {
        let meaning = [-128, -1, 0, 64, 65, 100, 127].map(|value| Occupancy::of(value).value());
        assert_eq!(meaning, [-1, -1, 0, 0, 100, 100, 100]);
    }

    #[test]
    fn it_inflates_to_a_disc_that_includes_its_rim() {
        let mut grid = grid(11, 11);
        grid.set(Cell::new(5, 5), OCCUPIED);
        let inflated = grid.inflated(0.3);
        for index in 0..grid.layout().len() {
            let cell = grid.layout().cell_at(index);
            let (dx, dy) = (cell.column as i32 - 5, cell.row as i32 - 5);
            let expected = if dx * dx + dy * dy <= 9 {
                OCCUPIED
            } else {
                FREE
            };
            assert_eq!(inflated.get(cell), Some(expected), "{cell:?}");
        }
    }

    #[test]
    fn it_is_unknown_outside() {
        assert_eq!(
            grid(2, 2).occupancy(Point::new(-1.0, 0.0)),
            Occupancy::Unknown
        );
    }

    #[test]
    fn it_coarsens_without_losing_what_blocks() {
        let mut grid = grid(5, 3);
        grid.set(Cell::new(1, 1), OCCUPIED);
        grid.set(Cell::new(4, 2), UNKNOWN);
        let coarse = grid.coarsened(2).unwrap();
        assert_eq!((coarse.layout().width(), coarse.layout().height()), (3, 2));
        assert_eq!(coarse.cells(), [100, 0, 0, 0, 0, -1]);
    }

    #[test]
    fn it_wants_a_value_for_each_cell() {
        let layout = *grid(2, 2).layout();
        assert!(Grid::with_cells(layout, vec![0; 3]).is_err());
    }
}
