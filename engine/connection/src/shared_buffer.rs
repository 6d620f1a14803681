//! A queue that several ends share.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use crossbeam_queue::ArrayQueue;

use crate::buffer_kind::BufferKind;
#[cfg(not(feature = "loom"))]
use crate::gauge::{QueueGauge, QueueLength};
use crate::push_outcome::PushOutcome;
use crate::store::Store;
use crate::unsync::Unsync;

/// A queue that several ends share.
pub(crate) enum SharedBuffer<T> {
    Newest(Arc<ArrayQueue<T>>),
    Buffer(Arc<ArrayQueue<T>>),
    Circular(Arc<ArrayQueue<T>>),
    Locked(Arc<Mutex<Store<T>>>),
    Unsync(Unsync<Store<T>>),
    OnDemand(Arc<QueueOnDemand<T>>),
}

/// A lock-free queue that is allocated with the first sample, unless its reader [reserves](SharedBuffer::reserve) it.
pub(crate) struct QueueOnDemand<T> {
    kind: BufferKind,
    queue: OnceLock<Box<ArrayQueue<T>>>,
    /// Set if `reserve` has no effect: most connections into a system from outside are never used.
    always_waits: bool,
}

impl<T> QueueOnDemand<T> {
    #[cfg(all(test, not(feature = "loom")))]
    pub(crate) fn is_allocated(&self) -> bool {
        self.queue.get().is_some()
    }

    fn allocated(&self) -> &ArrayQueue<T> {
        let make = || Box::new(ArrayQueue::new(self.kind.size()));
        self.queue.get_or_init(make)
    }
}

impl<T> SharedBuffer<T> {
    /// A lock-free queue.
    pub(crate) fn lock_free(kind: BufferKind) -> Self {
        let queue = Arc::new(ArrayQueue::new(kind.size()));
        match kind {
            BufferKind::Data => Self::Newest(queue),
            BufferKind::Buffer(_) => Self::Buffer(queue),
            BufferKind::Circular(_) => Self::Circular(queue),
        }
    }

    /// A lock-free queue that is allocated with the first sample.
    pub(crate) fn on_demand(kind: BufferKind) -> Self {
        Self::allocated_later(kind, true)
    }

    /// A lock-free queue that is allocated with the first sample, or by [`reserve`](Self::reserve).
    pub(crate) fn reservable(kind: BufferKind) -> Self {
        Self::allocated_later(kind, false)
    }

    fn allocated_later(kind: BufferKind, always_waits: bool) -> Self {
        Self::OnDemand(Arc::new(QueueOnDemand {
            kind,
            queue: OnceLock::new(),
            always_waits,
        }))
    }

    /// Allocates a [reservable](Self::reservable) queue.
    pub(crate) fn reserve(&self) {
        if let Self::OnDemand(on_demand) = self
            && !on_demand.always_waits
        {
            on_demand.allocated();
        }
    }

    pub(crate) fn push(&self, sample: T) -> PushOutcome {
        match self {
            Self::Newest(queue) => push_newest(queue, sample),
            Self::Buffer(queue) => push_buffer(queue, sample),
            Self::Circular(queue) => push_circular(queue, sample),
            Self::OnDemand(on_demand) => {
                let queue = on_demand.allocated();
                match on_demand.kind {
                    BufferKind::Data => push_newest(queue, sample),
                    BufferKind::Buffer(_) => push_buffer(queue, sample),
                    BufferKind::Circular(_) => push_circular(queue, sample),
                }
            }
            // the displaced sample is dropped after the lock is released, because its destructor may be slow
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

    pub(crate) fn pop(&self) -> Option<T> {
        match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => queue.pop(),
            Self::Locked(store) => locked(store).pop(),
            Self::Unsync(store) => store.with(Store::pop),
            Self::OnDemand(on_demand) => on_demand.queue.get()?.pop(),
        }
    }

    pub(crate) fn is_sole_owner(&self) -> bool {
        let shares = match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => {
                Arc::strong_count(queue)
            }
            Self::Locked(store) => Arc::strong_count(store),
            Self::Unsync(store) => store.strong_count(),
            Self::OnDemand(on_demand) => Arc::strong_count(on_demand),
        };
        shares == 1
    }

    /// Tells other threads how many samples wait; `None` for the newest sample alone, and for ends in one thread.
    #[cfg(not(feature = "loom"))]
    pub(crate) fn gauge(&self) -> Option<QueueGauge>
    where
        T: Send + 'static,
    {
        match self {
            Self::Buffer(queue) | Self::Circular(queue) => Some(QueueGauge::new(queue)),
            Self::Locked(store) => Some(QueueGauge::new(store)),
            Self::OnDemand(on_demand) if on_demand.kind != BufferKind::Data => {
                Some(QueueGauge::new(on_demand))
            }
            Self::Newest(_) | Self::OnDemand(_) | Self::Unsync(_) => None,
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Newest(queue) | Self::Buffer(queue) | Self::Circular(queue) => queue.len(),
            Self::Locked(store) => locked(store).len(),
            Self::Unsync(store) => store.with(|store| store.len()),
            Self::OnDemand(on_demand) => on_demand.queue.get().map_or(0, |queue| queue.len()),
        }
    }
}

#[cfg(not(feature = "loom"))]
impl<T: Send> QueueLength for Mutex<Store<T>> {
    fn length(&self) -> usize {
        locked(self).len()
    }
}

#[cfg(not(feature = "loom"))]
impl<T: Send> QueueLength for QueueOnDemand<T> {
    fn length(&self) -> usize {
        self.queue.get().map_or(0, |queue| queue.len())
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
            Self::OnDemand(on_demand) => Self::OnDemand(Arc::clone(on_demand)),
        }
    }
}

fn push_newest<T>(queue: &ArrayQueue<T>, sample: T) -> PushOutcome {
    queue.force_push(sample);
    PushOutcome::Stored
}

fn push_buffer<T>(queue: &ArrayQueue<T>, sample: T) -> PushOutcome {
    match queue.push(sample) {
        Ok(()) => PushOutcome::Stored,
        Err(_) => PushOutcome::DroppedNewest,
    }
}

fn push_circular<T>(queue: &ArrayQueue<T>, sample: T) -> PushOutcome {
    match queue.force_push(sample) {
        None => PushOutcome::Stored,
        Some(_) => PushOutcome::DroppedOldest,
    }
}

/// Locks the store. A poisoned lock is safe to use: every change leaves the queue consistent.
fn locked<T>(store: &Mutex<Store<T>>) -> MutexGuard<'_, Store<T>> {
    store.lock().unwrap_or_else(PoisonError::into_inner)
}
