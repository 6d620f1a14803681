//! The walls of a grid: the borders between occupied and other cells, in as few segments as possible.

use crate::grid::{Grid, Occupancy};
use crate::layout::{Cell, GridLayout};
use crate::pose::Point;
use crate::scene::ObstacleScene;

impl ObstacleScene {
    /// Scene whose walls are the borders of a grid's occupied cells; map frame.
    pub fn around(grid: &Grid) -> Self {
        let layout = *grid.layout();
        // beyond the grid, no cell is occupied
        let occupied = |column: i64, row: i64| {
            let (column, row) = (u32::try_from(column), u32::try_from(row));
            let cell = column.ok().zip(row.ok());
            let index = cell.and_then(|(column, row)| layout.index(Cell::new(column, row)));
            index.is_some_and(|index| Occupancy::of(grid.cells()[index]) == Occupancy::Occupied)
        };
        let (width, height) = (i64::from(layout.width()), i64::from(layout.height()));
        let mut segments = Vec::new();
        for row in 0..=height {
            let border = |at: i64| occupied(at, row - 1) != occupied(at, row);
            let level = |from: i64, to: i64| side(&layout, (from, row), (to, row));
            segments.extend(runs(width, border).map(|(from, to)| level(from, to)));
        }
        for column in 0..=width {
            let border = |at: i64| occupied(column - 1, at) != occupied(column, at);
            let upright = |from: i64, to: i64| side(&layout, (column, from), (column, to));
            segments.extend(runs(height, border).map(|(from, to)| upright(from, to)));
        }
        Self::new(segments, Vec::new(), Vec::new())
    }
}

fn side(layout: &GridLayout, from: (i64, i64), to: (i64, i64)) -> [Point; 2] {
    [from, to].map(|(column, row)| layout.to_map(Point::new(column as f64, row as f64)))
}

/// The maximal ranges `from..to` within `0..size` in which `border` holds.
fn runs(size: i64, border: impl Fn(i64) -> bool) -> impl Iterator<Item = (i64, i64)> {
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < size && !border(at) {
            at += 1;
        }
        let from = at;
        while at < size && border(at) {
            at += 1;
        }
        (from < at).then_some((from, at))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{FREE, OCCUPIED};
    use crate::pose::{Pose, Vector};

    #[test]
    fn it_has_four_walls_around_a_block() {
        let layout = GridLayout::new(0.5, 6, 6, Pose::identity()).unwrap();
        let mut grid = Grid::new(layout, FREE);
        for (column, row) in [(2, 2), (3, 2), (2, 3), (3, 3)] {
            grid.set(Cell::new(column, row), OCCUPIED);
        }
        let scene = ObstacleScene::around(&grid);
        assert_eq!(scene.segments().len(), 4);
        let hit = scene.raycast(Point::new(0.25, 1.5), Vector::x(), 9.0);
        assert!((hit.unwrap() - 0.75).abs() < 1e-6);
    }
}
