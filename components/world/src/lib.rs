//! The simulated two-dimensional world.
//!
//! [`Body`] is the robot's body, [`Schedule`] determines when obstacles are present, [`World`] is the component of one robot, and
//! [`Traffic`] tells several of them about each other.

mod body;
mod schedule;
mod traffic;
mod world;

pub use body::{Body, Slip, Surroundings};
pub use schedule::{Obstacle, ObstacleError, ObstacleProblem, Schedule, Solid};
pub use traffic::Traffic;
pub use world::World;
