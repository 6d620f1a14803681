//! Creation of running systems from plans, and reconfiguration of a running system to another plan.

pub mod reconfigure;
mod start;

pub use start::{
    Assembled, Builtins, CoordinatorOptions, EVENTS_SIZE, Make, SUBSCRIPTION_SIZE, Standard,
    StartError, Workshop, start, start_part,
};
