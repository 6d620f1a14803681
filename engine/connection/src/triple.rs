//! Triple buffer of a data connection: one writer, one reader, the newest value, wait-free.
//!
//! There are three slots: the writer fills one, the reader empties one, and the third is in the middle. Each side
//! passes on its slot by exchanging it for the middle one in a single atomic swap. (Simpson's four-slot mechanism
//! serves the same end; three slots suffice where an atomic swap exists. RTT's `DataObjectLockFree` is the model.)
#![expect(
    unsafe_code,
    reason = "the hand-over of slots between two threads; argued at each block, checked by loom"
)]

use crate::prefetch::prefetch;
use crate::sync::{Arc, AtomicU8, Ordering, UnsafeCell};

/// Bits of `middle` that contain the index of a slot.
const SLOT: u8 = 0b011;
/// Bit of `middle`: the slot contains a value that the reader has not fetched.
const FRESH: u8 = 0b100;

struct Slots<T> {
    slots: [UnsafeCell<Option<T>>; 3],
    /// Index of the slot that belongs to neither side, and the bit `FRESH`.
    middle: AtomicU8,
}

// SAFETY: a slot is accessed by one side at a time. At all times the three numbers writer.slot, reader.slot and middle
// & SLOT are a permutation of 0, 1, 2: this holds at the start, and the only changes are the atomic swaps below, which
// exchange a side's own number with the middle one. Each side accesses only the slot with its own number, and a slot's
// content passes from one side to the other through a swap with acquire and release. Values are moved between threads,
// never shared: `T: Send` suffices.
unsafe impl<T: Send> Sync for Slots<T> {}

/// Writing end of the buffer.
pub(crate) struct TripleWriter<T> {
    shared: Arc<Slots<T>>,
    slot: u8,
}

/// Reading end of the buffer.
pub(crate) struct TripleReader<T> {
    shared: Arc<Slots<T>>,
    slot: u8,
}

/// Creates an empty buffer.
pub(crate) fn triple<T>() -> (TripleWriter<T>, TripleReader<T>) {
    let shared = Arc::new(Slots {
        slots: [const { None }; 3].map(UnsafeCell::new),
        middle: AtomicU8::new(2),
    });
    let reader = TripleReader {
        shared: Arc::clone(&shared),
        slot: 1,
    };
    (TripleWriter { shared, slot: 0 }, reader)
}

impl<T> Slots<T> {
    /// Calls `f` with the content of a slot.
    ///
    /// # Safety
    /// The slot must be the caller's own; see the argument at `Sync`.
    unsafe fn with<R>(&self, slot: u8, f: impl FnOnce(&mut Option<T>) -> R) -> R {
        self.slots[usize::from(slot)].with_mut(|content| {
            // SAFETY: the caller owns the slot, so no other reference to its content exists.
            f(unsafe { &mut *content })
        })
    }
}

impl<T> TripleWriter<T> {
    /// Prefetches the slots.
    pub(crate) fn prefetch(&self) {
        prefetch(&*self.shared);
    }

    /// Publishes a value. Returns whether it replaced a value that was never read.
    pub(crate) fn write(&mut self, value: T) -> bool {
        // SAFETY: `self.slot` is the writer's own; `&mut self` excludes other writers
        unsafe {
            self.shared
                .with(self.slot, |content| *content = Some(value))
        };
        let previous = self.shared.middle.swap(self.slot | FRESH, Ordering::AcqRel);
        self.slot = previous & SLOT;
        previous & FRESH != 0
    }
}

impl<T> TripleReader<T> {
    /// Prefetches the slots.
    pub(crate) fn prefetch(&self) {
        prefetch(&*self.shared);
    }

    /// Returns whether the writer has been dropped.
    pub(crate) fn is_abandoned(&self) -> bool {
        Arc::strong_count(&self.shared) == 1
    }

    /// Passes the newest value to `f` without consuming it, unless it has been consumed before. A value published
    /// concurrently is kept instead.
    pub(crate) fn peek_each(&mut self, mut f: impl FnMut(&T)) {
        let Some(value) = self.take() else {
            return;
        };
        f(&value);
        // SAFETY: `self.slot` belongs to the reader, and `&mut self` excludes other readers.
        unsafe {
            self.shared
                .with(self.slot, |content| *content = Some(value))
        };
        let middle = self.shared.middle.load(Ordering::Relaxed);
        let given_back = middle & FRESH == 0
            && self
                .shared
                .middle
                .compare_exchange(
                    middle,
                    self.slot | FRESH,
                    Ordering::AcqRel,
                    Ordering::Relaxed,
                )
                .is_ok();
        if given_back {
            // An exchange like the writer's: the three slot indices remain a permutation.
            self.slot = middle & SLOT;
        } else {
            // SAFETY: as above. A newer value has been published, so this one is dropped.
            unsafe { self.shared.with(self.slot, |content| *content = None) };
        }
    }

    /// Removes and returns the newest value, unless it was taken before.
    pub(crate) fn take(&mut self) -> Option<T> {
        // only the writer sets FRESH; a stale value here is equivalent to a call a moment earlier
        if self.shared.middle.load(Ordering::Relaxed) & FRESH == 0 {
            return None;
        }
        let previous = self.shared.middle.swap(self.slot, Ordering::AcqRel);
        self.slot = previous & SLOT;
        // SAFETY: `self.slot` is the reader's own; `&mut self` excludes other readers
        unsafe { self.shared.with(self.slot, Option::take) }
    }
}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use super::*;

    #[test]
    fn o5_a_value_is_read_once_and_the_newest_wins() {
        let (mut writer, mut reader) = triple();
        assert_eq!(reader.take(), None);
        assert!(!writer.write(1));
        assert!(writer.write(2), "1 was never read");
        assert_eq!(reader.take(), Some(2));
        assert_eq!(reader.take(), None);
        assert!(!writer.write(3));
        assert_eq!(reader.take(), Some(3));
    }

    #[test]
    fn a_value_that_was_looked_at_is_still_there() {
        let (mut writer, mut reader) = triple();
        reader.peek_each(|_: &i32| unreachable!());
        writer.write(1);
        for _ in 0..3 {
            let mut seen = None;
            reader.peek_each(|value| seen = Some(*value));
            assert_eq!(seen, Some(1));
        }
        writer.write(2);
        assert_eq!((reader.take(), reader.take()), (Some(2), None));
    }

    /// All sequences of eight writes, looks and takes, so that each slot has been in each of the three places.
    #[test]
    fn every_sequence_of_writes_looks_and_takes_shows_the_newest_value() {
        for sequence in 0..3_u32.pow(8) {
            let (mut writer, mut reader) = triple();
            let mut unread = None;
            for step in 0..8 {
                match sequence / 3_u32.pow(step) % 3 {
                    0 => assert_eq!(writer.write(step), unread.replace(step).is_some()),
                    1 => assert_eq!(reader.take(), unread.take()),
                    _ => {
                        let mut seen = None;
                        reader.peek_each(|value| seen = Some(*value));
                        assert_eq!(seen, unread);
                    }
                }
            }
        }
    }

    #[test]
    fn o9_a_writer_never_waits_for_a_reader_at_work() {
        let (mut writer, mut reader) = triple();
        writer.write(0);
        let (begin, begun) = std::sync::mpsc::channel();
        let (end, ended) = std::sync::mpsc::channel();
        let writing = std::thread::spawn(move || {
            begun.recv().unwrap();
            for n in 1..1000 {
                writer.write(n);
            }
            end.send(()).unwrap();
        });
        let mut during = None;
        reader.peek_each(|_| {
            begin.send(()).unwrap();
            // a lock held by the reader would make the writer wait until this closure returns
            let limit = std::time::Duration::from_secs(20);
            during = Some(ended.recv_timeout(limit));
        });
        assert_eq!(during, Some(Ok(())), "the writer waits for the reader");
        writing.join().unwrap();
        assert_eq!(reader.take(), Some(999));
    }

    #[test]
    fn what_is_left_inside_is_dropped_with_it() {
        let value = std::sync::Arc::new(());
        let (mut writer, reader) = triple();
        writer.write(value.clone());
        writer.write(value.clone());
        drop((writer, reader));
        assert_eq!(std::sync::Arc::strong_count(&value), 1);
    }
}

#[cfg(all(test, feature = "loom"))]
mod exhaustively {
    use super::*;

    /// All interleavings of a look and two writes.
    #[test]
    fn no_interleaving_loses_the_newest_value_to_a_look() {
        loom::model(|| {
            let (mut writer, mut reader) = triple();
            writer.write([1, 1]);
            let writing = loom::thread::spawn(move || {
                writer.write([2, 2]);
                writer.write([3, 3]);
            });
            reader.peek_each(|[a, b]| assert_eq!(a, b, "torn"));
            assert!(writing.join().is_ok());
            assert_eq!(reader.take(), Some([3, 3]));
        });
    }

    /// Tries every interleaving of two writes and three reads.
    #[test]
    fn o5_no_interleaving_tears_repeats_or_goes_back() {
        loom::model(|| {
            let (mut writer, mut reader) = triple();
            let writing = loom::thread::spawn(move || {
                writer.write([1, 1]);
                writer.write([2, 2]);
            });
            let mut newest = 0;
            for _ in 0..3 {
                if let Some([a, b]) = reader.take() {
                    assert_eq!(a, b, "torn");
                    assert!(a > newest, "repeated, or went back");
                    newest = a;
                }
            }
            assert!(writing.join().is_ok());
            if let Some([a, _]) = reader.take() {
                assert!(a > newest);
                newest = a;
            }
            assert_eq!(newest, 2, "the last value arrives");
        });
    }
}
