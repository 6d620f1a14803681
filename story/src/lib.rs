//! The story of a mission: reports events as they happen.
//!
//! [`Story`] turns the events of a run into lines; [`Summary`] condenses them at the end. The composite determines
//! which events are worth reporting: inputs of its specifications, calls of services, motion. Maps, paths, goals and
//! odometry are recognised by their standard ROS messages, collisions by `nav/Event`; no component, topic or robot is named here.

pub mod brief;
mod common;
mod driven_path;
mod entry;
mod input;
mod limit;
mod losses;
mod message;
mod repeats;
mod robot;
mod shared;
mod step;
mod story;
pub mod style;
mod summary;

pub use driven_path::DrivenPath;
pub use robot::{RobotSummary, Robots};
pub use shared::SharedStory;
pub use story::Story;
pub use summary::{EventCounts, Summary};
