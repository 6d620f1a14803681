//! Costs of entering cells: higher near obstacles, forbidden within the inflation.

use asmotion_geometry::{Cell, Distances, Grid, GridLayout, Occupancy};

use crate::planner::PlannerSettings;

/// Cost of entering a cell in open space straight. Costs are integers, so that sums do not depend on their order.
pub const BASE: u32 = 128;
/// Cost of entering a cell in open space diagonally: √2 · [`BASE`].
pub const DIAGONAL: u32 = 181;
/// Largest cost of a cell.
pub const MOST: u32 = 24 * BASE;
/// Cost of a cell nearer to an obstacle than the inflation: a robot there may leave at high cost, but no path may
/// enter.
pub const TIGHT: u32 = MOST;
/// Marks a cell that no path may enter.
pub const WALL: u32 = 0;
/// Limit on `clearance_weight`, so that a comfortable distance costs less than one below the inflation.
const MOST_WEIGHT: f64 = 20.0;

/// The costs of a grid's cells, surrounded by a rim of walls so that neighbours need no bounds check.
#[derive(Default)]
pub struct Costs {
    /// Grid and settings the costs were computed from; equal ones need no update.
    grid: Option<Grid>,
    distances: Option<Distances>,
    cells: Vec<u16>,
    stride: usize,
}

impl Costs {
    /// Computes the costs, unless the grid equals that of the last call.
    pub fn update(&mut self, grid: &Grid, settings: &PlannerSettings) {
        if self.grid.as_ref() == Some(grid) {
            return;
        }
        let distances = match self.distances.take() {
            Some(mut distances) => {
                distances.compute(grid, |value| Occupancy::of(value) == Occupancy::Occupied);
                distances
            }
            None => Distances::to_occupied(grid),
        };
        self.fill(grid, &distances, settings);
        self.distances = Some(distances);
        match &mut self.grid {
            Some(kept) => kept.clone_from(grid),
            None => self.grid = Some(grid.clone()),
        }
    }

    /// Number of entries from one row to the next.
    pub fn stride(&self) -> usize {
        self.stride
    }

    /// Number of entries, including the rim.
    pub fn len(&self) -> usize {
        self.cells.len()
    }

    /// Cost of entering a cell; the index is that of [`Costs::index`].
    pub fn at(&self, index: usize) -> u32 {
        self.cells.get(index).map_or(WALL, |cost| u32::from(*cost))
    }

    /// Index of a cell's cost.
    pub fn index(&self, cell: Cell) -> usize {
        (cell.row as usize + 1) * self.stride + cell.column as usize + 1
    }

    /// The cell with this cost index, which must not be on the rim.
    pub fn cell(&self, index: usize) -> Cell {
        let stride = self.stride.max(1);
        Cell::new(
            (index % stride).saturating_sub(1) as u32,
            (index / stride).saturating_sub(1) as u32,
        )
    }

    /// Distance from a cell to the nearest obstacle, m.
    pub fn clearance(&self, cell: Cell) -> f64 {
        let distances = self.distances.as_ref();
        distances
            .and_then(|distances| distances.metres(cell))
            .unwrap_or(f64::INFINITY)
    }

    fn fill(&mut self, grid: &Grid, distances: &Distances, settings: &PlannerSettings) {
        let layout = grid.layout();
        let (width, height) = (layout.width() as usize, layout.height() as usize);
        self.stride = width + 2;
        self.cells.clear();
        self.cells.resize(self.stride * (height + 2), WALL as u16);
        let price = Price::new(layout, distances, settings);
        let inner = self.cells.chunks_mut(self.stride).skip(1);
        for (row, costs) in inner.take(height).enumerate() {
            let known = row * width..(row + 1) * width;
            let values = grid.cells()[known.clone()].iter();
            let distances_squared = distances.squared()[known].iter();
            for (cost, (value, squared)) in costs[1..].iter_mut().zip(values.zip(distances_squared))
            {
                *cost = price.of(*value, *squared) as u16;
            }
        }
    }
}

/// Computes the cost of a cell from its value and its distance to obstacles.
struct Price {
    /// Squared distance in cells up to which a cell is too near.
    tight: u32,
    /// Squared distance in cells up to which a cell costs more than open space.
    close: u32,
    /// Side length of a cell, m.
    resolution: f64,
    inflation_m: f64,
    comfort_m: f64,
    weight: f64,
    unknown: u32,
}

impl Price {
    fn new(layout: &GridLayout, distances: &Distances, settings: &PlannerSettings) -> Self {
        let comfort_m = settings.comfort_m.max(0.0);
        Self {
            tight: distances.limit(settings.inflation_m),
            close: distances.limit(settings.inflation_m + comfort_m),
            resolution: layout.resolution(),
            inflation_m: settings.inflation_m,
            comfort_m,
            weight: settings.clearance_weight.clamp(0.0, MOST_WEIGHT),
            unknown: if settings.allow_unknown { BASE } else { WALL },
        }
    }

    fn of(&self, value: i8, squared: u32) -> u32 {
        match Occupancy::of(value) {
            Occupancy::Occupied => WALL,
            Occupancy::Unknown if self.unknown == WALL => WALL,
            Occupancy::Unknown | Occupancy::Free => self.open(squared),
        }
    }

    fn open(&self, squared: u32) -> u32 {
        if squared <= self.tight {
            return TIGHT;
        }
        if squared > self.close {
            return BASE;
        }
        let distance = f64::from(squared).sqrt() * self.resolution;
        let wish = (1.0 - (distance - self.inflation_m) / self.comfort_m).clamp(0.0, 1.0);
        BASE + (f64::from(BASE) * self.weight * wish * wish).round() as u32
    }
}
