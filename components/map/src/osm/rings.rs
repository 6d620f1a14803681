//! Builds the rings of a multipolygon: joins ways that end at the same node.

use std::collections::HashMap;

/// The rings of a multipolygon.
pub struct Rings {
    /// Rings; the first and the last node are equal.
    pub closed: Vec<Vec<i64>>,
    /// Chains that do not close, because the extract lacks a way.
    pub open: Vec<Vec<i64>>,
}

/// Joins ways, given by their nodes, to rings. The result depends only on the order of the ways.
pub fn join(ways: &[&[i64]]) -> Rings {
    let mut at: HashMap<i64, Vec<usize>> = HashMap::new();
    for (index, way) in ways.iter().enumerate() {
        for end in way.first().into_iter().chain(way.last()) {
            at.entry(*end).or_default().push(index);
        }
    }
    let mut used = vec![false; ways.len()];
    let mut rings = Rings {
        closed: Vec::new(),
        open: Vec::new(),
    };
    for index in 0..ways.len() {
        if used[index] || ways[index].is_empty() {
            continue;
        }
        used[index] = true;
        let mut ring = ways[index].to_vec();
        while let Some(next) = next(&ring, &at, &used) {
            used[next] = true;
            extend(&mut ring, ways[next]);
        }
        if ring.len() > 3 && ring.first() == ring.last() {
            rings.closed.push(ring);
        } else {
            rings.open.push(ring);
        }
    }
    rings
}

/// An unused way that continues the chain; `None` if the chain is closed or cannot be continued.
fn next(ring: &[i64], at: &HashMap<i64, Vec<usize>>, used: &[bool]) -> Option<usize> {
    let (first, last) = (ring.first()?, ring.last()?);
    if ring.len() > 1 && first == last {
        return None;
    }
    at.get(last)?.iter().copied().find(|way| !used[*way])
}

fn extend(ring: &mut Vec<i64>, way: &[i64]) {
    if ring.last() == way.first() {
        ring.extend(way.iter().skip(1));
    } else {
        ring.extend(way.iter().rev().skip(1));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_joins_ways_whichever_way_they_run() {
        let rings = join(&[&[1, 2, 3], &[5, 4, 3], &[5, 1], &[7, 8, 9, 7]]);
        assert_eq!(rings.closed, [vec![1, 2, 3, 4, 5, 1], vec![7, 8, 9, 7]]);
        assert!(rings.open.is_empty());
    }

    #[test]
    fn it_keeps_what_does_not_close() {
        let rings = join(&[&[1, 2, 3], &[3, 4], &[], &[9]]);
        assert!(rings.closed.is_empty());
        assert_eq!(rings.open, [vec![1, 2, 3, 4], vec![9]]);
    }
}
