//! The two-dimensional world the robot acts in

mod body;
mod schedule;

pub use body::{Body, Slip};
pub use schedule::{Frame, Obstacle, Schedule, Solid};
