//! `nav_msgs`: paths, odometry, occupancy grids.

use crate::builtin_interfaces::Time;
use crate::geometry_msgs::{Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance};
use crate::std_msgs::Header;
use asmotion_datum::DatumError;

use crate::plausible::implausible;

asmotion_datum::message! {
    /// A path: poses in order. Without poses it is an order to stop.
    pub struct Path = "nav_msgs/Path" {
        /// Time of planning, and frame of the poses.
        pub header: Header,
        /// The poses, from the start to the goal.
        pub poses: Vec<PoseStamped>,
    }

    /// The estimated pose and velocity of the robot.
    pub struct Odometry = "nav_msgs/Odometry" {
        /// Time of the estimate, and frame of the pose (`odom`, or `map` if both are the same).
        pub header: Header,
        /// Frame of the twist: the body, `base_link`.
        pub child_frame_id: String,
        /// Pose in the frame of the header.
        pub pose: PoseWithCovariance,
        /// Velocity in the frame `child_frame_id`.
        pub twist: TwistWithCovariance,
    }

    /// Size, resolution and origin of a grid map.
    pub struct MapMetaData = "nav_msgs/MapMetaData" {
        /// Time at which the map was loaded.
        pub map_load_time: Time,
        /// Side length of a cell, m.
        pub resolution: f32,
        /// Number of cells along x.
        pub width: u32,
        /// Number of cells along y.
        pub height: u32,
        /// Pose of the lower left corner of cell (0, 0).
        pub origin: Pose,
    }

    /// A grid map; cell (x, y) is `data[y * width + x]`.
    pub struct OccupancyGrid = "nav_msgs/OccupancyGrid", check = check_grid {
        /// Time of the map, and its frame.
        pub header: Header,
        /// Size, resolution and origin.
        pub info: MapMetaData,
        /// Occupancy in percent 0..=100, or -1 for unknown; row by row from cell (0, 0).
        pub data: Vec<i8>,
    }
}

impl Path {
    /// A path through `poses`, all with the same stamp (nanoseconds) and frame.
    pub fn from_poses(nanos: i64, frame_id: &str, poses: impl IntoIterator<Item = Pose>) -> Self {
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

    /// A path without poses, which is an order to stop.
    pub fn stop(nanos: i64, frame_id: &str) -> Self {
        Self::from_poses(nanos, frame_id, [])
    }
}

/// Limits of the side length of a cell, m.
const RESOLUTIONS: std::ops::RangeInclusive<f32> = 1e-3..=1e3;
/// Limit of the number of cells.
const MOST_CELLS: u64 = 100_000_000;

/// Accepts a grid without cells, which is no map, whatever its resolution.
fn check_grid(grid: &OccupancyGrid) -> Result<(), DatumError> {
    let MapMetaData {
        resolution,
        width,
        height,
        ..
    } = grid.info;
    let cells = u64::from(width) * u64::from(height);
    let problem = if cells != grid.data.len() as u64 {
        Some(("data", "not as many cells as width times height"))
    } else if cells > MOST_CELLS {
        Some(("data", "too many cells"))
    } else if cells > 0 && !RESOLUTIONS.contains(&resolution) {
        Some(("info.resolution", "not between 0.001 m and 1000 m"))
    } else {
        None
    };
    problem.map_or(Ok(()), |(field, problem)| Err(implausible(field, problem)))
}
