//! Due items, ordered by time; at the same instant samples and deadlines precede cycles, and cycles follow declaration
//! order.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;
use std::sync::Arc;

use asmotion_datum::Sample;
use asmotion_port::Time;

use crate::injection::InjectionTarget;

/// An item that is due at a time.
pub(super) struct Due {
    pub at: Time,
    /// Order of planning; breaks ties.
    serial: u64,
    pub work: DueWork,
}

/// The kind of work that is due.
pub(super) enum DueWork {
    /// Inject a sample.
    Sample {
        target: InjectionTarget,
        sample: Arc<dyn Sample>,
    },
    /// End a call that has had no reply, or trigger the cycle that the component has requested.
    Deadline { component: usize },
    /// Run a cycle because new data have arrived.
    Trigger { component: usize, generation: u64 },
    /// Run a cycle because a period has passed.
    Period { component: usize, generation: u64 },
}

impl Due {
    fn rank(&self) -> (Time, u8, usize, u64) {
        let (class, component) = match self.work {
            DueWork::Sample { .. } => (0, 0),
            DueWork::Deadline { component } => (1, component),
            DueWork::Trigger { component, .. } | DueWork::Period { component, .. } => {
                (2, component)
            }
        };
        (self.at, class, component, self.serial)
    }
}

impl PartialEq for Due {
    fn eq(&self, other: &Self) -> bool {
        self.rank() == other.rank()
    }
}

impl Eq for Due {}

impl PartialOrd for Due {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Due {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.rank().cmp(&other.rank())
    }
}

/// All due items, earliest first.
#[derive(Default)]
pub(super) struct DueQueue {
    heap: BinaryHeap<Reverse<Due>>,
    planned: u64,
}

impl DueQueue {
    pub(super) fn push(&mut self, at: Time, what: DueWork) {
        self.planned += 1;
        let serial = self.planned;
        self.heap.push(Reverse(Due {
            at,
            serial,
            work: what,
        }));
    }

    pub(super) fn pop(&mut self) -> Option<Due> {
        self.heap.pop().map(|Reverse(due)| due)
    }

    /// Removes and returns the next item if it is due by `until`.
    pub(super) fn pop_until(&mut self, until: Time) -> Option<Due> {
        let due = self.heap.peek_mut()?;
        (due.0.at <= until).then(|| PeekMut::pop(due).0)
    }

    /// Returns all entries in order: time, serial number and work.
    pub(super) fn entries(&self) -> Vec<(Time, u64, &DueWork)> {
        let mut entries: Vec<_> = self.heap.iter().map(|Reverse(due)| due).collect();
        entries.sort();
        let entries = entries.into_iter();
        entries.map(|due| (due.at, due.serial, &due.work)).collect()
    }

    /// Returns the number of entries planned so far.
    pub(super) fn planned(&self) -> u64 {
        self.planned
    }

    /// Creates a queue with these entries.
    pub(super) fn of(planned: u64, entries: Vec<(Time, u64, DueWork)>) -> Self {
        let entries = entries.into_iter();
        let due = |(at, serial, what)| {
            Reverse(Due {
                at,
                serial,
                work: what,
            })
        };
        Self {
            heap: entries.map(due).collect(),
            planned,
        }
    }

    /// Time of the next item.
    pub(super) fn next(&self) -> Option<Time> {
        self.heap.peek().map(|Reverse(due)| due.at)
    }
}
