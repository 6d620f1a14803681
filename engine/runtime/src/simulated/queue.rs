//! Due items, ordered by time; at the same instant samples and deadlines precede cycles, and cycles follow declaration
//! order.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::sync::Arc;

use asmotion_datum::Sample;
use asmotion_port::Time;

use crate::injection::InjectionTarget;

/// An item that is due at a time.
pub(super) struct Due {
    pub at: Time,
    pub work: DueWork,
}

/// The kind of work that is due.
pub(super) enum DueWork {
    /// Inject a sample.
    Sample(DueSample),
    /// End a call that has had no reply, or trigger the cycle that the component has requested.
    Deadline { component: usize },
    /// Run a cycle because new data have arrived.
    Trigger { component: usize, generation: u32 },
    /// Run a cycle because a period has passed.
    Period { component: usize, generation: u32 },
}

/// A sample, and the port that it is injected into.
#[derive(Clone)]
pub(super) struct DueSample {
    pub target: InjectionTarget,
    pub sample: Arc<dyn Sample>,
}

/// An item in the heap, ordered as it is due. Each cycle moves several of them, so they are small: samples are stored by their serial
/// numbers.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    at: Time,
    rank: Rank,
    /// Order of planning; breaks ties.
    serial: u64,
    /// The generation of the schedule that planned a cycle; zero for other items.
    generation: u32,
    /// A cycle is due because a period has passed.
    is_period: bool,
}

/// Order of items at the same instant, with the component's position.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    Sample,
    Deadline(u32),
    Cycle(u32),
}

/// All due items, earliest first.
#[derive(Default)]
pub(super) struct DueQueue {
    heap: BinaryHeap<Reverse<Entry>>,
    /// The samples among the items, by serial number.
    samples: BTreeMap<u64, DueSample>,
    planned: u64,
}

/// Returns a position in 32 bits; a system that fits into memory has fewer components.
fn position(component: usize) -> u32 {
    u32::try_from(component).unwrap_or(u32::MAX)
}

impl DueQueue {
    pub(super) fn push(&mut self, at: Time, what: DueWork) {
        self.planned += 1;
        self.insert(at, self.planned, what);
    }

    fn insert(&mut self, at: Time, serial: u64, work: DueWork) {
        let (rank, generation, is_period) = match work {
            DueWork::Sample(sample) => {
                self.samples.insert(serial, sample);
                (Rank::Sample, 0, false)
            }
            DueWork::Deadline { component } => (Rank::Deadline(position(component)), 0, false),
            DueWork::Trigger {
                component,
                generation,
            } => (Rank::Cycle(position(component)), generation, false),
            DueWork::Period {
                component,
                generation,
            } => (Rank::Cycle(position(component)), generation, true),
        };
        self.heap.push(Reverse(Entry {
            at,
            rank,
            serial,
            generation,
            is_period,
        }));
    }

    /// Removes and returns the next item.
    pub(super) fn pop(&mut self) -> Option<Due> {
        loop {
            let Reverse(entry) = self.heap.pop()?;
            let work = match entry.rank {
                Rank::Sample => self.samples.remove(&entry.serial).map(DueWork::Sample),
                Rank::Deadline(_) | Rank::Cycle(_) => entry.work(),
            };
            // each sample in the heap is stored
            if let Some(work) = work {
                return Some(Due { at: entry.at, work });
            }
        }
    }

    /// Removes and returns the next item if it is due by `until`.
    pub(super) fn pop_until(&mut self, until: Time) -> Option<Due> {
        self.next().filter(|at| *at <= until)?;
        self.pop()
    }

    /// Returns all items in order: time, serial number and work.
    pub(super) fn entries(&self) -> Vec<(Time, u64, DueWork)> {
        let mut entries: Vec<_> = self.heap.iter().map(|Reverse(entry)| *entry).collect();
        entries.sort();
        let all = entries.into_iter().filter_map(|entry| {
            let sample = self.samples.get(&entry.serial).cloned();
            let work = sample.map(DueWork::Sample).or_else(|| entry.work())?;
            Some((entry.at, entry.serial, work))
        });
        all.collect()
    }

    /// Returns the number of items planned so far.
    pub(super) fn planned(&self) -> u64 {
        self.planned
    }

    /// Creates a queue with these items.
    pub(super) fn of(planned: u64, entries: Vec<(Time, u64, DueWork)>) -> Self {
        let mut queue = Self {
            planned,
            ..Self::default()
        };
        for (at, serial, work) in entries {
            queue.insert(at, serial, work);
        }
        queue
    }

    /// Time of the next item.
    pub(super) fn next(&self) -> Option<Time> {
        self.heap.peek().map(|Reverse(entry)| entry.at)
    }
}

impl Entry {
    /// The work of an item that is not a sample.
    fn work(self) -> Option<DueWork> {
        let generation = self.generation;
        match self.rank {
            Rank::Sample => None,
            Rank::Deadline(component) => Some(DueWork::Deadline {
                component: component as usize,
            }),
            Rank::Cycle(component) if self.is_period => Some(DueWork::Period {
                component: component as usize,
                generation,
            }),
            Rank::Cycle(component) => Some(DueWork::Trigger {
                component: component as usize,
                generation,
            }),
        }
    }
}
