//! From a staircase of cells to straight lines: a shortcut is taken where it is free and costs no more than the way
//! it replaces.

use asmotion_geometry::{GridLayout, Point};

use crate::costs::{BASE, Costs, TIGHT, WALL};

/// A point of the way, the cell it lies in, and what it costs from the start.
#[derive(Clone, Copy)]
pub struct Knot {
    /// Map frame, m.
    pub point: Point,
    /// In the costs.
    pub cell: usize,
    /// From the start, along the cells.
    pub cost: u32,
}

/// Leaves out every knot that a straight line can skip.
///
/// First from neighbour to neighbour, which is linear and leaves few knots; then among those the longest lines.
pub fn smooth(layout: &GridLayout, costs: &Costs, knots: &mut Vec<Knot>) {
    advance(layout, costs, knots);
    reach_far(layout, costs, knots);
}

/// Goes on from a knot as long as the next one is in sight.
fn advance(layout: &GridLayout, costs: &Costs, knots: &mut Vec<Knot>) {
    let mut kept = 0;
    for at in 1..knots.len() {
        let next = knots.get(at + 1);
        let skips = next.is_some_and(|next| shortcut(layout, costs, &knots[kept], next));
        if !skips {
            kept += 1;
            knots[kept] = knots[at];
        }
    }
    knots.truncate(kept + 1);
}

/// Goes from each knot to the furthest one in sight.
fn reach_far(layout: &GridLayout, costs: &Costs, knots: &mut Vec<Knot>) {
    let mut kept = 0;
    let mut at = 0;
    while at + 1 < knots.len() {
        let furthest = (at + 2..knots.len())
            .rev()
            .find(|far| shortcut(layout, costs, &knots[at], &knots[*far]));
        at = furthest.unwrap_or(at + 1);
        kept += 1;
        knots[kept] = knots[at];
    }
    knots.truncate(kept + 1);
}

/// Returns whether the straight line between two knots is allowed and costs no more than the path along the cells.
fn shortcut(layout: &GridLayout, costs: &Costs, from: &Knot, to: &Knot) -> bool {
    let (mut sum, mut cells) = (0_u64, 0_u64);
    let mut leaving = costs.at(from.cell) == TIGHT;
    let passes = layout.line(from.point, to.point, |index| {
        let cost = costs.at(costs.index(layout.cell_at(index)));
        leaving &= cost == TIGHT;
        sum += u64::from(cost);
        cells += 1;
        cost != WALL && (leaving || cost != TIGHT)
    });
    if !passes {
        return false;
    }
    let length = (to.point - from.point).norm() / layout.resolution();
    let straight = sum as f64 / cells.max(1) as f64 * length;
    // the mean over the touched cells is a hair off: one cell's side does not matter
    straight <= f64::from(to.cost.saturating_sub(from.cost)) + f64::from(BASE)
}
