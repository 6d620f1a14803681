//! The trajectory adapter: bends the path around obstacles

mod advice;
mod bend;
mod cluster;
mod memory;
mod route;
mod trail;

pub use advice::{Advice, Adviser, Patience};
pub use bend::{Barrier, Limits};
pub use memory::Memory;
pub use trail::Trail;
