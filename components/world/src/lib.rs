//! The simulated two-dimensional world.
//!
//! [`Body`] is the robot's body, [`Schedule`] determines when obstacles are present, [`World`] is the component.

mod body;
mod schedule;
mod world;

pub use body::{Body, Slip};
pub use schedule::{Obstacle, ObstacleError, ObstacleProblem, Schedule, Solid};
pub use world::World;
