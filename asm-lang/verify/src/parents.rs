//! The predecessor of each node on a shortest path, in about two bits a node.
//!
//! Nodes are found in the order in which their parents are explored, so that the numbers of the parents never decrease. A sequence of
//! numbers that never decrease is a sequence of bits (Elias and Fano): for each number in turn, as many zeros as it exceeds the number
//! before, then a one. The number with index `i` is the number of zeros before the one with index `i`.

/// Number of ones between two sampled positions.
const SAMPLED: u32 = 512;

/// The parents of nodes, numbered in the order in which they were added.
#[derive(Debug, Default)]
pub(crate) struct Parents {
    bits: Vec<u64>,
    /// Position of every 512th one.
    samples: Vec<u64>,
    len: u32,
    /// The last number: that of the parent and 1, or 0 for an initial node.
    last: u32,
}

impl Parents {
    /// Adds the parent of the next node, which is not less than the one before; `None` for an initial node.
    pub fn push(&mut self, parent: Option<u32>) {
        let number = parent.map_or(0, |parent| parent.saturating_add(1));
        debug_assert!(number >= self.last, "parents are explored in order");
        // without the assertion, a wrong parent is better than a broken sequence
        self.last = self.last.max(number);
        let at = u64::from(self.last) + u64::from(self.len);
        if self.len.is_multiple_of(SAMPLED) {
            self.samples.push(at);
        }
        let word = (at / 64) as usize;
        if word >= self.bits.len() {
            self.bits.resize(word + 1, 0);
        }
        if let Some(bits) = self.bits.get_mut(word) {
            *bits |= 1 << (at % 64);
        }
        self.len += 1;
    }

    /// Returns the parent of a node; `None` for an initial or unknown one.
    pub fn get(&self, node: u32) -> Option<u32> {
        if node >= self.len {
            return None;
        }
        let start = *self.samples.get((node / SAMPLED) as usize)?;
        let mut word = (start / 64) as usize;
        let mut bits = self.bits.get(word)? & u64::MAX << (start % 64);
        let mut skipped = node % SAMPLED;
        while skipped >= bits.count_ones() {
            skipped -= bits.count_ones();
            word += 1;
            bits = *self.bits.get(word)?;
        }
        for _ in 0..skipped {
            bits &= bits - 1;
        }
        let at = word as u64 * 64 + u64::from(bits.trailing_zeros());
        let number = u32::try_from(at - u64::from(node)).ok()?;
        number.checked_sub(1)
    }

    /// Returns the memory in use, in bytes.
    pub fn memory(&self) -> usize {
        (self.bits.len() + self.samples.len()) * 8
    }
}

#[cfg(test)]
mod tests {
    use super::Parents;

    #[test]
    fn it_returns_what_was_added() {
        let mut parents = Parents::default();
        let mut expected = vec![None, None, None];
        let mut parent = 0u32;
        let mut random = 0x9e37_79b9_u64;
        for _ in 0..20_000 {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            // many children of one node, and long gaps
            parent += match random >> 60 {
                0 => (random >> 40 & 0x3ff) as u32,
                1..=5 => 1,
                _ => 0,
            };
            expected.push(Some(parent));
        }
        expected.iter().for_each(|it| parents.push(*it));
        let found: Vec<Option<u32>> = (0..expected.len() as u32)
            .map(|it| parents.get(it))
            .collect();
        assert_eq!(found, expected);
        assert_eq!(parents.get(expected.len() as u32), None);
        assert_eq!(Parents::default().get(0), None);
    }

    #[test]
    fn it_takes_two_bits_a_node() {
        let mut parents = Parents::default();
        parents.push(None);
        (0..100_000).for_each(|node| parents.push(Some(node)));
        assert!(
            parents.memory() < 100_000 * 3 / 8,
            "{} bytes",
            parents.memory()
        );
    }
}
