//! Planar geometry: poses, occupancy grids, polylines, ray casting.
//!
//! Metres and radians, x forward, y left, angles counter-clockwise (REP-103); coordinates are those of the map frame
//! (REP-105) unless a name says otherwise. Only this crate depends on parry2d; see [`ObstacleScene`].

mod arc;
mod brakes;
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
mod trail;

pub use arc::Arc;
pub use brakes::{Brakes, DECELERATION};
pub use distances::Distances;
pub use grid::{FREE, Grid, OCCUPIED, OCCUPIED_FROM, Occupancy, UNKNOWN};
pub use layout::{Cell, GridLayout, GridLayoutError};
pub use polyline::{NearestOnLine, Polyline};
pub use pose::{Point, Pose, Vector, heading, roll, turn, wrap, yaw};
pub use scene::{ObstacleScene, RoundObstacle};
pub use trail::Trail;
