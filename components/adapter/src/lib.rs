//! The trajectory adapter: bends the path around obstacles.
//!
//! [`ScanMemory`] keeps points the laser has seen, the path is bent within [`BendLimits`], [`Adviser`] decides,
//! [`TrajectoryAdapter`] is the component.

mod adapter;
mod advice;
mod bend;
mod bend_limits;
mod cluster;
mod memory;
mod obstacle_reports;
mod route;

pub use adapter::TrajectoryAdapter;
pub use advice::{Advice, Adviser, BlockedCause, Patience};
pub use bend::Barrier;
pub use bend_limits::BendLimits;
pub use memory::ScanMemory;

/// Protocol of the trajectory adapter: what it sends, depending on what it receives.
pub const PROTOCOL: &str = include_str!("../protocol.asm");
