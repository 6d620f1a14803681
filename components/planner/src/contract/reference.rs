//! A slow and obvious search, with which planners are compared.

use asmotion_geometry::{Cell, Grid, Occupancy, Point};

use crate::planner::PlannerSettings;

/// A grid with the information the reference needs.
pub(super) struct Reference<'a> {
    grid: &'a Grid,
    walls: Vec<bool>,
    tight: Vec<bool>,
}

impl<'a> Reference<'a> {
    pub(super) fn new(grid: &'a Grid, settings: &PlannerSettings) -> Self {
        let layout = grid.layout();
        let all = || (0..layout.len()).map(|index| layout.cell_at(index));
        let occupied: Vec<Cell> = all()
            .filter(|cell| grid.get(*cell).map(Occupancy::of) == Some(Occupancy::Occupied))
            .collect();
        let reach = settings.inflation_m / layout.resolution() + 1e-6;
        let near = |cell: Cell| {
            occupied.iter().any(|other| {
                let dx = f64::from(cell.column) - f64::from(other.column);
                let dy = f64::from(cell.row) - f64::from(other.row);
                dx.hypot(dy) <= reach
            })
        };
        Self {
            grid,
            walls: all().map(|cell| occupied.contains(&cell)).collect(),
            tight: all().map(near).collect(),
        }
    }

    /// Returns whether the cell is occupied.
    pub(super) fn wall(&self, cell: Cell) -> bool {
        is_set(&self.walls, self.grid.layout().index(cell))
    }

    /// Returns whether the cell is nearer to an occupied one than the robot may come.
    pub(super) fn tight(&self, cell: Cell) -> bool {
        is_set(&self.tight, self.grid.layout().index(cell))
    }

    /// Length in m of the shortest path with straight and diagonal steps that cuts no corner; `None` if there is none.
    /// Relaxes every cell until nothing changes.
    pub(super) fn shortest(&self, start: Point, goal: Point) -> Option<f64> {
        let layout = self.grid.layout();
        let (start, goal) = (layout.cell(start)?, layout.cell(goal)?);
        if self.wall(start) || self.wall(goal) || self.tight(goal) {
            return None;
        }
        let mut lengths = vec![f64::INFINITY; layout.len()];
        lengths[layout.index(start)?] = 0.0;
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(cell) = queue.pop_front() {
            let here = lengths[layout.index(cell)?];
            for (next, step) in self.neighbours(cell) {
                let known = &mut lengths[layout.index(next)?];
                if here + step < *known - 1e-12 {
                    *known = here + step;
                    queue.push_back(next);
                }
            }
        }
        let length = lengths[layout.index(goal)?];
        length.is_finite().then_some(length * layout.resolution())
    }

    fn neighbours(&self, cell: Cell) -> Vec<(Cell, f64)> {
        let leaving = self.tight(cell);
        let at = |dx: i64, dy: i64| {
            let column = u32::try_from(i64::from(cell.column) + dx).ok()?;
            let row = u32::try_from(i64::from(cell.row) + dy).ok()?;
            let next = Cell::new(column, row);
            let index = self.grid.layout().index(next)?;
            (!self.walls[index] && (leaving || !self.tight[index])).then_some(next)
        };
        let mut found = Vec::new();
        for (dx, dy) in [
            (1, 0),
            (-1, 0),
            (0, 1),
            (0, -1),
            (1, 1),
            (1, -1),
            (-1, 1),
            (-1, -1),
        ] {
            let Some(next) = at(dx, dy) else { continue };
            let diagonal = dx != 0 && dy != 0;
            if !diagonal || (at(dx, 0).is_some() && at(0, dy).is_some()) {
                found.push((next, if diagonal { 2f64.sqrt() } else { 1.0 }));
            }
        }
        found
    }
}

fn is_set(cells: &[bool], index: Option<usize>) -> bool {
    index
        .and_then(|index| cells.get(index))
        .copied()
        .unwrap_or(false)
}
