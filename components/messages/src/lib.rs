//! The messages of the robot: ROS 2 names, ROS 2 field order, one file a ROS package.
//!
//! Units and frames are ROS': SI units and radians, x forward, y left, z up, angles counter-clockwise (REP-103);
//! frames `map`, `odom`, `base_link`, `laser` (REP-105).

mod builtin_interfaces;
mod geometry_msgs;
mod nav;
mod nav_msgs;
mod rover;
mod sensor_msgs;
mod std_msgs;
mod world;

mod table;

pub use builtin_interfaces::*;
pub use geometry_msgs::*;
pub use nav::*;
pub use nav_msgs::*;
pub use rover::*;
pub use sensor_msgs::*;
pub use std_msgs::*;
pub use world::*;
pub use table::MESSAGES;
