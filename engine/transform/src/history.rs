//! Transforms of one frame over time.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::motion::RigidMotion;

/// Age at which transforms are forgotten, in nanoseconds: that of tf2.
const KEPT: i64 = 10_000_000_000;

/// Largest number of transforms of a frame; those of 10 s at 1 kHz fit.
const MOST: usize = 16_384;

/// A motion to a parent at a time.
#[derive(Clone, Debug)]
pub(crate) struct TimedMotion {
    /// Nanoseconds.
    pub(crate) stamp: i64,
    pub(crate) parent: Arc<str>,
    pub(crate) motion: RigidMotion,
}

/// The transforms of a frame, the oldest first. There is at least one.
#[derive(Debug)]
pub(crate) enum FrameHistory {
    /// One that holds at all times.
    Static(TimedMotion),
    Moving(VecDeque<TimedMotion>),
}

/// The place of a time in a history.
pub(crate) enum AtTime {
    Found(Arc<str>, RigidMotion),
    /// The time is before the first transform, by nanoseconds.
    Before(Arc<str>, i64),
    /// The time is after the last transform, by nanoseconds.
    After(Arc<str>, i64),
}

impl FrameHistory {
    pub(crate) fn new(first: TimedMotion, is_static: bool) -> Self {
        if is_static {
            Self::Static(first)
        } else {
            Self::Moving(VecDeque::from([first]))
        }
    }

    /// Adds a transform. The kind of the latest message decides whether the frame moves.
    pub(crate) fn insert(&mut self, new: TimedMotion, is_static: bool) {
        let Self::Moving(known) = self else {
            *self = Self::new(new, is_static);
            return;
        };
        let newest = known.back().map_or(new.stamp, |it| it.stamp);
        // a publisher that starts again with an earlier time: its transforms would be ignored for ever
        let is_earlier = new.stamp < newest.saturating_sub(KEPT);
        if is_static || is_earlier {
            *self = Self::new(new, is_static);
            return;
        }
        let at = known.partition_point(|it| it.stamp < new.stamp);
        match known.get_mut(at).filter(|it| it.stamp == new.stamp) {
            Some(same) => *same = new,
            None => known.insert(at, new),
        }
        let newest = known.back().map_or(newest, |it| it.stamp);
        let is_old = |it: &TimedMotion| it.stamp < newest.saturating_sub(KEPT);
        while known.len() > MOST || known.front().is_some_and(is_old) {
            known.pop_front();
        }
    }

    /// The latest parent, with the time of the transform; `None` in place of the time if it holds at all times.
    pub(crate) fn latest(&self) -> Option<(&Arc<str>, Option<i64>)> {
        match self {
            Self::Static(always) => Some((&always.parent, None)),
            Self::Moving(known) => known.back().map(|it| (&it.parent, Some(it.stamp))),
        }
    }

    /// Whether one of the transforms has this parent.
    pub(crate) fn has_parent(&self, frame: &str) -> bool {
        match self {
            Self::Static(always) => *always.parent == *frame,
            Self::Moving(known) => known.iter().any(|it| *it.parent == *frame),
        }
    }

    /// The motion to the parent at a time, interpolated between the transforms around it. A frame that changes its parent has the
    /// earlier one until the later transform, as in tf2.
    pub(crate) fn at(&self, stamp: i64) -> Option<AtTime> {
        let known = match self {
            Self::Static(always) => {
                return Some(AtTime::Found(Arc::clone(&always.parent), always.motion));
            }
            Self::Moving(known) => known,
        };
        let at = known.partition_point(|it| it.stamp < stamp);
        let before = at.checked_sub(1).and_then(|index| known.get(index));
        Some(match (before, known.get(at)) {
            (_, Some(same)) if same.stamp == stamp => {
                AtTime::Found(Arc::clone(&same.parent), same.motion)
            }
            (Some(before), Some(after)) if before.parent == after.parent => {
                let length = (after.stamp - before.stamp) as f64;
                let ratio = (stamp - before.stamp) as f64 / length;
                let motion = before.motion.interpolate(after.motion, ratio);
                AtTime::Found(Arc::clone(&before.parent), motion)
            }
            (Some(before), Some(_)) => AtTime::Found(Arc::clone(&before.parent), before.motion),
            (None, Some(first)) => {
                AtTime::Before(Arc::clone(&first.parent), first.stamp.saturating_sub(stamp))
            }
            (Some(last), None) => {
                AtTime::After(Arc::clone(&last.parent), stamp.saturating_sub(last.stamp))
            }
            (None, None) => return None,
        })
    }
}
