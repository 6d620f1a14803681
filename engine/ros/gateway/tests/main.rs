//! The component alone, with a transport in memory. Tests with nodes of ROS are those of the command line (`tests/ros_bridge.rs`).

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

mod bridge;
