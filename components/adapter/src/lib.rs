//! The trajectory adapter: bends the path around obstacles.
//!
//! [`Memory`] keeps points the laser has seen, the path is bent within [`Limits`], [`Adviser`] decides,
//! [`TrajectoryAdapter`] is the component.

mod adapter;
mod advice;
mod bend;
mod cluster;
mod memory;
mod news;
mod route;
mod trail;

pub use adapter::TrajectoryAdapter;
pub use advice::{Advice, Adviser, Cause, Patience};
pub use bend::{Barrier, Limits};
pub use memory::Memory;
pub use trail::Trail;
