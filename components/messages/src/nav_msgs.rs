//! `nav_msgs`: paths, odometry, occupancy grids.

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::{Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance};
use crate::std_msgs::Header;

asmotion_datum::message! {
    /// A way to go: poses in order. Without poses it means: stop.
    pub struct Path = "nav_msgs/Path" {
        /// When it was planned, and in which frame.
        pub header: Header,
        /// The poses, from the start to the goal.
        pub poses: Vec<PoseStamped>,
    }

    /// Where the robot believes to be, and how fast it goes.
    pub struct Odometry = "nav_msgs/Odometry" {
        /// When, and the frame of the pose (`odom`, or `map` where both are one).
        pub header: Header,
        /// The frame of the twist: the body, `base_link`.
        pub child_frame_id: String,
        /// In the frame of the header.
        pub pose: PoseWithCovariance,
        /// In the frame `child_frame_id`.
        pub twist: TwistWithCovariance,
    }

    /// How a grid lies in the world.
    pub struct MapMetaData = "nav_msgs/MapMetaData" {
        /// When the map was loaded.
        pub map_load_time: Time,
        /// m, side of a cell.
        pub resolution: f32,
        /// Cells along x.
        pub width: u32,
        /// Cells along y.
        pub height: u32,
        /// The pose of the lower left corner of cell (0, 0).
        pub origin: Pose,
    }

    /// A grid map; cell (x, y) is `data[y * width + x]`.
    pub struct OccupancyGrid = "nav_msgs/OccupancyGrid" {
        /// When, and in which frame.
        pub header: Header,
        /// How the grid lies.
        pub info: MapMetaData,
        /// Occupancy in percent 0..=100, or -1 for unknown; row by row from cell (0, 0).
        pub data: Vec<i8>,
    }
}

impl Path {
    /// A path through `poses`, all at one instant (nanoseconds) and in one frame.
    pub fn through(nanos: i64, frame_id: &str, poses: impl IntoIterator<Item = Pose>) -> Self {
        let header = Header::new(nanos, frame_id);
        let stamped = |pose| PoseStamped {
            header: header.clone(),
            pose,
        };
        Self {
            poses: poses.into_iter().map(stamped).collect(),
            header,
        }
    }

    /// The path that means "stop".
    pub fn stop(nanos: i64, frame_id: &str) -> Self {
        Self::through(nanos, frame_id, [])
    }
}
