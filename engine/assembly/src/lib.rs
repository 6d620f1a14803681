//! Plans become running systems: components are made and joined, and a running system is brought to another plan.

pub mod reconfigure;
mod start;

pub use start::{
    Assembled, Make, SUBSCRIPTION_SIZE, Standard, StartError, Workshop, start, start_part,
};
