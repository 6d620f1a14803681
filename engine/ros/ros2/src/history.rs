//! What a writer of DDS may keep for readers that have not acknowledged it.

use std::collections::VecDeque;

/// The messages of a writer since all readers had acknowledged everything.
pub(crate) struct KeptMessages {
    /// Number and length.
    messages: VecDeque<(i64, usize)>,
    bytes: usize,
    /// Messages that are kept for readers, however long they are.
    depth: usize,
    /// Most messages.
    most: usize,
    /// Most bytes of messages beyond the depth.
    most_bytes: usize,
}

/// Old messages that are given up.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Overflow {
    /// Number of the first message that is kept.
    pub(crate) before: i64,
    /// How many they are.
    pub(crate) messages: u64,
}

impl KeptMessages {
    /// Keeps `depth` messages in any case, and at most `most`, which is larger, of this length.
    pub(crate) fn new(depth: usize, most: usize, most_bytes: usize) -> Self {
        Self {
            messages: VecDeque::new(),
            bytes: 0,
            depth,
            most,
            most_bytes,
        }
    }

    pub(crate) fn push(&mut self, number: i64, length: usize) {
        self.messages.push_back((number, length));
        self.bytes += length;
    }

    /// All have acknowledged everything. Returns the number of the last message.
    pub(crate) fn clear(&mut self) -> Option<i64> {
        let last = self.messages.pop_back();
        self.messages.clear();
        self.bytes = 0;
        last.map(|(number, _)| number)
    }

    /// Returns `true` if half of the limit is reached, so that readers should be asked for acknowledgements.
    pub(crate) fn is_long(&self) -> bool {
        self.exceeds(2)
    }

    fn exceeds(&self, share: usize) -> bool {
        self.bytes > self.most_bytes / share || self.messages.len() > self.most / share
    }

    /// If more is kept than allowed, gives up the older half of it, but not the last messages of the depth.
    pub(crate) fn overflow(&mut self) -> Option<Overflow> {
        if !self.exceeds(1) {
            return None;
        }
        let mut messages = 0;
        while self.messages.len() > self.depth && self.exceeds(2) {
            let (_, length) = self.messages.pop_front()?;
            self.bytes -= length;
            messages += 1;
        }
        let &(before, _) = self.messages.front()?;
        (messages > 0).then_some(Overflow { before, messages })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_older_half_is_given_up_by_length_or_number() {
        let mut history = KeptMessages::new(2, 10, 100);
        for number in 1..=10 {
            history.push(number, 1);
            assert_eq!(history.overflow(), None);
        }
        history.push(11, 1);
        let found = history.overflow();
        assert_eq!(
            found,
            Some(Overflow {
                before: 7,
                messages: 6
            })
        );
        history.push(12, 100);
        let found = history.overflow();
        assert_eq!(
            found,
            Some(Overflow {
                before: 11,
                messages: 4
            })
        );
        // the depth is kept, whatever it takes
        history.push(13, 100);
        let found = history.overflow();
        assert_eq!(
            found,
            Some(Overflow {
                before: 12,
                messages: 1
            })
        );
        assert_eq!(history.overflow(), None);
        assert_eq!(history.clear(), Some(13));
        assert!(!history.is_long());
    }
}
