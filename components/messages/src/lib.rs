//! The messages of the robot, with ROS 2 names and field order; one file for each ROS package.
//!
//! Units and frames are ROS': SI units and radians, x forward, y left, z up, angles counter-clockwise (REP-103);
//! frames `map`, `odom`, `base_link`, `laser` (REP-105).

mod builtin_interfaces;
mod geometry_msgs;
mod nav;
mod nav_msgs;
mod operation;
mod plausible;
mod rover;
mod sensor_msgs;
mod std_msgs;
mod table;
mod world;
mod youbot;

pub use builtin_interfaces::*;
pub use geometry_msgs::*;
pub use nav::*;
pub use nav_msgs::*;
pub use operation::{GetMap, Plan};
pub use rover::*;
pub use sensor_msgs::*;
pub use std_msgs::*;
pub use table::{DescribeMessage, MESSAGES};
pub use world::*;
pub use youbot::*;
