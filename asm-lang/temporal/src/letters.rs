//! Nodes with the same values of some atoms.

use crate::bits::Bits;

/// The distinct values of atoms at nodes.
pub(crate) struct Letters {
    /// Letter of each node.
    of: Vec<u32>,
}

impl Letters {
    /// Splits the nodes by one atom after the other.
    pub(crate) fn new(node_count: usize, atoms: &[&Bits]) -> Self {
        let mut of = vec![0_u32; node_count];
        let mut count = 1;
        for atom in atoms {
            let mut split = vec![u32::MAX; 2 * count as usize];
            count = 0;
            for (node, letter) in of.iter_mut().enumerate() {
                let slot = &mut split[2 * *letter as usize + usize::from(atom.contains(node))];
                if *slot == u32::MAX {
                    *slot = count;
                    count += 1;
                }
                *letter = *slot;
            }
        }
        Self { of }
    }

    #[inline]
    pub(crate) fn of(&self, node: u32) -> u32 {
        self.of[node as usize]
    }
}
