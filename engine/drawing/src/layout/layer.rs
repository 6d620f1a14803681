//! Assigns boxes to layers and orders each layer.

/// An edge between two boxes of a frame.
#[derive(Clone, Debug)]
pub(crate) struct LayerEdge {
    /// Position of the edge in the picture.
    pub edge: usize,
    pub from: usize,
    pub to: usize,
    /// Vertical positions at which it meets the boxes, from their tops.
    pub from_y: f64,
    pub to_y: f64,
}

/// Boxes in layers. In `slots`, the boxes are followed by the slots of long lines.
pub(crate) struct Layered {
    pub links: Vec<LayerEdge>,
    pub slots: Vec<LayerSlot>,
    /// Slots of each layer, from top to bottom.
    pub layers: Vec<Vec<usize>>,
    /// Slots that each link passes through, in order of layers. Includes its boxes at both ends, unless it runs
    /// backwards: then only the slots beside the boxes, from left to right.
    pub chains: Vec<Vec<usize>>,
    /// `true` for each link that runs from right to left.
    pub backwards: Vec<bool>,
}

/// A box, or the slot of a line in a layer.
#[derive(Clone, Debug)]
pub(crate) struct LayerSlot {
    pub layer: usize,
    pub width: f64,
    pub height: f64,
    pub is_box: bool,
}

/// Number of passes that reorder the layers.
const SWEEPS: usize = 24;

impl Layered {
    /// Assigns boxes of these sizes to layers; those in `left` to the first, those in `right` to the last.
    pub(crate) fn new(
        sizes: &[(f64, f64)],
        links: Vec<LayerEdge>,
        left: &[usize],
        right: &[usize],
    ) -> Self {
        let rank = ranks(sizes.len(), &links, left, right);
        let backwards: Vec<bool> = links
            .iter()
            .map(|link| rank.get(link.from) >= rank.get(link.to))
            .collect();
        let forward = links
            .iter()
            .zip(&backwards)
            .filter(|(_, backwards)| !**backwards);
        let forward: Vec<(usize, usize)> = forward.map(|(link, _)| (link.from, link.to)).collect();
        let layer = layers(sizes.len(), &forward, left, right);
        let slots = sizes
            .iter()
            .zip(&layer)
            .map(|((width, height), layer)| LayerSlot {
                layer: *layer,
                width: *width,
                height: *height,
                is_box: true,
            });
        let mut layered = Self {
            links,
            slots: slots.collect(),
            layers: Vec::new(),
            chains: Vec::new(),
            backwards,
        };
        layered.chains();
        layered.order();
        layered
    }

    /// Assigns slots to every line in the layers that it crosses.
    fn chains(&mut self) {
        for (link, backwards) in self.links.iter().zip(&self.backwards) {
            let at = |slot: usize| self.slots.get(slot).map_or(0, |slot| slot.layer);
            let (from, to) = (at(link.from), at(link.to));
            let crossed = if *backwards {
                to..from + 1
            } else {
                from + 1..to
            };
            let mut chain = Vec::new();
            for layer in crossed {
                chain.push(self.slots.len());
                self.slots.push(LayerSlot {
                    layer,
                    width: 0.0,
                    height: 4.0,
                    is_box: false,
                });
            }
            if !backwards {
                chain.insert(0, link.from);
                chain.push(link.to);
            }
            self.chains.push(chain);
        }
        let last = self.slots.iter().map(|slot| slot.layer).max().unwrap_or(0);
        self.layers = vec![Vec::new(); last + 1];
        for (index, slot) in self.slots.iter().enumerate() {
            if let Some(layer) = self.layers.get_mut(slot.layer) {
                layer.push(index);
            }
        }
    }

    /// Pairs of slots in adjacent layers that a line connects.
    fn joints(&self) -> Vec<(usize, usize)> {
        let chains = self.chains.iter();
        let pairs = chains.flat_map(|chain| chain.iter().zip(chain.iter().skip(1)));
        let mut joints: Vec<_> = pairs.map(|(one, other)| (*one, *other)).collect();
        // a line that runs backwards turns beside its boxes, and should stay near them
        for ((link, chain), backwards) in self.links.iter().zip(&self.chains).zip(&self.backwards) {
            if let (true, Some(first), Some(last)) = (backwards, chain.first(), chain.last()) {
                joints.push((link.to, *first));
                joints.push((link.from, *last));
            }
        }
        joints
    }

    /// Orders each layer by the mean position of its neighbours, in alternating directions, and keeps the order with
    /// the fewest crossings.
    fn order(&mut self) {
        let joints = self.joints();
        let mut neighbours = vec![Vec::new(); self.slots.len()];
        for (one, other) in &joints {
            for (at, near) in [(one, other), (other, one)] {
                if let Some(list) = neighbours.get_mut(*at) {
                    list.push(*near);
                }
            }
        }
        let mut best = (self.crossings(&joints), self.layers.clone());
        for sweep in 0..SWEEPS {
            let count = self.layers.len();
            for step in 0..count {
                let layer = if sweep % 2 == 0 {
                    step
                } else {
                    count - 1 - step
                };
                self.order_layer(layer, &neighbours);
            }
            let crossings = self.crossings(&joints);
            if crossings < best.0 {
                best = (crossings, self.layers.clone());
            }
        }
        self.layers = best.1;
    }

    /// Relative position of each slot in its layer, from 0 at the top to 1.
    fn heights(&self) -> Vec<f64> {
        let mut heights = vec![0.0; self.slots.len()];
        for layer in &self.layers {
            for (index, slot) in layer.iter().enumerate() {
                if let Some(height) = heights.get_mut(*slot) {
                    *height = (index as f64 + 0.5) / layer.len() as f64;
                }
            }
        }
        heights
    }

    fn order_layer(&mut self, layer: usize, neighbours: &[Vec<usize>]) {
        let heights = self.heights();
        let middle = |slot: &usize| {
            let adjacent = neighbours.get(*slot).map_or(&[][..], Vec::as_slice);
            let own = heights.get(*slot).copied().unwrap_or(0.0);
            let sum: f64 = adjacent.iter().filter_map(|it| heights.get(*it)).sum();
            match adjacent.len() {
                0 => own,
                count => sum / count as f64,
            }
        };
        if let Some(layer) = self.layers.get_mut(layer) {
            let mut keyed: Vec<(f64, usize)> =
                layer.iter().map(|slot| (middle(slot), *slot)).collect();
            keyed.sort_by(|one, other| one.0.total_cmp(&other.0));
            *layer = keyed.into_iter().map(|(_, slot)| slot).collect();
        }
    }

    fn crossings(&self, joints: &[(usize, usize)]) -> usize {
        let heights = self.heights();
        let at = |slot: usize| {
            let layer = self.slots.get(slot).map_or(0, |slot| slot.layer);
            (layer, heights.get(slot).copied().unwrap_or(0.0))
        };
        let lines = joints.iter().map(|(one, other)| (at(*one), at(*other)));
        let lines: Vec<_> = lines.filter(|(one, other)| one.0 < other.0).collect();
        let mut count = 0;
        for (index, (one, other)) in lines.iter().enumerate() {
            for (from, to) in lines.iter().skip(index + 1) {
                let cross = (one.1 - from.1) * (other.1 - to.1) < 0.0;
                count += usize::from(one.0 == from.0 && cross);
            }
        }
        count
    }
}

/// Orders the boxes so that few edges run backwards, after Eades, Lin and Smyth.
fn ranks(count: usize, links: &[LayerEdge], left: &[usize], right: &[usize]) -> Vec<usize> {
    let mut open: Vec<usize> = (0..count)
        .filter(|it| !left.contains(it) && !right.contains(it))
        .collect();
    let (mut first, mut last) = (left.to_vec(), Vec::new());
    while !open.is_empty() {
        let degree = |of: usize, out: bool| {
            let ends = links.iter().map(|link| {
                if out {
                    (link.from, link.to)
                } else {
                    (link.to, link.from)
                }
            });
            ends.filter(|(at, other)| *at == of && other != at && open.contains(other))
                .count() as i64
        };
        let sink = open
            .iter()
            .position(|it| degree(*it, true) == 0 && degree(*it, false) > 0);
        if let Some(sink) = sink {
            last.push(open.remove(sink));
            continue;
        }
        let surplus = |it: &usize| match degree(*it, false) {
            0 => i64::MAX,
            into => degree(*it, true) - into,
        };
        let best = open.iter().map(surplus).max();
        let Some(index) = open.iter().position(|it| Some(surplus(it)) == best) else {
            break;
        };
        first.push(open.remove(index));
    }
    last.reverse();
    let order = first.into_iter().chain(last).chain(right.iter().copied());
    let mut rank = vec![0; count];
    for (place, at) in order.enumerate() {
        if let Some(rank) = rank.get_mut(at) {
            *rank = place;
        }
    }
    rank
}

/// Assigns each box to a layer after its predecessors, and as near to its successors as possible.
fn layers(count: usize, forward: &[(usize, usize)], left: &[usize], right: &[usize]) -> Vec<usize> {
    let mut layer = vec![0_usize; count];
    let start = usize::from(!left.is_empty());
    for (at, layer) in layer.iter_mut().enumerate() {
        *layer = if left.contains(&at) { 0 } else { start };
    }
    let get = |layer: &[usize], at: usize| layer.get(at).copied().unwrap_or(0);
    // the edges are acyclic, so this many rounds suffice
    for _ in 0..count {
        for (from, to) in forward {
            let least = get(&layer, *from) + 1;
            if let Some(layer) = layer.get_mut(*to) {
                *layer = least.max(*layer);
            }
        }
    }
    for _ in 0..count {
        for at in 0..count {
            let is_source = !forward.iter().any(|(_, to)| *to == at);
            let next = forward.iter().filter(|(from, _)| *from == at);
            let next = next.map(|(_, to)| get(&layer, *to)).min();
            if let (true, Some(next)) = (is_source && !left.contains(&at), next)
                && let Some(layer) = layer.get_mut(at)
            {
                *layer = next.saturating_sub(1).max(start);
            }
        }
    }
    let last = layer.iter().copied().max().unwrap_or(0);
    let inner = (0..count).filter(|at| !right.contains(at));
    let last_inner = inner.map(|at| get(&layer, at)).max().unwrap_or(0);
    for at in right {
        if let Some(layer) = layer.get_mut(*at) {
            *layer = last.max(last_inner + 1);
        }
    }
    layer
}
