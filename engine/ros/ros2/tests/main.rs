//! Tests of the node: against Cyclone DDS in Python, rclpy on Fast DDS, and a second node where neither can play the peer.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that fails says where"
)]

mod actions;
mod bytes;
mod fastdds;
mod graph;
mod malformed;
mod peer;
mod services;
mod standstill;
mod topics;
