//! Planar geometry: poses, occupancy grids, polylines, ray casting.
//!
//! Metres and radians, x forward, y left, angles counter-clockwise (REP-103); coordinates are those of the map frame
//! (REP-105) unless a name says otherwise. Only this crate depends on parry2d; see [`ObstacleScene`].

mod distances;
mod draw;
mod grid;
mod layout;
pub mod message;
mod outline;
mod polyline;
mod pose;
mod scene;
mod sight;

pub use distances::Distances;
pub use grid::{FREE, Grid, OCCUPIED, OCCUPIED_FROM, Occupancy, UNKNOWN};
pub use layout::{Cell, GridLayout, GridLayoutError};
pub use polyline::{NearestOnLine, Polyline};
pub use pose::{Point, Pose, Vector, heading, turn, wrap, yaw};
pub use scene::{ObstacleScene, RoundObstacle};
