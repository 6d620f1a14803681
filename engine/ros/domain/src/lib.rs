//! Peers of ROS 2 for tests: Cyclone DDS in Python, and rclpy on Fast DDS, on the loopback interface alone. Each test has a domain
//! of its own.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::missing_panics_doc,
    clippy::indexing_slicing,
    clippy::string_slice,
    reason = "part of tests"
)]

mod action;
mod nav2;
mod node;
mod peer;
mod rclpy;

pub use action::{action_kinds, service_kinds};
pub use nav2::Nav2;
pub use node::{CycloneNode, TopicPolicies};
pub use peer::{LONG, Peer, catalogue, domain, hex, peer_script, python};
pub use rclpy::{RclpyNode, rclpy, test_definitions};
