//! The two-dimensional world the robot acts in.
//!
//! [`Body`] moves and bumps, [`Schedule`] lets obstacles come and go, [`World`] is the component.

mod body;
mod schedule;
mod world;

pub use body::{Body, Slip};
pub use schedule::{Obstacle, ObstacleError, ObstacleProblem, Schedule, Solid};
pub use world::World;
