//! The readers that a recording as MCAP is for.

/// The readers that a recording is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RecordingProfile {
    /// Viewers such as Foxglove and PlotJuggler: messages with a type of ROS 2 are in CDR, everything else is JSON with a JSON
    /// Schema.
    #[default]
    Viewers,
    /// Tools for bags of ROS 2, which accept CDR only (profile `ros2` of MCAP): channels have names of topics of ROS, and
    /// everything without a type of ROS 2 is JSON in a message `std_msgs/String`.
    Ros2,
}
