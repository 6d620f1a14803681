//! The shore: what those outside share with a simulation. They write when they like; the simulation hears of it before
//! its next step.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use crate::Time;
use crate::run::Beyond;

/// Shared with writers and readers outside.
pub(super) struct Shore {
    now: AtomicI64,
    /// Place of the last sample among all samples.
    order: AtomicU64,
    /// Whether there is news for anybody.
    any: AtomicBool,
    /// For each component.
    news: Box<[AtomicBool]>,
    ended: AtomicBool,
}

impl Shore {
    pub(super) fn new(components: usize) -> Self {
        Self {
            now: AtomicI64::new(0),
            order: AtomicU64::new(0),
            any: AtomicBool::new(false),
            news: (0..components).map(|_| AtomicBool::new(false)).collect(),
            ended: AtomicBool::new(false),
        }
    }

    pub(super) fn set_now(&self, now: Time) {
        self.now.store(now.nanos(), Ordering::Relaxed);
    }

    pub(super) fn end(&self) {
        self.ended.store(true, Ordering::Release);
    }

    /// Hands over the components for which there is news.
    pub(super) fn take_news(&self, mut give: impl FnMut(usize)) {
        if !self.any.load(Ordering::Relaxed) || !self.any.swap(false, Ordering::AcqRel) {
            return;
        }
        for (component, news) in self.news.iter().enumerate() {
            if news.swap(false, Ordering::AcqRel) {
                give(component);
            }
        }
    }
}

impl Beyond for Shore {
    fn now(&self) -> Time {
        Time::from_nanos(self.now.load(Ordering::Relaxed))
    }

    fn next_order(&self) -> u64 {
        self.order.fetch_add(1, Ordering::Relaxed) + 1
    }

    fn news(&self, component: usize) {
        if let Some(news) = self.news.get(component) {
            news.store(true, Ordering::Release);
            self.any.store(true, Ordering::Release);
        }
    }

    fn is_there(&self) -> bool {
        !self.ended.load(Ordering::Acquire)
    }
}
