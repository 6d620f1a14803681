//! Generations of ROS.

/// The two generations of ROS, which differ in built-in types, in checksums and on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Distribution {
    /// ROS 1, as of Noetic.
    Ros1,
    /// ROS 2, as of Jazzy.
    Ros2,
}
