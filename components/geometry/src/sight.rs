//! Lines on a grid: visits every cell that a straight line touches (Amanatides, Woo: *A fast voxel traversal
//! algorithm*, 1987; a line through a corner touches all four cells around it, so there is no line of sight between two
//! diagonal obstacles).

use crate::grid::Grid;
use crate::layout::{Cell, GridLayout};
use crate::pose::Point;

impl GridLayout {
    /// Returns whether `pass` accepts every cell that the straight line between two points of the map frame touches;
    /// `false` if the line leaves the grid.
    pub fn line(&self, from: Point, to: Point, mut pass: impl FnMut(usize) -> bool) -> bool {
        let (from, to) = (self.to_cells(from), self.to_cells(to));
        let (Some(start), Some(end)) = (self.cell_of(from), self.cell_of(to)) else {
            return false;
        };
        let mut visit = |column: i64, row: i64| {
            let cell = Cell::new(column as u32, row as u32);
            self.index(cell).is_some_and(&mut pass)
        };
        let mut along = WalkAxis::new(from.x, to.x, start.column, end.column);
        let mut across = WalkAxis::new(from.y, to.y, start.row, end.row);
        if !visit(along.at, across.at) {
            return false;
        }
        while along.left + across.left > 0 {
            let passed = if along.ties(&across) {
                let corner = visit(along.ahead(), across.at) && visit(along.at, across.ahead());
                along.step();
                across.step();
                corner
            } else if along.before(&across) {
                along.step();
                true
            } else {
                across.step();
                true
            };
            if !(passed && visit(along.at, across.at)) {
                return false;
            }
        }
        true
    }
}

impl Grid {
    /// Returns whether the straight line between two points of the map frame touches only cells whose value `pass`
    /// accepts; `false` if the line leaves the grid.
    pub fn sees(&self, from: Point, to: Point, pass: impl Fn(i8) -> bool) -> bool {
        self.layout()
            .line(from, to, |index| pass(self.cells()[index]))
    }
}

/// One axis of the traversal.
struct WalkAxis {
    /// Index of the current cell.
    at: i64,
    /// Direction of the line along this axis: +1 or -1.
    direction: i64,
    /// Number of cell borders still to cross.
    left: u64,
    /// Position of the next cell border on the line, 0..1.
    next: f64,
    /// Distance between two borders along the line, in the same unit as `next`.
    gap: f64,
}

impl WalkAxis {
    fn new(from: f64, to: f64, start: u32, end: u32) -> Self {
        let (start, end) = (i64::from(start), i64::from(end));
        let way = to - from;
        let border = if way > 0.0 { start + 1 } else { start };
        Self {
            at: start,
            direction: (end - start).signum(),
            left: start.abs_diff(end),
            next: (border as f64 - from) / way,
            gap: 1.0 / way.abs(),
        }
    }

    fn ahead(&self) -> i64 {
        self.at + self.direction
    }

    fn step(&mut self) {
        self.at += self.direction;
        self.left -= 1;
        self.next += self.gap;
    }

    fn before(&self, other: &Self) -> bool {
        other.left == 0 || (self.left > 0 && self.next < other.next)
    }

    fn ties(&self, other: &Self) -> bool {
        self.left > 0 && other.left > 0 && (self.next - other.next).abs() < 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{FREE, OCCUPIED};
    use crate::pose::Pose;
    use proptest::prelude::*;

    fn layout() -> GridLayout {
        GridLayout::new(1.0, 10, 10, Pose::identity()).unwrap()
    }

    fn touched(from: (f64, f64), to: (f64, f64)) -> Vec<(u32, u32)> {
        let mut cells = Vec::new();
        let layout = layout();
        layout.line(
            Point::new(from.0, from.1),
            Point::new(to.0, to.1),
            |index| {
                let cell = layout.cell_at(index);
                cells.push((cell.column, cell.row));
                true
            },
        );
        cells
    }

    #[test]
    fn it_touches_both_sides_of_a_corner() {
        assert_eq!(
            touched((0.5, 0.5), (1.5, 1.5)),
            [(0, 0), (1, 0), (0, 1), (1, 1)]
        );
    }

    #[test]
    fn it_walks_straight_and_back() {
        assert_eq!(touched((0.5, 0.5), (2.5, 0.5)), [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(touched((2.5, 0.5), (0.5, 0.5)), [(2, 0), (1, 0), (0, 0)]);
        assert_eq!(touched((0.5, 0.5), (0.5, 0.5)), [(0, 0)]);
    }

    #[test]
    fn it_does_not_see_between_diagonal_obstacles() {
        let mut grid = Grid::new(layout(), FREE);
        grid.set(Cell::new(3, 4), OCCUPIED);
        grid.set(Cell::new(4, 3), OCCUPIED);
        let free = |value| value == FREE;
        assert!(!grid.sees(Point::new(3.5, 3.5), Point::new(4.5, 4.5), free));
        assert!(grid.sees(Point::new(0.5, 3.5), Point::new(3.5, 3.5), free));
        assert!(!grid.sees(Point::new(0.5, 3.5), Point::new(-0.5, 3.5), free));
    }

    proptest! {
        #[test]
        fn it_touches_every_cell_a_sample_lies_in(x0 in 0.0..10.0, y0 in 0.0..10.0, x1 in 0.0..10.0, y1 in 0.0..10.0) {
            let cells = touched((x0, y0), (x1, y1));
            for step in 0..=1000 {
                let t = f64::from(step) / 1000.0;
                let (x, y) = (x0 + t * (x1 - x0), y0 + t * (y1 - y0));
                prop_assert!(cells.contains(&(x as u32, y as u32)) || near_border(x) || near_border(y), "({x}, {y}) missed");
            }
            prop_assert!(cells.windows(2).all(|pair| pair[0].0.abs_diff(pair[1].0) + pair[0].1.abs_diff(pair[1].1) <= 2));
        }
    }

    fn near_border(value: f64) -> bool {
        (value - value.round()).abs() < 1e-6
    }
}
