//! Directed graphs: cycles, and the arrows that have to be reversed to remove them.

use std::collections::{BTreeMap, BTreeSet};

/// An arrow from the first node to the second.
pub type Arrow = (String, String);

/// Returns the strongly connected components with more than one node, largest first (Tarjan,
/// *Depth-first search and linear graph algorithms*, 1972).
pub fn cycles(arrows: &BTreeSet<Arrow>) -> Vec<Vec<String>> {
    let mut search = Search::new(arrows);
    for node in 0..search.names.len() {
        if search.numbers[node].is_none() {
            search.visit(node);
        }
    }
    let mut found = search.found;
    found.sort_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
    found
}

struct Search {
    names: Vec<String>,
    next: Vec<Vec<usize>>,
    numbers: Vec<Option<usize>>,
    low: Vec<usize>,
    stack: Vec<usize>,
    on_stack: Vec<bool>,
    count: usize,
    found: Vec<Vec<String>>,
}

impl Search {
    fn new(arrows: &BTreeSet<Arrow>) -> Self {
        let names: BTreeSet<&String> = arrows.iter().flat_map(|(from, to)| [from, to]).collect();
        let ids: BTreeMap<&String, usize> = names
            .iter()
            .enumerate()
            .map(|(id, name)| (*name, id))
            .collect();
        let mut next = vec![Vec::new(); names.len()];
        for (from, to) in arrows {
            next[ids[from]].push(ids[to]);
        }
        Self {
            next,
            numbers: vec![None; names.len()],
            low: vec![0; names.len()],
            stack: Vec::new(),
            on_stack: vec![false; names.len()],
            count: 0,
            found: Vec::new(),
            names: names.into_iter().cloned().collect(),
        }
    }

    fn visit(&mut self, node: usize) {
        let number = self.count;
        self.count += 1;
        self.numbers[node] = Some(number);
        self.low[node] = number;
        self.stack.push(node);
        self.on_stack[node] = true;
        for next in self.next[node].clone() {
            match self.numbers[next] {
                None => {
                    self.visit(next);
                    self.low[node] = self.low[node].min(self.low[next]);
                }
                Some(seen) if self.on_stack[next] => self.low[node] = self.low[node].min(seen),
                Some(_) => {}
            }
        }
        if self.low[node] == number {
            self.take_component(node);
        }
    }

    fn take_component(&mut self, first: usize) {
        let mut component = Vec::new();
        while let Some(node) = self.stack.pop() {
            self.on_stack[node] = false;
            component.push(self.names[node].clone());
            if node == first {
                break;
            }
        }
        if component.len() > 1 {
            component.sort();
            self.found.push(component);
        }
    }
}

/// Returns the arrows that point upwards in the best order of the nodes found by a local search.
/// There are none if and only if the graph has no cycle.
///
/// The search starts with the nodes ordered by out-degree minus in-degree, and moves single nodes
/// to the position with the fewest upward arrows until no move improves the order. The result is an
/// upper bound for the minimum feedback arc set, whose exact computation is NP-hard.
pub fn climbing(arrows: &BTreeSet<Arrow>) -> Vec<Arrow> {
    let mut climbing = Vec::new();
    for component in cycles(arrows) {
        let inside = |(from, to): &&Arrow| component.contains(from) && component.contains(to);
        let within: Vec<&Arrow> = arrows.iter().filter(inside).collect();
        let order = best_order(component.clone(), &within);
        let place: BTreeMap<&String, usize> = order
            .iter()
            .enumerate()
            .map(|(at, name)| (name, at))
            .collect();
        let up = within
            .into_iter()
            .filter(|(from, to)| place[from] > place[to]);
        climbing.extend(up.cloned());
    }
    climbing
}

fn best_order(mut order: Vec<String>, arrows: &[&Arrow]) -> Vec<String> {
    let surplus = |node: &String| {
        let out = arrows.iter().filter(|(from, _)| from == node).count() as isize;
        let into = arrows.iter().filter(|(_, to)| to == node).count() as isize;
        into - out
    };
    order.sort_by_cached_key(|node| (surplus(node), node.clone()));
    let ids: BTreeMap<String, usize> = order
        .iter()
        .cloned()
        .enumerate()
        .map(|(id, name)| (name, id))
        .collect();
    let mut uses = vec![vec![false; order.len()]; order.len()];
    for (from, to) in arrows {
        uses[ids[from]][ids[to]] = true;
    }
    let mut sequence: Vec<usize> = (0..order.len()).collect();
    while improve(&mut sequence, &uses) {}
    sequence.into_iter().map(|id| order[id].clone()).collect()
}

/// Moves each node to its best position; returns `true` if a move improved the order.
fn improve(sequence: &mut Vec<usize>, uses: &[Vec<bool>]) -> bool {
    let mut helped = false;
    for (node, used) in uses.iter().enumerate() {
        let Some(at) = sequence.iter().position(|it| *it == node) else {
            continue;
        };
        sequence.remove(at);
        // cost of each position relative to the first: passing a neighbour reverses its arrows
        let (mut cost, mut best, mut here) = (0_isize, (0_isize, 0_usize), 0_isize);
        for place in 0..=sequence.len() {
            if place == at {
                here = cost;
            }
            if cost < best.0 {
                best = (cost, place);
            }
            if let Some(passed) = sequence.get(place) {
                cost += isize::from(used[*passed]) - isize::from(uses[*passed][node]);
            }
        }
        let target = if best.0 < here { best.1 } else { at };
        helped |= best.0 < here;
        sequence.insert(target, node);
    }
    helped
}

#[cfg(test)]
mod tests {
    use super::{Arrow, climbing, cycles};
    use std::collections::BTreeSet;

    fn graph(text: &str) -> BTreeSet<Arrow> {
        let pairs = text
            .split_whitespace()
            .filter_map(|pair| pair.split_once('>'));
        pairs
            .map(|(from, to)| (from.to_owned(), to.to_owned()))
            .collect()
    }

    #[test]
    fn a_falling_graph_has_no_cycle_and_nothing_climbs() {
        let arrows = graph("a>b b>c a>c c>d");
        assert!(cycles(&arrows).is_empty());
        assert!(climbing(&arrows).is_empty());
    }

    #[test]
    fn two_cycles_are_found_largest_first() {
        let arrows = graph("a>b b>c c>a c>d d>e e>d");
        assert_eq!(cycles(&arrows), [vec!["a", "b", "c"], vec!["d", "e"]]);
        assert_eq!(climbing(&arrows).len(), 2);
    }

    #[test]
    fn one_arrow_back_from_the_bottom_is_the_one_that_climbs() {
        let arrows = graph("a>b a>c a>d b>c b>d c>d d>a");
        assert_eq!(climbing(&arrows), [("d".to_owned(), "a".to_owned())]);
    }
}
