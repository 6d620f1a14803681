//! The tree of transforms.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use asmotion_datum::Datum;

use crate::failure::{InvalidTransform, TransformFailure};
use crate::fields::{frame_name, nanoseconds, quaternion, text, vector};
use crate::history::{AtTime, FrameHistory, TimedMotion};
use crate::motion::{RigidMotion, UnitQuaternion};

/// Largest number of frames: a publisher that makes up names does not fill the memory.
const MOST_FRAMES: usize = 4096;

/// Largest number of frames between a frame and the root of its tree, as in tf2.
const DEEPEST: usize = 1000;

/// Transforms of the last 10 seconds, in which the one between two frames at a time is looked up.
#[derive(Debug, Default)]
pub struct TransformBuffer {
    frames: BTreeMap<Arc<str>, FrameHistory>,
}

/// The pose of a frame in its parent at a time.
#[derive(Clone, Debug)]
pub struct StampedMotion {
    parent: String,
    child: String,
    stamp: i64,
    motion: RigidMotion,
}

impl StampedMotion {
    /// The motion that takes points of the child to the parent; `stamp` in nanoseconds.
    pub fn new(parent: &str, child: &str, stamp: i64, motion: RigidMotion) -> Self {
        Self {
            parent: parent.to_owned(),
            child: child.to_owned(),
            stamp,
            motion,
        }
    }
}

/// A transform between two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundTransform {
    /// Takes points of the source to the target.
    pub motion: RigidMotion,
    /// Its time in nanoseconds.
    pub stamp: i64,
}

/// The frames above a frame, from itself upwards, with the motion to each of them, and the reason that there are no more.
struct Ascent {
    frames: Vec<(Arc<str>, RigidMotion)>,
    end: Option<TransformFailure>,
}

impl TransformBuffer {
    /// Number of frames that have a parent.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// Adds a transform; one of `/tf_static` holds at all times.
    ///
    /// # Errors
    /// [`InvalidTransform`]: it is not kept.
    pub fn insert(&mut self, new: StampedMotion, is_static: bool) -> Result<(), InvalidTransform> {
        let (parent, child) = (frame_name(&new.parent), frame_name(&new.child));
        if parent.is_empty() || child.is_empty() {
            return Err(InvalidTransform::NoFrame);
        }
        if parent == child {
            let frame = child.to_owned();
            return Err(InvalidTransform::OwnParent { frame });
        }
        if !new.motion.is_finite() {
            return Err(no_motion(parent, child));
        }
        let timed = TimedMotion {
            stamp: new.stamp,
            parent: parent.into(),
            motion: new.motion,
        };
        if let Some(known) = self.frames.get_mut(child) {
            known.insert(timed, is_static);
            return Ok(());
        }
        if self.frames.len() >= MOST_FRAMES {
            return Err(InvalidTransform::TooMany {
                frame: child.to_owned(),
                most: MOST_FRAMES,
            });
        }
        let history = FrameHistory::new(timed, is_static);
        self.frames.insert(child.into(), history);
        Ok(())
    }

    /// Adds the transforms of a message of `tf2_msgs/TFMessage`. Returns the reasons that some of them are not kept.
    pub fn insert_message(&mut self, message: &Datum, is_static: bool) -> Vec<InvalidTransform> {
        let list = message.get("transforms");
        let Some(count) = list.as_ref().and_then(|list| list.count()) else {
            return vec![InvalidTransform::NoMessage];
        };
        let mut refused = Vec::new();
        for index in 0..count {
            let element = list.as_ref().and_then(|list| list.element(index));
            let read = element.map_or(Err(InvalidTransform::NoMessage), |it| stamped(&it));
            if let Err(reason) = read.and_then(|new| self.insert(new, is_static)) {
                refused.push(reason);
            }
        }
        refused
    }

    /// Finds the transform that takes points of the source to the target at a time in nanoseconds; at time 0, it is the latest
    /// for which all transforms on the way are known.
    ///
    /// # Errors
    /// [`TransformFailure`].
    pub fn look_up(
        &self,
        target: &str,
        source: &str,
        stamp: i64,
    ) -> Result<FoundTransform, TransformFailure> {
        let (target, source) = (frame_name(target), frame_name(source));
        if target == source {
            let motion = RigidMotion::IDENTITY;
            return Ok(FoundTransform { motion, stamp });
        }
        // frames are searched for only after a failure: that of the root has no entry
        self.find(target, source, stamp).map_err(|failure| {
            let mut frames = [target, source].into_iter();
            match frames.find(|frame| !self.is_known(frame)) {
                Some(unknown) => TransformFailure::UnknownFrame {
                    frame: unknown.to_owned(),
                },
                None => failure,
            }
        })
    }

    fn find(
        &self,
        target: &str,
        source: &str,
        stamp: i64,
    ) -> Result<FoundTransform, TransformFailure> {
        let stamp = match stamp {
            0 => self.latest_common(target, source)?,
            stamp => stamp,
        };
        let (of_target, of_source) = (self.ascend(target, stamp), self.ascend(source, stamp));
        for (frame, up) in &of_source.frames {
            let mut above = of_target.frames.iter();
            if let Some((_, down)) = above.find(|(other, _)| other == frame) {
                let motion = down.inverse().after(*up);
                return Ok(FoundTransform { motion, stamp });
            }
        }
        let reason = of_source.end.or(of_target.end);
        Err(reason.unwrap_or_else(|| disconnected(target, source)))
    }

    fn is_known(&self, frame: &str) -> bool {
        let mut others = self.frames.values();
        self.frames.contains_key(frame) || others.any(|it| it.has_parent(frame))
    }

    /// Walks towards the root at a time, as far as there are transforms.
    fn ascend(&self, frame: &str, stamp: i64) -> Ascent {
        let mut ascent = Ascent {
            frames: vec![(frame.into(), RigidMotion::IDENTITY)],
            end: None,
        };
        let (mut here, mut motion): (Arc<str>, _) = (frame.into(), RigidMotion::IDENTITY);
        while let Some(at) = self.frames.get(&here).and_then(|it| it.at(stamp)) {
            let by = |nanoseconds: i64| Duration::from_nanos(nanoseconds.unsigned_abs());
            match at {
                AtTime::Found(parent, step) => {
                    motion = step.after(motion);
                    here = parent;
                }
                AtTime::Before(parent, early) => {
                    ascent.end = Some(TransformFailure::Past {
                        child: here.to_string(),
                        parent: parent.to_string(),
                        by: by(early),
                    });
                    break;
                }
                AtTime::After(parent, late) => {
                    ascent.end = Some(TransformFailure::Future {
                        child: here.to_string(),
                        parent: parent.to_string(),
                        by: by(late),
                    });
                    break;
                }
            }
            if ascent.frames.len() > DEEPEST || ascent.frames.iter().any(|(it, _)| *it == here) {
                let frame = here.to_string();
                ascent.end = Some(TransformFailure::Circle { frame });
                break;
            }
            ascent.frames.push((Arc::clone(&here), motion));
        }
        ascent
    }

    /// The latest time for which all transforms between two frames are known; 0 if they hold at all times.
    fn latest_common(&self, target: &str, source: &str) -> Result<i64, TransformFailure> {
        let (of_target, of_source) = (self.latest_above(target), self.latest_above(source));
        for (up, (frame, _)) in of_source.iter().enumerate() {
            // the first frame that both have above them
            let Some(down) = of_target.iter().position(|(other, _)| other == frame) else {
                continue;
            };
            let times = of_source.iter().take(up).chain(of_target.iter().take(down));
            return Ok(times.filter_map(|(_, latest)| *latest).min().unwrap_or(0));
        }
        Err(disconnected(target, source))
    }

    /// The frames above a frame by their latest transforms, from itself upwards, each with the time of its transform.
    fn latest_above(&self, frame: &str) -> Vec<(Arc<str>, Option<i64>)> {
        let (mut above, mut here): (Vec<(Arc<str>, _)>, Arc<str>) = (Vec::new(), frame.into());
        while above.len() <= DEEPEST {
            let latest = self.frames.get(&here).and_then(FrameHistory::latest);
            above.push((Arc::clone(&here), latest.and_then(|(_, stamp)| stamp)));
            let Some((parent, _)) = latest else {
                break;
            };
            if above.iter().any(|(known, _)| known == parent) {
                break;
            }
            here = Arc::clone(parent);
        }
        above
    }
}

fn disconnected(target: &str, source: &str) -> TransformFailure {
    TransformFailure::Disconnected {
        from: source.to_owned(),
        to: target.to_owned(),
    }
}

fn no_motion(parent: &str, child: &str) -> InvalidTransform {
    InvalidTransform::NoMotion {
        child: child.to_owned(),
        parent: parent.to_owned(),
    }
}

/// Reads a `geometry_msgs/TransformStamped`.
fn stamped(message: &Datum) -> Result<StampedMotion, InvalidTransform> {
    let parent = text(message, "header.frame_id").unwrap_or_default();
    let child = text(message, "child_frame_id").unwrap_or_default();
    let motion = || {
        let rotation = quaternion(message.get("transform.rotation")?.as_ref())?;
        Some(RigidMotion {
            rotation: UnitQuaternion::normalized(rotation)?,
            offset: vector(message.get("transform.translation")?.as_ref())?,
        })
    };
    let motion = motion().ok_or_else(|| no_motion(frame_name(&parent), frame_name(&child)))?;
    let stamp = message.get("header.stamp");
    let stamp = stamp.and_then(|it| nanoseconds(&it)).unwrap_or(0);
    Ok(StampedMotion::new(&parent, &child, stamp, motion))
}
