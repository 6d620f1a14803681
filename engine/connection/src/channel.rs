//! The two typed ends of a bounded connection.

use crate::buffer_kind::BufferKind;
#[cfg(not(feature = "loom"))]
use crate::gauge::QueueGauge;
use crate::push_outcome::PushOutcome;
use crate::shared_buffer::SharedBuffer;
use crate::sync::{Ordering, fence};
use crate::{ring, triple};

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

/// Creates a lock-free connection of one writer and one reader.
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
        // not a ring: the writer also removes samples from the front
        BufferKind::Circular(_) => {
            let queue = SharedBuffer::reservable(kind);
            (Sender::shared(queue.clone()), Receiver::shared(queue))
        }
    }
}

impl<T> Sender<T> {
    pub(crate) fn shared(shared: SharedBuffer<T>) -> Self {
        Self(SenderKind::Shared(shared))
    }

    /// Prefetches what the next sample needs, as far as the end knows where it is.
    pub fn prefetch(&self) {
        match &self.0 {
            SenderKind::Newest(writer) => writer.prefetch(),
            SenderKind::Buffer(writer) => writer.prefetch(),
            SenderKind::Shared(_) => {}
        }
    }

    /// Sends a sample; never blocks, except on a locked pool.
    #[inline(always)]
    pub fn send(&mut self, sample: T) -> PushOutcome {
        match &mut self.0 {
            SenderKind::Newest(writer) => {
                writer.write(sample);
                PushOutcome::Stored
            }
            SenderKind::Buffer(writer) => {
                if writer.push(sample) {
                    PushOutcome::Stored
                } else {
                    PushOutcome::DroppedNewest
                }
            }
            SenderKind::Shared(shared) => shared.push(sample),
        }
    }
}

impl<T> Receiver<T> {
    pub(crate) fn shared(shared: SharedBuffer<T>) -> Self {
        Self(ReceiverKind::Shared(shared))
    }

    /// Allocates memory for as many samples as the connection can hold. Without this, a buffer of many samples allocates most of
    /// its memory when more than a few samples wait, and a circular buffer with the first sample, in the thread that sends.
    pub fn reserve(&self) {
        match &self.0 {
            ReceiverKind::Buffer(reader) => reader.reserve(),
            ReceiverKind::Shared(shared) => shared.reserve(),
            // has its memory from the beginning
            ReceiverKind::Newest(_) => {}
        }
    }

    /// Prefetches what taking a sample needs, as far as the end knows where it is.
    pub fn prefetch(&self) {
        match &self.0 {
            ReceiverKind::Newest(reader) => reader.prefetch(),
            ReceiverKind::Buffer(reader) => reader.prefetch(),
            ReceiverKind::Shared(_) => {}
        }
    }

    /// Removes and returns the oldest sample or, in a data connection, the newest one.
    #[inline(always)]
    pub fn take(&mut self) -> Option<T> {
        match &mut self.0 {
            ReceiverKind::Newest(reader) => reader.take(),
            ReceiverKind::Buffer(reader) => reader.pop(),
            ReceiverKind::Shared(shared) => shared.pop(),
        }
    }

    /// Returns whether all other ends have been dropped. If so, a call of [`drain`](Self::drain) after this one passes on
    /// everything that they have written; one before may not.
    pub fn is_abandoned(&self) -> bool {
        let is_abandoned = match &self.0 {
            ReceiverKind::Newest(reader) => reader.is_abandoned(),
            ReceiverKind::Buffer(reader) => reader.is_abandoned(),
            ReceiverKind::Shared(shared) => shared.is_sole_owner(),
        };
        if is_abandoned {
            // the count is read without ordering; dropping an end releases what it has written
            fence(Ordering::Acquire);
        }
        is_abandoned
    }

    /// Upper bound of the number of samples that can be taken now.
    fn len(&mut self) -> usize {
        match &mut self.0 {
            ReceiverKind::Newest(_) => 1,
            ReceiverKind::Buffer(reader) => reader.len(),
            ReceiverKind::Shared(shared) => shared.len(),
        }
    }

    /// Passes all samples that are there at the time of the call to `f`, so that a writer faster than the reader
    /// cannot keep it here forever.
    pub fn drain(&mut self, mut f: impl FnMut(T)) {
        for _ in 0..self.len() {
            let Some(sample) = self.take() else { return };
            f(sample);
        }
    }
}

#[cfg(not(feature = "loom"))]
impl<T: Send + 'static> Receiver<T> {
    /// Tells how many samples wait; `None` for the newest sample alone, which is no queue, and for ends in one thread.
    pub fn gauge(&self) -> Option<QueueGauge> {
        match &self.0 {
            ReceiverKind::Newest(_) => None,
            ReceiverKind::Buffer(reader) => Some(reader.gauge()),
            ReceiverKind::Shared(shared) => shared.gauge(),
        }
    }
}

impl<T> Receiver<T> {
    /// Passes the unread values to `f`, in order, without consuming them. Intended for connections whose ends are
    /// idle.
    ///
    /// A value sent concurrently is not lost, but in a queue shared by several writers the order may change.
    pub fn peek_each(&mut self, mut f: impl FnMut(&T)) {
        match &mut self.0 {
            ReceiverKind::Newest(reader) => reader.peek_each(f),
            ReceiverKind::Buffer(reader) => reader.peek_each(f),
            // rotates the queue once
            ReceiverKind::Shared(shared) => {
                for _ in 0..shared.len() {
                    let Some(sample) = shared.pop() else { return };
                    f(&sample);
                    shared.push(sample);
                }
            }
        }
    }
}

#[cfg(all(test, not(feature = "loom")))]
mod tests {
    use super::*;
    use crate::pool::Pool;

    /// All implementations for a kind of buffer, each with one writer and one reader.
    fn all_channels(kind: BufferKind) -> [(Sender<u64>, Receiver<u64>); 5] {
        let ends = |pool: Pool<u64>| (pool.sender(), pool.receiver());
        [
            channel(kind),
            ends(Pool::lock_free(kind)),
            ends(Pool::locked(kind)),
            ends(Pool::on_demand(kind)),
            ends(crate::pool::unsync::tests::in_this_thread(kind)),
        ]
    }

    fn send_and_drain(kind: BufferKind, count: u64, kept: &[u64], dropped: usize) {
        for (mut sender, mut receiver) in all_channels(kind) {
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
    fn a_circular_buffer_is_allocated_by_its_reader_or_with_the_first_sample() {
        let is_allocated = |receiver: &Receiver<u64>| match &receiver.0 {
            ReceiverKind::Shared(SharedBuffer::OnDemand(queue)) => queue.is_allocated(),
            ReceiverKind::Shared(_) | ReceiverKind::Newest(_) | ReceiverKind::Buffer(_) => true,
        };
        let kind = BufferKind::Circular(3);
        let ((mut sender, sent), (_, reserved)) = (channel(kind), channel(kind));
        assert!(!is_allocated(&sent) && !is_allocated(&reserved));
        assert_eq!(sender.send(1), PushOutcome::Stored);
        reserved.reserve();
        assert!(is_allocated(&sent) && is_allocated(&reserved));
        // one that is for senders outside waits for them
        let outside = Pool::on_demand(kind).receiver();
        outside.reserve();
        assert!(!is_allocated(&outside));
    }

    #[test]
    fn what_was_looked_at_is_still_there() {
        for kind in [
            BufferKind::Data,
            BufferKind::Buffer(3),
            BufferKind::Circular(3),
        ] {
            for (mut sender, mut receiver) in all_channels(kind) {
                for n in 0..4 {
                    sender.send(n);
                }
                let mut seen = Vec::new();
                receiver.peek_each(|sample| seen.push(*sample));
                let mut got = Vec::new();
                receiver.drain(|sample| got.push(sample));
                assert_eq!((seen.len(), seen), (kind.size(), got), "{kind:?}");
            }
        }
    }

    #[test]
    fn another_thread_sees_how_many_samples_wait() {
        for kind in [BufferKind::Buffer(3), BufferKind::Circular(3)] {
            let [others @ .., in_one_thread] = all_channels(kind);
            assert!(in_one_thread.1.gauge().is_none());
            for (mut sender, mut receiver) in others {
                let gauge = receiver.gauge().expect("a queue");
                let waiting = || {
                    let gauge = gauge.clone();
                    std::thread::spawn(move || gauge.waiting()).join().unwrap()
                };
                assert_eq!(waiting(), 0, "{kind:?}");
                for expected in [1, 2, 3, 3] {
                    sender.send(7);
                    assert_eq!(waiting(), expected, "{kind:?}");
                }
                receiver.take();
                assert_eq!(waiting(), 2, "{kind:?}");
                assert!(!receiver.is_abandoned() && !gauge.is_gone());
                drop(sender);
                assert!(receiver.is_abandoned());
                drop(receiver);
                assert!(gauge.is_gone() && gauge.waiting() == 0, "{kind:?}");
            }
        }
        let (_, newest) = channel::<u64>(BufferKind::Data);
        assert!(newest.gauge().is_none());
        let pool = Pool::<u64>::lock_free(BufferKind::Buffer(3));
        let gauges = [pool.receiver(), pool.receiver()].map(|it| it.gauge().unwrap());
        assert!(gauges[0].is_same(&gauges[1]));
        let other = channel::<u64>(BufferKind::Buffer(3)).1.gauge().unwrap();
        assert!(!gauges[0].is_same(&other));
    }

    #[test]
    fn an_end_is_abandoned_when_all_others_are_gone() {
        for kind in [
            BufferKind::Data,
            BufferKind::Buffer(3),
            BufferKind::Circular(3),
        ] {
            for (mut sender, mut receiver) in all_channels(kind) {
                assert!(!receiver.is_abandoned(), "{kind:?}");
                sender.send(7);
                drop(sender);
                assert!(receiver.is_abandoned(), "{kind:?}");
                assert_eq!(receiver.take(), Some(7), "{kind:?}");
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
