//! Distance of each cell from the nearest obstacle: the exact Euclidean distance transform in linear time
//! (Meijster, Roerdink, Hesselink: *A general algorithm for computing distance transforms in linear time*, 2000).

use serde::{Deserialize, Serialize};

use crate::grid::{Grid, OCCUPIED, Occupancy};
use crate::layout::{Cell, GridLayout};

/// Squared distances to the nearest obstacle cell, centre to centre.
///
/// Keep the value to reuse its buffers in [`Distances::compute`].
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "SquaredDistances")]
pub struct Distances {
    layout: GridLayout,
    /// In cells², row-major; [`Distances::NONE`] if the grid has no obstacle.
    #[serde(with = "asmotion_datum::field")]
    squared: Vec<u32>,
    /// Distance in cells to the nearest obstacle in the same column: the result of the first pass.
    #[serde(skip_serializing)]
    columns: Vec<u32>,
    /// The lower envelope of the second pass: each column, and the first column in which its parabola is lowest.
    #[serde(skip_serializing)]
    envelope: Vec<(i64, i64)>,
}

/// Serialised form of the distances, without the working memory of the two passes.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SquaredDistances {
    layout: GridLayout,
    #[serde(with = "asmotion_datum::field")]
    squared: Vec<u32>,
}

impl TryFrom<SquaredDistances> for Distances {
    type Error = &'static str;

    fn try_from(read: SquaredDistances) -> Result<Self, &'static str> {
        let SquaredDistances { layout, squared } = read;
        if squared.len() as u64 != u64::from(layout.width()) * u64::from(layout.height()) {
            return Err("a distance is wanted for each cell");
        }
        Ok(Self {
            layout,
            squared,
            columns: Vec::new(),
            envelope: Vec::new(),
        })
    }
}

impl Distances {
    /// The value if there is no obstacle.
    pub const NONE: u32 = u32::MAX;

    /// Computes the distances to the occupied cells of a grid.
    pub fn to_occupied(grid: &Grid) -> Self {
        let mut distances = Self {
            layout: *grid.layout(),
            squared: Vec::new(),
            columns: Vec::new(),
            envelope: Vec::new(),
        };
        distances.compute(grid, |value| Occupancy::of(value) == Occupancy::Occupied);
        distances
    }

    /// Computes the distances to the cells for which `obstacle` returns `true`.
    pub fn compute(&mut self, grid: &Grid, obstacle: impl Fn(i8) -> bool) {
        self.layout = *grid.layout();
        self.along_columns(grid.cells(), obstacle);
        self.along_rows();
    }

    /// Layout of the grid.
    pub fn layout(&self) -> &GridLayout {
        &self.layout
    }

    /// Squared distances in cells², row-major; [`Distances::NONE`] without obstacles.
    pub fn squared(&self) -> &[u32] {
        &self.squared
    }

    /// Distance of a cell in m: infinite without obstacles, `None` outside the grid.
    pub fn metres(&self, cell: Cell) -> Option<f64> {
        Some(match self.squared[self.layout.index(cell)?] {
            Self::NONE => f64::INFINITY,
            squared => f64::from(squared).sqrt() * self.layout.resolution(),
        })
    }

    /// The largest squared distance in cells² that is within `radius` metres.
    pub fn limit(&self, radius: f64) -> u32 {
        let cells = radius.max(0.0) / self.layout.resolution();
        // a radius of a whole number of cells must include that cell in spite of rounding
        let squared = (cells * cells + 1e-6).floor();
        squared.min(f64::from(Self::NONE - 1)) as u32
    }

    fn along_columns(&mut self, cells: &[i8], obstacle: impl Fn(i8) -> bool) {
        let width = self.layout.width() as usize;
        self.columns.clear();
        self.columns.resize(cells.len(), Self::NONE);
        for (index, value) in cells.iter().enumerate() {
            self.columns[index] = if obstacle(*value) {
                0
            } else if index >= width {
                self.columns[index - width].saturating_add(1)
            } else {
                Self::NONE
            };
        }
        for index in (0..cells.len().saturating_sub(width)).rev() {
            let below = self.columns[index + width].saturating_add(1);
            self.columns[index] = self.columns[index].min(below);
        }
    }

    fn along_rows(&mut self) {
        let width = self.layout.width() as usize;
        self.squared.clear();
        self.squared.resize(self.columns.len(), Self::NONE);
        if width == 0 {
            return;
        }
        let rows = self.columns.chunks(width);
        for (columns, squared) in rows.zip(self.squared.chunks_mut(width)) {
            build_envelope(columns, &mut self.envelope);
            read_envelope(columns, &self.envelope, squared);
        }
    }
}

/// The parabolas of the lower envelope from left to right, each with the first column in which it is lowest.
fn build_envelope(columns: &[u32], envelope: &mut Vec<(i64, i64)>) {
    envelope.clear();
    let width = columns.len() as i64;
    for (at, depth) in columns.iter().enumerate() {
        if *depth == Distances::NONE {
            continue;
        }
        let at = at as i64;
        let mut from = 0;
        while let Some(&(other, since)) = envelope.last() {
            let height = |column: i64, x: i64| {
                let depth = i64::from(columns[column as usize]);
                (x - column) * (x - column) + depth * depth
            };
            if height(at, since) <= height(other, since) {
                envelope.pop();
                continue;
            }
            // first column in which `at` is lower than `other`
            let (far, near) = (height(at, 0), height(other, 0));
            from = (far - near).div_euclid(2 * (at - other)) + 1;
            break;
        }
        if from < width {
            envelope.push((at, from));
        }
    }
}

fn read_envelope(columns: &[u32], envelope: &[(i64, i64)], squared: &mut [u32]) {
    let mut rulers = envelope.iter().peekable();
    let mut ruler = None;
    for (x, cell) in squared.iter_mut().enumerate() {
        let x = x as i64;
        while let Some(next) = rulers.next_if(|(_, from)| *from <= x) {
            ruler = Some(next.0);
        }
        if let Some(column) = ruler {
            let depth = i64::from(columns[column as usize]);
            let distance = (x - column) * (x - column) + depth * depth;
            *cell = u32::try_from(distance).unwrap_or(Distances::NONE - 1);
        }
    }
}

impl Grid {
    /// The grid in which all cells are occupied whose centre is at most `radius` metres from that of an occupied cell:
    /// those in which a round robot of this radius cannot stand.
    pub fn inflated(&self, radius: f64) -> Self {
        let distances = Distances::to_occupied(self);
        let limit = distances.limit(radius);
        let mut inflated = self.clone();
        for (value, squared) in inflated.cells_mut().iter_mut().zip(distances.squared()) {
            if *squared <= limit {
                *value = (*value).max(OCCUPIED);
            }
        }
        inflated
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{FREE, OCCUPIED};
    use crate::pose::Pose;
    use proptest::prelude::*;

    fn by_brute_force(grid: &Grid) -> Vec<u32> {
        let layout = grid.layout();
        let obstacles: Vec<Cell> = (0..layout.len())
            .filter(|index| grid.cells()[*index] == OCCUPIED)
            .map(|index| layout.cell_at(index))
            .collect();
        let squared = |one: Cell, other: Cell| {
            one.column.abs_diff(other.column).pow(2) + one.row.abs_diff(other.row).pow(2)
        };
        (0..layout.len())
            .map(|index| {
                let nearest = obstacles
                    .iter()
                    .map(|obstacle| squared(layout.cell_at(index), *obstacle));
                nearest.min().unwrap_or(Distances::NONE)
            })
            .collect()
    }

    proptest! {
        #[test]
        fn it_is_exact(width in 1u32..24, height in 1u32..24, seed in prop::collection::vec(0u8..12, 576)) {
            let layout = GridLayout::new(0.05, width, height, Pose::identity()).unwrap();
            let cells = seed.iter().take(layout.len()).map(|dice| if *dice == 0 { OCCUPIED } else { FREE }).collect();
            let grid = Grid::with_cells(layout, cells).unwrap();
            let distances = Distances::to_occupied(&grid);
            prop_assert_eq!(distances.squared(), &by_brute_force(&grid)[..]);
        }
    }

    #[test]
    fn it_counts_metres() {
        let layout = GridLayout::new(0.5, 5, 5, Pose::identity()).unwrap();
        let mut grid = Grid::new(layout, FREE);
        assert_eq!(
            Distances::to_occupied(&grid).metres(Cell::new(0, 0)),
            Some(f64::INFINITY)
        );
        grid.set(Cell::new(4, 3), OCCUPIED);
        let distances = Distances::to_occupied(&grid);
        assert_eq!(distances.metres(Cell::new(0, 0)), Some(2.5));
        assert_eq!(distances.metres(Cell::new(5, 0)), None);
    }

    #[test]
    fn it_takes_an_empty_grid() {
        let empty = Grid::new(GridLayout::new(1.0, 0, 0, Pose::identity()).unwrap(), FREE);
        assert!(Distances::to_occupied(&empty).squared().is_empty());
    }
}
