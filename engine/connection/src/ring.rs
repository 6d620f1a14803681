//! Ring buffer of a buffer connection: one writer, one reader, in order, wait-free.
//!
//! Both ends count their operations since the beginning; the low bits of a value's number are the index of its slot.
//! Each end caches the other's counter, and reads it again only when the cached value does not suffice.
//!
//! Most readers are fast enough that few values ever wait, and a system can have thousands of queues. A ring therefore begins with
//! [`FEW`] slots. When these are full, the writer continues in the slots for all values, from the value with the number `switch`
//! on, and remains there. [`RingReader::reserve`] allocates them in advance, for writers that must not allocate.
#![expect(
    unsafe_code,
    reason = "the hand-over of slots between two threads; argued at each block, checked by loom"
)]

use std::mem::MaybeUninit;
use std::sync::OnceLock;

#[cfg(not(feature = "loom"))]
use crate::gauge::{QueueGauge, QueueLength};
use crate::prefetch::prefetch;
use crate::sync::{Arc, AtomicUsize, Ordering, UnsafeCell};

/// Occupies cache lines of its own, so that the two ends do not slow each other.
#[repr(align(128))]
struct Padded<T>(T);

/// Number of slots that a ring begins with.
const FEW: usize = 4;

type RingSlot<T> = UnsafeCell<MaybeUninit<T>>;

struct Ring<T> {
    /// The slots of the values below `switch`. Their number is a power of two.
    few: Box<[RingSlot<T>]>,
    /// The slots of the other values, as many as the ring has room for, rounded up to a power of two.
    all: OnceLock<Box<[RingSlot<T>]>>,
    /// Number of the first value in `all`; `usize::MAX` until there is one. Stored by the writer before the `write_index` that
    /// passes this value on. A reader that takes a value with a lower number may see either content: both say `few`.
    switch: AtomicUsize,
    /// Capacity in values.
    size: usize,
    /// Number of values written since the beginning; stored by the writer.
    write_index: Padded<AtomicUsize>,
    /// Number of values taken since the beginning; stored by the reader.
    read_index: Padded<AtomicUsize>,
}

// SAFETY: a slot is reached by one end at a time. The writer accesses the slot of `write_index` only while fewer values are in
// the ring than its list has slots, so the reader has taken the slot's previous value: in `few` it compares with the number of
// these slots, and values in `all` have higher numbers than those still in `few`, at most `size` of them. It passes the slot to
// the reader by a release store of `write_index`, which also publishes `switch`, so both ends agree on the list of each value.
// The reader accesses the slot of `read_index` only after an acquire load has shown that `write_index` is beyond it, and returns
// it by a release store of `read_index`, which the writer loads with acquire before it writes there again. Values are moved
// between threads, never shared: `T: Send` suffices.
unsafe impl<T: Send> Sync for Ring<T> {}
// SAFETY: as above; the ring owns its values.
unsafe impl<T: Send> Send for Ring<T> {}

/// Writing end of the ring.
pub(crate) struct RingWriter<T> {
    ring: Arc<Ring<T>>,
    write_index: usize,
    /// Lower bound of the values taken: the last number read from the reader.
    read_index: usize,
    /// Number of values that have room in the slots in use.
    room: usize,
}

/// Reading end of the ring.
pub(crate) struct RingReader<T> {
    ring: Arc<Ring<T>>,
    read_index: usize,
    /// Lower bound of the values written: the last number read from the writer.
    write_index: usize,
}

/// Creates an empty ring for `size` values.
pub(crate) fn ring<T>(size: usize) -> (RingWriter<T>, RingReader<T>) {
    let size = size.max(1);
    let ring = Arc::new(Ring {
        few: slots(size.min(FEW)),
        all: OnceLock::new(),
        switch: AtomicUsize::new(usize::MAX),
        size,
        write_index: Padded(AtomicUsize::new(0)),
        read_index: Padded(AtomicUsize::new(0)),
    });
    let reader = RingReader {
        ring: Arc::clone(&ring),
        read_index: 0,
        write_index: 0,
    };
    let writer = RingWriter {
        room: size.min(FEW),
        ring,
        write_index: 0,
        read_index: 0,
    };
    (writer, reader)
}

/// Creates slots for so many values, rounded up to a power of two.
fn slots<T>(size: usize) -> Box<[RingSlot<T>]> {
    let slots = (0..size.next_power_of_two()).map(|_| UnsafeCell::new(MaybeUninit::uninit()));
    slots.collect()
}

impl<T> Ring<T> {
    /// The slot of a value that the writer is about to write, or has passed on.
    #[inline(always)]
    fn slot(&self, number: usize) -> &RingSlot<T> {
        let mut slots: &[RingSlot<T>] = &self.few;
        // a ring is used for less than 2⁶⁴ values
        if number >= self.switch.load(Ordering::Relaxed) {
            slots = self.all_slots();
        }
        let mask = slots.len() - 1;
        // SAFETY: the number of slots is a power of two, so one less is a mask, and what it lets through is less.
        unsafe { slots.get_unchecked(number & mask) }
    }

    /// The slots for all values, which are allocated if need be.
    #[inline]
    fn all_slots(&self) -> &[RingSlot<T>] {
        self.all.get_or_init(|| slots(self.size))
    }
}

impl<T> RingWriter<T> {
    /// Prefetches the indices.
    pub(crate) fn prefetch(&self) {
        prefetch(&*self.ring);
    }

    /// Appends a value if there is room. Returns whether there was.
    #[inline(always)]
    pub(crate) fn push(&mut self, value: T) -> bool {
        let ring = &*self.ring;
        if self.write_index.wrapping_sub(self.read_index) >= self.room {
            self.read_index = ring.read_index.0.load(Ordering::Acquire);
            let waiting = self.write_index.wrapping_sub(self.read_index);
            if waiting == ring.size {
                return false;
            }
            if waiting >= self.room {
                self.grow();
            }
        }
        let ring = &*self.ring;
        ring.slot(self.write_index).with_mut(|slot| {
            // SAFETY: there is room, so the slot belongs to the writer; `&mut self` excludes other writers
            unsafe { (*slot).write(value) };
        });
        self.write_index = self.write_index.wrapping_add(1);
        ring.write_index
            .0
            .store(self.write_index, Ordering::Release);
        true
    }
}

impl<T> RingWriter<T> {
    /// Continues in the slots for all values, because the first ones are full.
    #[cold]
    fn grow(&mut self) {
        self.ring.all_slots();
        self.ring.switch.store(self.write_index, Ordering::Relaxed);
        self.room = self.ring.size;
    }
}

impl<T> RingReader<T> {
    /// Allocates the memory for all values now.
    pub(crate) fn reserve(&self) {
        if self.ring.size > FEW {
            self.ring.all_slots();
        }
    }

    /// Prefetches the indices.
    pub(crate) fn prefetch(&self) {
        prefetch(&*self.ring);
    }

    /// Removes and returns the oldest value.
    #[inline(always)]
    pub(crate) fn pop(&mut self) -> Option<T> {
        let ring = &*self.ring;
        if self.read_index == self.write_index {
            self.write_index = ring.write_index.0.load(Ordering::Acquire);
            if self.read_index == self.write_index {
                return None;
            }
        }
        let slot = ring.slot(self.read_index);
        self.read_index = self.read_index.wrapping_add(1);
        slot.with(|slot| {
            // SAFETY: the value has been written and not taken, so the slot belongs to the reader and is initialised.
            // It is moved out once, because `read_index` is incremented before; `&mut self` excludes other readers.
            let value = Some(unsafe { (*slot).assume_init_read() });
            ring.read_index.0.store(self.read_index, Ordering::Release);
            value
        })
    }

    /// Passes every unread value to `f` without consuming it.
    pub(crate) fn peek_each(&mut self, mut f: impl FnMut(&T)) {
        for ahead in 0..self.len() {
            let slot = self.ring.slot(self.read_index.wrapping_add(ahead));
            slot.with(|slot| {
                // SAFETY: the slot has been written and not been consumed, so it belongs to the reader and is
                // initialised; the writer cannot reuse it before `read_index` grows, which requires `&mut self`.
                f(unsafe { (*slot).assume_init_ref() });
            });
        }
    }

    /// Tells other threads how many values wait.
    #[cfg(not(feature = "loom"))]
    pub(crate) fn gauge(&self) -> QueueGauge
    where
        T: Send + 'static,
    {
        QueueGauge::new(&self.ring)
    }

    /// Returns whether the writer has been dropped.
    pub(crate) fn is_abandoned(&self) -> bool {
        Arc::strong_count(&self.ring) == 1
    }

    /// Returns the number of values that can be taken now.
    pub(crate) fn len(&mut self) -> usize {
        self.write_index = self.ring.write_index.0.load(Ordering::Acquire);
        self.write_index.wrapping_sub(self.read_index)
    }
}

#[cfg(not(feature = "loom"))]
impl<T: Send> QueueLength for Ring<T> {
    fn length(&self) -> usize {
        // in this order: what is taken has been written before
        let read = self.read_index.0.load(Ordering::Acquire);
        let written = self.write_index.0.load(Ordering::Acquire);
        written.wrapping_sub(read).min(self.size)
    }
}

impl<T> Drop for Ring<T> {
    fn drop(&mut self) {
        let written = self.write_index.0.load(Ordering::Relaxed);
        let mut number = self.read_index.0.load(Ordering::Relaxed);
        while number != written {
            self.slot(number).with_mut(|slot| {
                // SAFETY: both ends have been dropped, and the values written and not taken are still initialised
                unsafe { (*slot).assume_init_drop() };
            });
            number = number.wrapping_add(1);
        }
    }
}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use super::*;

    #[test]
    fn o6_values_come_in_their_order_and_what_has_no_room_is_refused() {
        let (mut writer, mut reader) = ring(3);
        for n in 0..3 {
            assert!(writer.push(n));
        }
        assert!(!writer.push(3), "three, though four slots are there");
        assert_eq!((reader.len(), reader.pop()), (3, Some(0)));
        assert!(writer.push(4));
        let rest: Vec<_> = std::iter::from_fn(|| reader.pop()).collect();
        assert_eq!(rest, [1, 2, 4]);
    }

    #[test]
    fn a_ring_grows_once_and_keeps_the_order() {
        for size in [1, 2, 3, 4, 5, 7, 8, 64] {
            for reserves in [false, true] {
                let (mut writer, mut reader) = ring(size);
                if reserves {
                    reader.reserve();
                }
                let (mut next, mut expected) = (0, 0);
                // as many values wait as the round says, and all that have no room are refused
                for round in (0..=size + 1).chain((0..size).rev()).chain([size; 3]) {
                    let pushed = (0..round).filter(|_| {
                        let has_room = writer.push(next);
                        next += usize::from(has_room);
                        has_room
                    });
                    assert_eq!(pushed.count(), round.min(size));
                    for _ in 0..round.min(size) {
                        assert_eq!(reader.pop(), Some(expected));
                        expected += 1;
                    }
                    assert_eq!(reader.pop(), None);
                }
            }
        }
    }

    #[test]
    fn values_that_wait_in_few_and_in_all_slots_come_in_order() {
        let (mut writer, mut reader) = ring(16);
        for n in 0..3 {
            assert!(writer.push(n));
        }
        assert_eq!([reader.pop(), reader.pop()], [Some(0), Some(1)]);
        // the one that waits is in the few slots, as are the next three
        for n in 3..18 {
            assert!(writer.push(n));
        }
        assert!(!writer.push(18));
        let mut seen = Vec::new();
        reader.peek_each(|n| seen.push(*n));
        let rest: Vec<_> = std::iter::from_fn(|| reader.pop()).collect();
        assert_eq!((seen, rest), ((2..18).collect(), (2..18).collect()));
    }

    #[test]
    fn what_nobody_takes_is_dropped_with_the_ring() {
        let value = std::sync::Arc::new(());
        for waiting in [3, 9] {
            let (mut writer, mut reader) = ring(2 * FEW + 1);
            for _ in 0..waiting {
                assert!(writer.push(std::sync::Arc::clone(&value)));
            }
            drop(reader.pop());
            drop((writer, reader));
            assert_eq!(std::sync::Arc::strong_count(&value), 1);
        }
    }
}

#[cfg(all(test, feature = "loom"))]
mod exhaustively {
    use super::*;

    /// Tries every interleaving of writes that make the ring grow and reads.
    #[test]
    fn no_interleaving_loses_values_or_turns_them_around_while_the_ring_grows() {
        loom::model(|| {
            let (mut writer, mut reader) = ring(FEW + 2);
            for n in 1..=FEW - 1 {
                assert!(writer.push(Box::new(n)));
            }
            let writing = loom::thread::spawn(move || {
                assert!(writer.push(Box::new(FEW)));
                assert!(writer.push(Box::new(FEW + 1)));
            });
            let mut seen = Vec::new();
            seen.extend(reader.pop());
            seen.extend(reader.pop());
            assert!(writing.join().is_ok());
            seen.extend(std::iter::from_fn(|| reader.pop()));
            let seen: Vec<usize> = seen.into_iter().map(|it| *it).collect();
            assert_eq!(seen, (1..=FEW + 1).collect::<Vec<_>>());
        });
    }

    /// Tries every interleaving of three writes into two slots and as many reads.
    #[test]
    fn o6_no_interleaving_tears_loses_repeats_or_turns_values_around() {
        loom::model(|| {
            let (mut writer, mut reader) = ring(2);
            let writing = loom::thread::spawn(move || {
                let sent = (1..=3_usize).filter(|n| writer.push(Box::new([*n; 2])));
                sent.collect::<Vec<_>>()
            });
            let mut seen = Vec::new();
            let mut look = |reader: &mut RingReader<Box<[usize; 2]>>| {
                if let Some(value) = reader.pop() {
                    assert_eq!(value[0], value[1], "torn");
                    seen.push(value[0]);
                }
            };
            look(&mut reader);
            look(&mut reader);
            let sent = writing.join().unwrap_or_default();
            for _ in 0..3 {
                look(&mut reader);
            }
            assert_eq!(seen, sent);
        });
    }
}
