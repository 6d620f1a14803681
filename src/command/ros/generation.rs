//! The generations of ROS.

use clap::ValueEnum;

/// A generation of ROS.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Generation {
    /// ROS 1, as of Noetic
    #[value(name = "1")]
    One,
    /// ROS 2, as of Jazzy
    #[value(name = "2")]
    Two,
}
