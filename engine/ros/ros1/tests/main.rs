//! The client library of ROS 1, alone and with a master and nodes of ROS.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "helpers of tests"
)]

mod action_server;
mod actions;
mod bad_peers;
mod clock;
mod graph;
mod master;
mod parameters;
mod relays;
mod services;
mod topics;
mod xmlrpc;
