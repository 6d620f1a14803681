//! Components in cycles: data flow, services, life cycle, real and virtual time.
#![allow(clippy::panic, clippy::unwrap_used, reason = "tests")]

mod addition;
mod background;
mod change;
mod commands;
mod common;
mod component_api;
mod connections;
mod cycle;
mod derived;
mod executor;
mod freeze;
mod lent;
mod live;
mod orocos;
mod safe;
mod schedule;
mod services;
mod topic_change;
