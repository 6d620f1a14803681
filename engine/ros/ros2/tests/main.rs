//! Tests of the node: against Cyclone DDS in Python, and against a second node where Cyclone DDS cannot play the peer.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that fails says where"
)]

mod actions;
mod bytes;
mod graph;
mod malformed;
mod peer;
mod services;
mod topics;
