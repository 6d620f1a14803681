//! The channel of one connection: typed, bounded, lock-free.

use std::sync::Arc;

use crossbeam_queue::ArrayQueue;

use super::Kind;
use super::triple::{self, triple};
use crate::Time;

/// A sample on its way.
#[derive(Debug)]
pub(crate) struct Stamped<T> {
    /// When it left its component.
    pub at: Time,
    /// Its place among all samples of the run, so that a reader of several connections sees them as they came.
    pub order: u64,
    pub value: T,
}

/// What became of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delivery {
    /// It lies where its reader finds it.
    Stored,
    /// The new one did not fit.
    DroppedNewest,
    /// It fits, an older one had to go.
    DroppedOldest,
}

/// The writing end.
pub(crate) enum Sender<T> {
    Data(triple::Writer<Stamped<T>>),
    Buffer(Arc<ArrayQueue<Stamped<T>>>),
    Circular(Arc<ArrayQueue<Stamped<T>>>),
}

/// The reading end.
pub(crate) enum Receiver<T> {
    Data(triple::Reader<Stamped<T>>),
    Queue(Arc<ArrayQueue<Stamped<T>>>),
}

/// A channel of a kind. A queue holds at least one.
pub(crate) fn channel<T>(kind: Kind) -> (Sender<T>, Receiver<T>) {
    let queue = |size: usize| Arc::new(ArrayQueue::new(size.max(1)));
    match kind {
        Kind::Data => {
            let (writer, reader) = triple();
            (Sender::Data(writer), Receiver::Data(reader))
        }
        Kind::Buffer(size) => {
            let queue = queue(size);
            (Sender::Buffer(Arc::clone(&queue)), Receiver::Queue(queue))
        }
        Kind::Circular(size) => {
            let queue = queue(size);
            (Sender::Circular(Arc::clone(&queue)), Receiver::Queue(queue))
        }
    }
}

impl<T> Sender<T> {
    pub(crate) fn send(&mut self, sample: Stamped<T>) -> Delivery {
        match self {
            Self::Data(writer) => {
                writer.write(sample);
                Delivery::Stored
            }
            Self::Buffer(queue) => match queue.push(sample) {
                Ok(()) => Delivery::Stored,
                Err(_) => Delivery::DroppedNewest,
            },
            Self::Circular(queue) => match queue.force_push(sample) {
                None => Delivery::Stored,
                Some(_) => Delivery::DroppedOldest,
            },
        }
    }
}

impl<T> Receiver<T> {
    /// Hands over what is there now; a writer faster than the reader cannot keep it here for ever.
    pub(crate) fn drain(&mut self, mut take: impl FnMut(Stamped<T>)) {
        match self {
            Self::Data(reader) => reader.take().into_iter().for_each(take),
            Self::Queue(queue) => {
                for _ in 0..queue.len() {
                    let Some(sample) = queue.pop() else { return };
                    take(sample);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn send_and_drain(kind: Kind, count: u64) -> (Vec<u64>, usize) {
        let (mut sender, mut receiver) = channel(kind);
        let dropped = (0..count)
            .map(|order| {
                sender.send(Stamped {
                    at: Time::ZERO,
                    order,
                    value: order,
                })
            })
            .filter(|delivery| *delivery != Delivery::Stored)
            .count();
        let mut got = Vec::new();
        receiver.drain(|sample| got.push(sample.value));
        (got, dropped)
    }

    #[test]
    fn o6_a_buffer_keeps_the_oldest() {
        assert_eq!(send_and_drain(Kind::Buffer(3), 5), (vec![0, 1, 2], 2));
    }

    #[test]
    fn o6_a_circular_buffer_keeps_the_newest() {
        assert_eq!(send_and_drain(Kind::Circular(3), 5), (vec![2, 3, 4], 2));
    }

    #[test]
    fn o5_data_keeps_the_last_and_counts_nothing_lost() {
        assert_eq!(send_and_drain(Kind::Data, 5), (vec![4], 0));
    }

    #[test]
    fn a_queue_of_size_zero_holds_one() {
        assert_eq!(send_and_drain(Kind::Buffer(0), 2), (vec![0], 1));
    }
}
