//! A bounded sequence of numbered entries, which readers follow with cursors of their own.

use std::collections::VecDeque;

/// The newest entries of a sequence. A reader that is too slow misses the oldest ones, and learns how many.
pub(crate) struct Ring<T> {
    entries: VecDeque<T>,
    capacity: usize,
    /// Number of entries so far.
    count: u64,
}

/// What a reader receives.
pub(crate) struct RingReading<'r, T> {
    /// Entries since the cursor that are still there.
    pub entries: std::collections::vec_deque::Iter<'r, T>,
    /// Number of entries since the cursor that are not.
    pub missed: u64,
    /// The next cursor.
    pub next: u64,
}

impl<T> Ring<T> {
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            entries: VecDeque::new(),
            capacity,
            count: 0,
        }
    }

    pub(crate) fn push(&mut self, entry: T) {
        if self.entries.len() == self.capacity {
            self.entries.pop_front();
        }
        self.entries.push_back(entry);
        self.count += 1;
    }

    /// Number of entries so far, which is the cursor of a reader that has seen all of them.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// The cursor of a reader that has not seen the newest entries, at most this many.
    pub(crate) fn cursor_before(&self, newest: usize) -> u64 {
        self.count - self.entries.len().min(newest) as u64
    }

    /// The entries since a cursor.
    pub(crate) fn since(&self, cursor: u64) -> RingReading<'_, T> {
        let oldest = self.count - self.entries.len() as u64;
        let from = cursor.clamp(oldest, self.count);
        let skipped = usize::try_from(from - oldest).unwrap_or(usize::MAX);
        RingReading {
            entries: self.entries.range(skipped.min(self.entries.len())..),
            missed: from.saturating_sub(cursor),
            next: self.count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Ring;

    #[test]
    fn a_slow_reader_learns_how_many_entries_it_missed() {
        let mut ring = Ring::new(3);
        (1..=5).for_each(|number| ring.push(number));
        let reading = ring.since(1);
        assert_eq!(reading.entries.copied().collect::<Vec<_>>(), [3, 4, 5]);
        assert_eq!((reading.missed, reading.next), (1, 5));
        let reading = ring.since(4);
        assert_eq!(reading.entries.copied().collect::<Vec<_>>(), [5]);
        assert_eq!((reading.missed, ring.since(5).entries.len()), (0, 0));
        assert_eq!((ring.cursor_before(2), ring.cursor_before(9)), (3, 2));
    }
}
