//! The client library of ROS 1, alone and with a master and nodes of ROS.

#![allow(clippy::unwrap_used, clippy::expect_used, reason = "helpers of tests")]

mod fixture;
mod graph;
mod topics;
mod xmlrpc;
