//! The trajectory adapter: bends the path around obstacles.
//!
//! What the laser saw is remembered ([`Memory`]), the path is bent within [`Limits`], [`Adviser`] says what to do,
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
