//! Planar geometry: poses, occupancy grids, polylines, ray casting.
//!
//! Metres and radians, x forward, y left, angles counter-clockwise (REP-103); coordinates are those of the map frame
//! (REP-105) unless a name says otherwise. This is the one room that knows parry2d: see [`Scene`].

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
pub use layout::{Cell, Layout, LayoutError};
pub use polyline::{Nearest, Polyline};
pub use pose::{Point, Pose, Vector, heading, turn, wrap, yaw};
pub use scene::{Disc, Scene};
