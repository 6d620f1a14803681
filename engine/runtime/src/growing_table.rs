//! A table that grows while threads read it.

use std::sync::OnceLock;

/// Number of entries in the first block; each further block is twice as large as the one before it.
const FIRST: usize = 16;
/// Number of blocks, enough for 2³¹ entries.
const BLOCKS: usize = 28;

/// Entries by position, created with their default values.
///
/// The run's owner extends the table, any thread reads it, and neither blocks: a block is published once, complete, and
/// entries are never moved or removed.
pub(crate) struct GrowingTable<T> {
    blocks: [OnceLock<Box<[T]>>; BLOCKS],
}

impl<T: Default> GrowingTable<T> {
    /// Creates a table with room for this many entries.
    pub(crate) fn with_room(entries: usize) -> Self {
        let table = Self {
            blocks: [const { OnceLock::new() }; BLOCKS],
        };
        if let Some(last) = entries.checked_sub(1) {
            table.extend_to(last);
        }
        table
    }

    /// Makes room for the entry at this position.
    pub(crate) fn extend_to(&self, position: usize) {
        let (last, _) = location(position);
        for (number, block) in self.blocks.iter().enumerate().take(last + 1) {
            let entries = || (0..FIRST << number).map(|_| T::default()).collect();
            block.get_or_init(entries);
        }
    }

    /// Returns the entry at this position; `None` beyond the end of the table.
    pub(crate) fn get(&self, position: usize) -> Option<&T> {
        let (block, offset) = location(position);
        self.blocks.get(block)?.get()?.get(offset)
    }

    /// Iterates over all entries in order of position, including those that are not used yet.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.blocks.iter().map_while(OnceLock::get).flatten()
    }
}

/// The block of a position, and the position in the block.
fn location(position: usize) -> (usize, usize) {
    let block = (position / FIRST + 1).ilog2();
    let first = FIRST * ((1 << block) - 1);
    (usize::try_from(block).unwrap_or(BLOCKS), position - first)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::GrowingTable;

    #[test]
    fn entries_keep_their_values_while_the_table_grows() {
        let table: GrowingTable<AtomicUsize> = GrowingTable::with_room(0);
        assert!(table.get(0).is_none());
        for position in 0..1000 {
            table.extend_to(position);
            let entry = table.get(position).expect("room");
            assert_eq!(entry.swap(position + 1, Ordering::Relaxed), 0);
        }
        for (entry, position) in table.iter().zip(0..1000) {
            assert_eq!(entry.load(Ordering::Relaxed), position + 1);
        }
        assert!(table.get(1 << 20).is_none());
        assert!(table.get(usize::MAX).is_none());
    }
}
