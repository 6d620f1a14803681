//! Replaces staircases of cells by straight lines: a shortcut is taken if it is free and costs no more than the path it
//! replaces.

use asmotion_geometry::{GridLayout, Point};

use crate::costs::{BASE, Costs, TIGHT, WALL};

/// A point of the path, its cell, and its cost from the start.
#[derive(Clone, Copy)]
pub struct Knot {
    /// Position, map frame, m.
    pub point: Point,
    /// Index of the cell in the costs.
    pub cell: usize,
    /// Cost from the start along the cells.
    pub cost: u32,
}

/// Removes every knot that a straight line can skip.
///
/// A first pass compares neighbours, which takes linear time and leaves few knots; a second one finds the longest lines
/// among those.
pub fn smooth(layout: &GridLayout, costs: &Costs, knots: &mut Vec<Knot>) {
    advance(layout, costs, knots);
    reach_far(layout, costs, knots);
}

/// Removes knots as long as the next one can be reached by a straight line.
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

/// Goes from each knot to the farthest one that a straight line can reach.
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
    // the mean over the touched cells is slightly inaccurate, so one cell's side is tolerated
    straight <= f64::from(to.cost.saturating_sub(from.cost)) + f64::from(BASE)
}
