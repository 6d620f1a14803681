//! A* on a grid of costs: eight neighbours, no corner cut, ties always broken the same way
//! (Hart, Nilsson, Raphael 1968; the open list is a ring of buckets after Dial 1969).
//!
//! Keys are integers and never decrease, so the ring needs to span only the largest increment of a key.

use crate::costs::{BASE, Costs, DIAGONAL, MOST, TIGHT, WALL};

/// Number of buckets. Exceeds the largest increment of a key: the most expensive diagonal step plus the change of the
/// heuristic.
const RING: usize = 8192;
const _: () = assert!(RING > ((MOST * DIAGONAL / BASE) + DIAGONAL) as usize);

/// Value of `from` for a cell that has not been reached.
const NOWHERE: u8 = 8;
/// Flag in `from`, set once the path to a cell is final.
const SETTLED: u8 = 0x80;

/// The buffers of a search, kept for reuse.
pub struct GridSearch {
    /// Cheapest known cost from the start to each cell.
    costs: Vec<u32>,
    /// Index of the direction in which that path enters each cell.
    from: Vec<u8>,
    /// Open cells, in the bucket of their key modulo [`RING`]; last in, first out.
    open: Vec<Vec<u32>>,
}

/// Outcome of a search.
pub struct SearchResult {
    /// The goal was reached.
    pub reached: bool,
    /// Number of settled cells, a measure of the work done.
    pub explored: usize,
}

/// The eight directions, straight ones first: the increment of the index, and its horizontal part.
struct Directions([(isize, isize); 8]);

impl Directions {
    fn new(stride: usize) -> Self {
        let stride = stride as isize;
        let step = |column: isize, row: isize| (row * stride + column, column);
        Self([
            step(1, 0),
            step(0, 1),
            step(-1, 0),
            step(0, -1),
            step(1, 1),
            step(-1, 1),
            step(-1, -1),
            step(1, -1),
        ])
    }
}

impl GridSearch {
    /// Creates an empty search.
    pub fn new() -> Self {
        Self {
            costs: Vec::new(),
            from: Vec::new(),
            open: vec![Vec::new(); RING],
        }
    }

    /// Finds the cheapest path between two cells, given by their index in `costs`; neither may be a wall.
    pub fn run(&mut self, costs: &Costs, start: usize, goal: usize) -> SearchResult {
        self.reset(costs.len());
        let directions = Directions::new(costs.stride());
        let (column, row) = place(goal, costs.stride());
        let estimate = |index: usize| {
            let (x, y) = place(index, costs.stride());
            octile(x.abs_diff(column), y.abs_diff(row))
        };
        let mut explored = 0;
        let mut waiting = 1_usize;
        let mut key = estimate(start);
        self.costs[start] = 0;
        self.open[key as usize % RING].push(start as u32);
        while waiting > 0 {
            let Some(next) = self.open[key as usize % RING].pop() else {
                key += 1;
                continue;
            };
            waiting -= 1;
            let index = next as usize;
            if self.from[index] & SETTLED != 0 {
                continue;
            }
            self.from[index] |= SETTLED;
            explored += 1;
            if index == goal {
                return SearchResult {
                    reached: true,
                    explored,
                };
            }
            waiting += self.expand(costs, &directions, index, &estimate);
        }
        SearchResult {
            reached: false,
            explored,
        }
    }

    /// Collects the cells of the path found, from the start to `goal`, each with its cost from the start.
    pub fn collect_path(&self, costs: &Costs, goal: usize, path: &mut Vec<(usize, u32)>) {
        let directions = Directions::new(costs.stride());
        path.clear();
        let mut index = goal;
        loop {
            path.push((index, self.costs[index]));
            let Some((step, _)) = directions.0.get((self.from[index] & !SETTLED) as usize) else {
                break;
            };
            index = index.wrapping_add_signed(-step);
        }
        path.reverse();
    }

    fn reset(&mut self, cells: usize) {
        self.costs.clear();
        self.costs.resize(cells, u32::MAX);
        self.from.clear();
        self.from.resize(cells, NOWHERE);
        self.open.iter_mut().for_each(Vec::clear);
    }

    /// Relaxes the neighbours of a cell; returns the number of costs lowered.
    fn expand(
        &mut self,
        costs: &Costs,
        directions: &Directions,
        index: usize,
        estimate: &impl Fn(usize) -> u64,
    ) -> usize {
        let leaving = costs.at(index) == TIGHT;
        let here = self.costs[index];
        let enters = |step: isize| {
            let cost = costs.at(index.wrapping_add_signed(step));
            (cost != WALL && (leaving || cost != TIGHT)).then_some(cost)
        };
        let mut taken = 0;
        for (direction, (step, sideways)) in directions.0.iter().enumerate() {
            let Some(mut cost) = enters(*step) else {
                continue;
            };
            if direction >= 4 {
                // corners are not cut: both cells beside a diagonal must be free
                if enters(*sideways).is_none() || enters(step - sideways).is_none() {
                    continue;
                }
                cost = cost * DIAGONAL / BASE;
            }
            let neighbour = index.wrapping_add_signed(*step);
            let total = here.saturating_add(cost);
            if self.from[neighbour] & SETTLED == 0 && total < self.costs[neighbour] {
                self.costs[neighbour] = total;
                self.from[neighbour] = direction as u8;
                let key = u64::from(total) + estimate(neighbour);
                self.open[key as usize % RING].push(neighbour as u32);
                taken += 1;
            }
        }
        taken
    }
}

fn place(index: usize, stride: usize) -> (u64, u64) {
    ((index % stride) as u64, (index / stride) as u64)
}

/// The cost of the shortest path in open space, with straight and diagonal steps.
fn octile(dx: u64, dy: u64) -> u64 {
    let (short, long) = (dx.min(dy), dx.max(dy));
    u64::from(BASE) * (long - short) + u64::from(DIAGONAL) * short
}
