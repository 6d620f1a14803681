//! The two ends of a connection: typed, bounded.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crossbeam_queue::ArrayQueue;

use crate::store::Store;
use crate::unsync::Unsync;
use crate::{BufferKind, Pool, ring, triple};

/// Outcome of sending a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PushOutcome {
    /// Stored for the reader.
    Stored,
    /// The new one did not fit.
    DroppedNewest,
    /// Stored; an older sample was dropped for it.
    DroppedOldest,
}

/// Writing end of a connection.
pub struct Sender<T>(SenderKind<T>);

enum SenderKind<T> {
    Newest(triple::TripleWriter<T>),
    Buffer(ring::RingWriter<T>),
    Shared(SharedBuffer<T>),
}

/// Reading end of a connection.
pub struct Receiver<T>(ReceiverKind<T>);

enum ReceiverKind<T> {
    Newest(triple::TripleReader<T>),
    Buffer(ring::RingReader<T>),
    Shared(SharedBuffer<T>),
}

/// A queue that several ends share.
pub(crate) enum SharedBuffer<T> {
    Newest(Arc<ArrayQueue<T>>),
    Buffer(Arc<ArrayQueue<T>>),
    Circular(Arc<ArrayQueue<T>>),
    Locked(Arc<Mutex<Store<T>>>),
    Unsync(Unsync<Store<T>>),
}

/// A connection of one writer and one reader, lock-free.
pub fn channel<T>(kind: BufferKind) -> (Sender<T>, Receiver<T>) {
    match kind {
        BufferKind::Data => {
            let (writer, reader) = triple::triple();
            (
                Sender(SenderKind::Newest(writer)),
                Receiver(ReceiverKind::Newest(reader)),
            )
        }
        BufferKind::Buffer(size) => {
            let (writer, reader) = ring::ring(size);
            (
                Sender(SenderKind::Buffer(writer)),
                Receiver(ReceiverKind::Buffer(reader)),
            )
        }
        // The writer, too, takes from the front.
        BufferKind::Circular(_) => {
            let pool = Pool::lock_free(kind);
            (pool.sender(), pool.receiver())
        }
    }
}

impl<T> Sender<T> {
    pub(crate) fn shared(shared: SharedBuffer<T>) -> Self {
        Self(SenderKind::Shared(shared))
    }

    /// Sends a sample; never blocks, except on a locked pool.
    #[inline(always)]
    pub fn send(&mut self, sample: T) -> PushOutcome {
        match &mut self.0 {
            SenderKind::Newest(writer) => {
                writer.write(sample);
                PushOutcome::Stored
            }
            SenderKind::Buffer(writer) => match writer.push(sample) {
                true => PushOutcome::Stored,
                false => PushOutcome::DroppedNewest,
            },
            SenderKind::Shared(shared) => shared.push(sample),
        }
    }
}

impl<T> Receiver<T> {
    pub(crate) fn shared(shared: SharedBuffer<T>) -> Self {
        Self(ReceiverKind::Shared(shared))
    }

    /// Takes the oldest sample, or the newest one of a data connection.
    #[inline(always)]
    pub fn take(&mut self) -> Option<T> {
        match &mut self.0 {
            ReceiverKind::Newest(reader) => reader.take(),
            ReceiverKind::Buffer(reader) => reader.pop(),
            ReceiverKind::Shared(shared) => shared.pop(),
        }
    }

    /// Returns whether every other end is gone.
    pub fn is_abandoned(&self) -> bool {
        match &self.0 {
            ReceiverKind::Newest(reader) => reader.is_abandoned(),
            ReceiverKind::Buffer(reader) => reader.is_abandoned(),
            ReceiverKind::Shared(shared) => shared.is_last(),
        }
    }

    /// Upper bound of the number of samples that can be taken now.
    fn len(&mut self) -> usize {
        match &mut self.0 {
            ReceiverKind::Newest(_) => 1,
            ReceiverKind::Buffer(reader) => reader.len(),
            ReceiverKind::Shared(shared) => shared.len(),
        }
    }

    /// Hands over what is there now; a writer faster than the reader cannot keep it here for ever.
    pub fn drain(&mut self, mut give: impl FnMut(T)) {
        for _ in 0..self.len() {
            let Some(sample) = self.take() else { return };
            give(sample);
        }
    }
}

impl<T> Receiver<T> {
    /// Shows what waits, in order, and leaves it there: for looking at a connection whose ends are at rest.
    ///
    /// A value that is sent meanwhile is not lost, but one of a queue that several have in common may be overtaken.
    pub fn look(&mut self, mut see: impl FnMut(&T)) {
        match &mut self.0 {
            ReceiverKind::Newest(reader) => reader.look(see),
            ReceiverKind::Buffer(reader) => reader.look(see),
            // a full turn of the queue
            ReceiverKind::Shared(shared) => {
                for _ in 0..shared.len() {
                    let Some(sample) = shared.pop() else { return };
                    see(&sample);
                    shared.push(sample);
                }
            }
        }
    }
}

impl<T> SharedBuffer<T> {
    fn push(&self, sample: T) -> PushOutcome {
        match self {
            Self::Newest(queue) => {
                queue.force_push(sample);
                PushOutcome::Stored
            }
            Self::Buffer(queue) => match queue.push(sample) {
                Ok(()) => PushOutcome::Stored,
                Err(_) => PushOutcome::DroppedNewest,
            },
            Self::Circular(queue) => match queue.force_push(sample) {
                None => PushOutcome::Stored,
                Some(_) => PushOutcome::DroppedOldest,
            },
            // The displaced sample is dropped after the lock is released, since its destructor may be slow.
            Self::Locked(store) => {
                let (delivery, gone) = locked(store).push(sample);
                drop(gone);
                delivery
            }
            Self::Unsync(store) => {
                let (delivery, gone) = store.with(|store| store.push(sample));
                drop(gone);
                delivery
            }
        }
    }

    fn pop(&self) -> Option<T> {
        match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => queue.pop(),
            Self::Locked(store) => locked(store).pop(),
            Self::Unsync(store) => store.with(Store::pop),
        }
    }

    fn is_last(&self) -> bool {
        let shares = match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => {
                Arc::strong_count(queue)
            }
            Self::Locked(store) => Arc::strong_count(store),
            Self::Unsync(store) => store.shares(),
        };
        shares == 1
    }

    fn len(&self) -> usize {
        match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => queue.len(),
            Self::Locked(store) => locked(store).len(),
            Self::Unsync(store) => store.with(|store| store.len()),
        }
    }
}

impl<T> Clone for SharedBuffer<T> {
    fn clone(&self) -> Self {
        match self {
            Self::Newest(queue) => Self::Newest(Arc::clone(queue)),
            Self::Buffer(queue) => Self::Buffer(Arc::clone(queue)),
            Self::Circular(queue) => Self::Circular(Arc::clone(queue)),
            Self::Locked(store) => Self::Locked(Arc::clone(store)),
            Self::Unsync(store) => Self::Unsync(store.clone()),
        }
    }
}

/// Locks the store. A poisoned lock is safe to use: every change leaves the queue consistent.
fn locked<T>(store: &Mutex<Store<T>>) -> MutexGuard<'_, Store<T>> {
    store.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use super::*;

    /// All implementations for a kind of buffer, each with one writer and one reader.
    fn every_way(kind: BufferKind) -> [(Sender<u64>, Receiver<u64>); 4] {
        let ends = |pool: Pool<u64>| (pool.sender(), pool.receiver());
        [
            channel(kind),
            ends(Pool::lock_free(kind)),
            ends(Pool::locked(kind)),
            ends(crate::unsync::tests::in_this_thread(kind)),
        ]
    }

    fn send_and_drain(kind: BufferKind, count: u64, kept: &[u64], dropped: usize) {
        for (mut sender, mut receiver) in every_way(kind) {
            let deliveries = (0..count).map(|n| sender.send(n));
            let lost = deliveries.filter(|delivery| *delivery != PushOutcome::Stored);
            assert_eq!(lost.count(), dropped, "{kind:?}");
            let mut got = Vec::new();
            receiver.drain(|sample| got.push(sample));
            assert_eq!(got, kept, "{kind:?}");
            assert_eq!(receiver.take(), None, "{kind:?}");
        }
    }

    #[test]
    fn what_was_looked_at_is_still_there() {
        for kind in [
            BufferKind::Data,
            BufferKind::Buffer(3),
            BufferKind::Circular(3),
        ] {
            for (mut sender, mut receiver) in every_way(kind) {
                for n in 0..4 {
                    sender.send(n);
                }
                let mut seen = Vec::new();
                receiver.look(|sample| seen.push(*sample));
                let mut got = Vec::new();
                receiver.drain(|sample| got.push(sample));
                assert_eq!((seen.len(), seen), (kind.size(), got), "{kind:?}");
            }
        }
    }

    #[test]
    fn o6_a_buffer_keeps_the_oldest() {
        send_and_drain(BufferKind::Buffer(3), 5, &[0, 1, 2], 2);
    }

    #[test]
    fn o6_a_circular_buffer_keeps_the_newest() {
        send_and_drain(BufferKind::Circular(3), 5, &[2, 3, 4], 2);
    }

    #[test]
    fn o5_data_keeps_the_last_and_counts_nothing_lost() {
        send_and_drain(BufferKind::Data, 5, &[4], 0);
    }

    #[test]
    fn a_queue_of_size_zero_holds_one() {
        send_and_drain(BufferKind::Buffer(0), 2, &[0], 1);
    }

    #[test]
    fn o8_those_who_share_a_queue_share_its_size_and_each_sample_has_one_reader() {
        for pool in [
            Pool::lock_free(BufferKind::Buffer(4)),
            Pool::locked(BufferKind::Buffer(4)),
        ] {
            let (mut a, mut b) = (pool.sender(), pool.sender());
            let (mut x, mut y) = (pool.receiver(), pool.receiver());
            for n in 0..2 {
                assert_eq!(a.send(n), PushOutcome::Stored);
                assert_eq!(b.send(n + 10), PushOutcome::Stored);
            }
            assert_eq!(a.send(9), PushOutcome::DroppedNewest);
            assert_eq!([x.take(), y.take()], [Some(0), Some(10)]);
            assert_eq!([y.take(), x.take(), x.take()], [Some(1), Some(11), None]);
        }
    }
}
