//! Transforms between coordinate frames, as tf2 looks them up, and messages of ROS in another frame.
//!
//! A [`TransformBuffer`] keeps the transforms of the topics `/tf` and `/tf_static` and finds the one between two frames at a time.
//! A [`MessageTransform`] takes a stamped message into a frame. There is no network and no clock: waiting is up to the caller.
//!
//! ```
//! use asmotion_transform::{RigidMotion, StampedMotion, TransformBuffer};
//!
//! let mut buffer = TransformBuffer::default();
//! let laser = RigidMotion::translation(0.2, 0.0, 0.1);
//! buffer.insert(StampedMotion::new("base", "laser", 0, laser), true)?;
//! let found = buffer.look_up("base", "laser", 1_000_000_000)?;
//! assert_eq!(found.motion, laser);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod buffer;
mod cloud;
mod failure;
mod fields;
mod history;
mod message;
mod motion;

pub use buffer::{FoundTransform, StampedMotion, TransformBuffer};
pub use failure::{InvalidTransform, NotTransformable, TransformFailure};
pub use message::MessageTransform;
pub use motion::{RigidMotion, UnitQuaternion, Vector3};
