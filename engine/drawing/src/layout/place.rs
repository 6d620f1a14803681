//! Assigns coordinates to boxes and lines.

use super::LinePoint;
use super::layer::Layered;

/// Space between layers, and between items within a layer, in pixels.
const ACROSS: f64 = 64.0;
const BETWEEN: f64 = 26.0;
const BETWEEN_LINES: f64 = 12.0;

/// Number of rounds that improve the vertical positions.
const ROUNDS: usize = 40;

/// The coordinates of a layered frame.
pub(crate) struct Coordinates {
    pub width: f64,
    pub height: f64,
    /// Upper left corner of each slot.
    pub corners: Vec<(f64, f64)>,
    /// Points of each link.
    pub lines: Vec<Vec<LinePoint>>,
}

/// A line between two slots, and its vertical positions from their tops.
struct SlotEdge {
    one: usize,
    one_y: f64,
    other: usize,
    other_y: f64,
    /// Weight of keeping the line straight.
    pull: f64,
}

/// Assigns coordinates to all slots.
pub(crate) fn assign_coordinates(layered: &Layered) -> Coordinates {
    let y = heights(layered);
    let (x, right) = widths(layered);
    let corners: Vec<(f64, f64)> = x.iter().copied().zip(y.iter().copied()).collect();
    let bottoms = y
        .iter()
        .zip(&layered.slots)
        .map(|(y, slot)| y + slot.height);
    let height = bottoms.fold(0.0, f64::max);
    Coordinates {
        width: right.last().map_or(0.0, |(_, right)| *right),
        height,
        lines: lines(layered, &corners, &right),
        corners,
    }
}

fn joints(layered: &Layered) -> Vec<SlotEdge> {
    let mut joints = Vec::new();
    for ((link, chain), backwards) in layered
        .links
        .iter()
        .zip(&layered.chains)
        .zip(&layered.backwards)
    {
        for (one, other) in chain.iter().zip(chain.iter().skip(1)) {
            let middle = |slot: &usize, y: f64| match layered.slots.get(*slot) {
                Some(slot) if slot.is_box => y,
                _ => 2.0,
            };
            let lines = [one, other]
                .into_iter()
                .filter(|it| layered.slots.get(**it).is_some_and(|it| !it.is_box));
            joints.push(SlotEdge {
                one: *one,
                one_y: middle(one, link.from_y),
                other: *other,
                other_y: middle(other, link.to_y),
                pull: [1.0, 2.0, 8.0].get(lines.count()).copied().unwrap_or(1.0),
            });
        }
        if let (true, Some(first), Some(last)) = (backwards, chain.first(), chain.last()) {
            for (one, one_y, other) in [
                (link.to, link.to_y, *first),
                (link.from, link.from_y, *last),
            ] {
                joints.push(SlotEdge {
                    one,
                    one_y,
                    other,
                    other_y: 2.0,
                    pull: 0.3,
                });
            }
        }
    }
    joints
}

/// Vertical position of each slot: near its neighbours in other layers, without overlap.
fn heights(layered: &Layered) -> Vec<f64> {
    let joints = joints(layered);
    let mut y = vec![0.0; layered.slots.len()];
    for layer in &layered.layers {
        let preferred = vec![(0.0, 1.0); layer.len()];
        assign_positions(layered, layer, &preferred, &mut y);
    }
    for round in 0..ROUNDS {
        let count = layered.layers.len();
        for step in 0..count {
            let index = if round % 2 == 0 {
                step
            } else {
                count - 1 - step
            };
            let Some(layer) = layered.layers.get(index) else {
                continue;
            };
            let preferred: Vec<(f64, f64)> = layer
                .iter()
                .map(|slot| preferred_position(*slot, &joints, &y))
                .collect();
            assign_positions(layered, layer, &preferred, &mut y);
        }
    }
    let top = y.iter().copied().fold(f64::INFINITY, f64::min);
    y.iter().map(|y| (y - top).round()).collect()
}

/// The preferred position of a slot, and its weight.
fn preferred_position(slot: usize, joints: &[SlotEdge], y: &[f64]) -> (f64, f64) {
    let at = |slot: usize| y.get(slot).copied().unwrap_or(0.0);
    let (mut sum, mut weight) = (at(slot) * 0.05, 0.05);
    for joint in joints {
        if joint.one == slot {
            sum += (at(joint.other) + joint.other_y - joint.one_y) * joint.pull;
            weight += joint.pull;
        } else if joint.other == slot {
            sum += (at(joint.one) + joint.one_y - joint.other_y) * joint.pull;
            weight += joint.pull;
        }
    }
    (sum / weight, weight)
}

/// Places the slots of a layer as near as possible to their preferred positions, in order and without overlap: slots
/// that would overlap form a block, which is placed at the weighted mean of its members' preferences.
fn assign_positions(layered: &Layered, layer: &[usize], preferred: &[(f64, f64)], y: &mut [f64]) {
    // each block: the weighted sum of preferred positions of its first member, the weight, and the number of members
    let mut blocks: Vec<(f64, f64, usize)> = Vec::new();
    let mut offsets = Vec::with_capacity(layer.len());
    let mut offset = 0.0;
    let mut previous: Option<usize> = None;
    for slot in layer {
        if let Some(previous) = previous.and_then(|it| layered.slots.get(it)) {
            let next_is_box = layered.slots.get(*slot).is_some_and(|it| it.is_box);
            let gap = match (previous.is_box, next_is_box) {
                (true, true) => BETWEEN,
                (false, false) => BETWEEN_LINES,
                _ => BETWEEN * 0.7,
            };
            offset += previous.height + gap;
        }
        offsets.push(offset);
        previous = Some(*slot);
    }
    for ((wish, weight), offset) in preferred.iter().zip(&offsets) {
        let mut block = ((wish - offset) * weight, *weight, 1);
        while let Some(above) = blocks.last() {
            if above.0 / above.1 <= block.0 / block.1 {
                break;
            }
            block = (above.0 + block.0, above.1 + block.1, above.2 + block.2);
            blocks.pop();
        }
        blocks.push(block);
    }
    let tops = blocks
        .iter()
        .flat_map(|block| std::iter::repeat_n(block.0 / block.1, block.2));
    for ((slot, offset), top) in layer.iter().zip(&offsets).zip(tops) {
        if let Some(y) = y.get_mut(*slot) {
            *y = top + offset;
        }
    }
}

/// Horizontal position of each slot, and the borders of each layer.
fn widths(layered: &Layered) -> (Vec<f64>, Vec<(f64, f64)>) {
    let mut x = vec![0.0; layered.slots.len()];
    let mut borders = Vec::new();
    let mut left = 0.0;
    for layer in &layered.layers {
        let boxes = layer.iter().filter_map(|slot| layered.slots.get(*slot));
        let width = boxes.map(|slot| slot.width).fold(0.0, f64::max);
        for slot in layer {
            let own = layered.slots.get(*slot).map_or(0.0, |slot| slot.width);
            if let Some(x) = x.get_mut(*slot) {
                *x = (left + (width - own) / 2.0).round();
            }
        }
        borders.push((left, left + width));
        left += width + ACROSS;
    }
    (x, borders)
}

/// The points of each link: from the right side of its box, through its slots, to the left side of the other box.
fn lines(layered: &Layered, corners: &[(f64, f64)], borders: &[(f64, f64)]) -> Vec<Vec<LinePoint>> {
    let corner = |slot: usize| corners.get(slot).copied().unwrap_or_default();
    let all = layered
        .links
        .iter()
        .zip(&layered.chains)
        .zip(&layered.backwards);
    all.map(|((link, chain), backwards)| {
        let (from, to) = (corner(link.from), corner(link.to));
        let width = layered.slots.get(link.from).map_or(0.0, |slot| slot.width);
        let point = |x: f64, y: f64, backwards: bool| LinePoint { x, y, backwards };
        let mut points = vec![point(from.0 + width, from.1 + link.from_y, false)];
        let inner = chain
            .iter()
            .filter(|slot| layered.slots.get(**slot).is_some_and(|it| !it.is_box));
        let through = |slot: &usize| {
            let layer = layered.slots.get(*slot).map_or(0, |slot| slot.layer);
            let (left, right) = borders.get(layer).copied().unwrap_or_default();
            (left, right, corner(*slot).1 + 2.0)
        };
        if *backwards {
            let inner: Vec<_> = inner.map(through).collect();
            let last = inner.len().saturating_sub(1);
            for (index, (left, right, y)) in inner.iter().enumerate().rev() {
                // at both ends, the line turns close to the box
                let right = if index == last {
                    points.first().map_or(*right, |it| it.x)
                } else {
                    *right
                };
                let left = if index == 0 { to.0 } else { *left };
                points.extend([point(right, *y, true), point(left, *y, true)]);
            }
        } else {
            for (left, right, y) in inner.map(through) {
                points.extend([point(left, y, false), point(right, y, false)]);
            }
        }
        points.push(point(to.0, to.1 + link.to_y, false));
        points
    })
    .collect()
}
