//! What a bridge remembers of the writers of a topic, also from one connection to the next.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use asmotion_bus::TransitTimes;
use asmotion_ros2::Gid;

/// The memories of subscriptions that have ended, by topic, for those that come in their place.
#[derive(Clone, Default)]
pub(crate) struct Memories(Arc<Mutex<BTreeMap<String, TopicMemory>>>);

impl Memories {
    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, TopicMemory>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps the memory of a subscription that ends.
    pub(crate) fn keep(&self, topic: &str, memory: TopicMemory) {
        self.lock().insert(topic.to_owned(), memory);
    }

    /// The memory for a new subscription.
    pub(crate) fn take(&self, topic: &str) -> TopicMemory {
        let mut memory = self.lock().remove(topic).unwrap_or_default();
        memory.delivered.clone_from(&memory.last);
        memory
    }
}

/// What a subscription knows of the writers of its topic.
#[derive(Default)]
pub(crate) struct TopicMemory {
    /// The highest number of a message of each writer.
    last: BTreeMap<Gid, i64>,
    /// That of earlier subscriptions: a writer sends a new one again what others have not acknowledged.
    delivered: BTreeMap<Gid, i64>,
    transits: WriterTransits,
}

impl TopicMemory {
    /// Returns whether no earlier subscription has delivered a message.
    pub(crate) fn is_new(&mut self, writer: Gid, sequence: i64) -> bool {
        if self.last.len() >= MOST_WRITERS && !self.last.contains_key(&writer) {
            self.last.clear();
        }
        let last = self.last.entry(writer).or_default();
        *last = sequence.max(*last);
        let delivered = self.delivered.get(&writer);
        delivered.is_none_or(|delivered| sequence > *delivered)
    }

    /// As [`WriterTransits::age`].
    pub(crate) fn age(
        &mut self,
        writer: Gid,
        written: Option<u64>,
        arrived: Instant,
        now: Instant,
    ) -> Duration {
        self.transits.age(writer, written, arrived, now)
    }
}

/// The times of transit of each writer, whose clock is compared with itself only.
struct WriterTransits {
    origin: Instant,
    writers: BTreeMap<Gid, TransitTimes>,
}

/// Most writers that are followed. Beyond it, all are forgotten, and the next message of each counts as new.
const MOST_WRITERS: usize = 1024;

impl Default for WriterTransits {
    fn default() -> Self {
        Self::beginning_at(Instant::now())
    }
}

impl WriterTransits {
    fn beginning_at(origin: Instant) -> Self {
        Self {
            origin,
            writers: BTreeMap::new(),
        }
    }

    /// Time for which a message of this writer waited on its way, and since it arrived. `written` is the time of its writing, in
    /// nanoseconds of the writer's clock.
    fn age(
        &mut self,
        writer: Gid,
        written: Option<u64>,
        arrived: Instant,
        now: Instant,
    ) -> Duration {
        let waiting = now.saturating_duration_since(arrived);
        let Some(written) = written else {
            return waiting;
        };
        if self.writers.len() >= MOST_WRITERS && !self.writers.contains_key(&writer) {
            self.writers.clear();
        }
        let transit = self.writers.entry(writer).or_default();
        // what arrived before this receiver was made counts as arriving then
        transit.waited(written, self.origin, arrived.max(self.origin)) + waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_new_subscription_does_not_deliver_again() {
        let (memories, writer) = (Memories::default(), Gid([1; 16]));
        let deliver = |memory: &mut TopicMemory, numbers: &[i64]| {
            let new = numbers.iter().filter(|it| memory.is_new(writer, **it));
            new.copied().collect::<Vec<_>>()
        };
        let mut first = memories.take("/word");
        // one may overtake another
        assert_eq!(deliver(&mut first, &[1, 3, 2]), [1, 3, 2]);
        memories.keep("/word", first);
        let mut second = memories.take("/word");
        assert_eq!(deliver(&mut second, &[2, 3, 5, 4]), [5, 4]);
        assert!(second.is_new(Gid([2; 16]), 1));
        assert_eq!(deliver(&mut memories.take("/other"), &[1]), [1]);
    }

    #[test]
    fn a_message_is_as_old_as_its_writer_shows_and_as_it_waited_here() {
        let origin = Instant::now();
        let at = |ms: u64| origin + Duration::from_millis(ms);
        let mut transits = WriterTransits::beginning_at(origin);
        let [near, far] = [Gid([1; 16]), Gid([2; 16])];
        // a clock that is an hour ahead, and one that is behind
        let mut check = |writer, written: Option<u64>, arrived, now, expected: u64| {
            let ahead = if writer == near { 3_600_000 } else { 1 };
            let written = written.map(|ms| (ms + ahead) * 1_000_000);
            let age = transits.age(writer, written, at(arrived), at(now));
            let expected = Duration::from_millis(expected);
            // less the drift that the two clocks may have had
            let least = expected.saturating_sub(Duration::from_millis(2));
            assert!((least..=expected).contains(&age), "{age:?} {expected:?}");
        };
        check(near, Some(0), 2, 2, 0);
        check(far, Some(0), 40, 40, 0);
        // written while the receiver stood still
        check(near, Some(1000), 4002, 4002, 3000);
        // and taken late from the queue
        check(near, Some(4000), 4002, 4102, 100);
        check(far, Some(4000), 4050, 4050, 10);
        // a writer that states no time
        check(far, None, 5000, 5200, 200);
    }
}
