//! Converts between messages and the types of this crate. Heights and tilts are dropped, because the robot moves in the
//! plane.

use asmotion_messages::{Header, MapMetaData, OccupancyGrid, PoseStamped, Time};

use crate::grid::Grid;
use crate::layout::{GridLayout, GridLayoutError};
use crate::pose::{Point, Pose, heading, yaw};
use crate::scene::{ObstacleScene, RoundObstacle};

/// Converts a map message to a grid in the frame of its header.
///
/// # Errors
/// The resolution or the origin is invalid, the grid is too large, or the number of cells is not width × height.
pub fn grid(message: &OccupancyGrid) -> Result<Grid, GridLayoutError> {
    let info = &message.info;
    let layout = GridLayout::new(
        widen(info.resolution),
        info.width,
        info.height,
        pose(&info.origin),
    )?;
    Grid::with_cells(layout, message.data.clone())
}

/// Converts a grid to a map message in frame `frame_id`. `nanos`, in nanoseconds since the clock's zero, becomes both
/// the stamp and `map_load_time`, by which clients distinguish revisions of a map.
pub fn occupancy_grid(grid: &Grid, nanos: i64, frame_id: &str) -> OccupancyGrid {
    let layout = grid.layout();
    OccupancyGrid {
        header: Header::new(nanos, frame_id),
        info: MapMetaData {
            map_load_time: Time::from_nanos(nanos),
            resolution: layout.resolution() as f32,
            width: layout.width(),
            height: layout.height(),
            origin: pose_message(layout.origin()),
        },
        data: grid.cells().to_vec(),
    }
}

/// Converts a pose message to a planar pose (m, rad) in the same frame.
pub fn pose(message: &asmotion_messages::Pose) -> Pose {
    heading(point(&message.position), message.orientation.yaw())
}

/// Converts a planar pose to a message.
pub fn pose_message(pose: &Pose) -> asmotion_messages::Pose {
    asmotion_messages::Pose::planar(pose.translation.x, pose.translation.y, yaw(pose))
}

/// Converts a point message to a planar point, m.
pub fn point(message: &asmotion_messages::Point) -> Point {
    Point::new(message.x, message.y)
}

/// Converts a path message to poses, in the frame of its header.
pub fn poses(path: &asmotion_messages::Path) -> Vec<Pose> {
    path.poses
        .iter()
        .map(|stamped| pose(&stamped.pose))
        .collect()
}

/// Converts poses to a path message, all with the same stamp (nanoseconds) and in frame `frame_id`.
pub fn path<'a>(
    poses: impl IntoIterator<Item = &'a Pose>,
    nanos: i64,
    frame_id: &str,
) -> asmotion_messages::Path {
    asmotion_messages::Path::from_poses(nanos, frame_id, poses.into_iter().map(pose_message))
}

/// Converts a planar pose to a stamped message.
pub fn pose_stamped(pose: &Pose, nanos: i64, frame_id: &str) -> PoseStamped {
    PoseStamped {
        header: Header::new(nanos, frame_id),
        pose: pose_message(pose),
    }
}

/// Converts a scene message to a scene prepared for queries.
pub fn scene(message: &asmotion_messages::Scene) -> ObstacleScene {
    let segments = message.segments.iter();
    let polygons = message.polygons.iter();
    ObstacleScene::new(
        segments
            .map(|segment| [vertex(&segment.a), vertex(&segment.b)])
            .collect(),
        polygons
            .map(|polygon| polygon.vertices.iter().map(vertex).collect())
            .collect(),
        message.discs.iter().map(disc).collect(),
    )
}

/// Converts a scene to a message.
pub fn scene_message(scene: &ObstacleScene, revision: u64) -> asmotion_messages::Scene {
    asmotion_messages::Scene {
        revision,
        segments: scene
            .segments()
            .iter()
            .map(|[a, b]| asmotion_messages::Segment {
                a: vertex_message(a),
                b: vertex_message(b),
            })
            .collect(),
        discs: scene
            .discs()
            .iter()
            .map(|disc| asmotion_messages::Disc {
                x: disc.centre.x,
                y: disc.centre.y,
                radius: disc.radius,
            })
            .collect(),
        polygons: scene
            .polygons()
            .iter()
            .map(|polygon| asmotion_messages::Polygon {
                vertices: polygon.iter().map(vertex_message).collect(),
            })
            .collect(),
    }
}

/// Converts a disc message to a round obstacle.
pub fn disc(message: &asmotion_messages::Disc) -> RoundObstacle {
    RoundObstacle {
        centre: Point::new(message.x, message.y),
        radius: message.radius,
    }
}

/// Converts a vertex message to a point, m.
pub fn vertex(message: &asmotion_messages::Vertex) -> Point {
    Point::new(message.x, message.y)
}

/// Converts a point to a vertex message.
pub fn vertex_message(point: &Point) -> asmotion_messages::Vertex {
    asmotion_messages::Vertex {
        x: point.x,
        y: point.y,
    }
}

/// Converts the resolution from ROS's 32-bit float through its shortest decimal, which is the intended value: 0.05, not
/// 0.05000000074505806.
fn widen(resolution: f32) -> f64 {
    let rounded = resolution.to_string().parse();
    rounded.unwrap_or(f64::from(resolution))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::FREE;
    use crate::pose::Vector;

    #[test]
    fn a_grid_survives_the_way_there_and_back() {
        let layout = GridLayout::new(0.05, 7, 5, heading(Point::new(-1.5, 2.0), 0.3)).unwrap();
        let mut there = Grid::new(layout, FREE);
        there.cells_mut()[3] = -1;
        let message = occupancy_grid(&there, 1_500_000_000, "map");
        assert_eq!(
            (message.header.stamp.sec, message.header.frame_id.as_str()),
            (1, "map")
        );
        let back = grid(&message).unwrap();
        assert_eq!(back.layout().resolution(), 0.05);
        assert_eq!(back.cells(), there.cells());
        let corner = (back.layout().origin() * Point::new(1.0, 1.0))
            - (layout.origin() * Point::new(1.0, 1.0));
        assert!(corner.norm() < 1e-12);
    }

    #[test]
    fn a_map_that_is_none_is_refused() {
        assert!(grid(&OccupancyGrid::default()).is_err());
    }

    #[test]
    fn a_path_survives_the_way_there_and_back() {
        let there = [
            heading(Point::new(1.0, 2.0), -3.0),
            heading(Point::new(3.0, 4.0), 0.5),
        ];
        let back = poses(&path(&there, 7, "map"));
        for (one, other) in there.iter().zip(&back) {
            assert!((one.translation.vector - other.translation.vector).norm() < 1e-12);
            assert!((yaw(one) - yaw(other)).abs() < 1e-12);
        }
        assert_eq!(back.len(), 2);
    }

    #[test]
    fn a_scene_survives_the_way_there_and_back() {
        let wall = [Point::new(1.0, -1.0), Point::new(1.0, 1.0)];
        let triangle = vec![
            Point::new(5.0, 0.0),
            Point::new(6.0, 0.0),
            Point::new(5.0, 1.0),
        ];
        let pillar = RoundObstacle {
            centre: Point::new(0.0, 3.0),
            radius: 0.5,
        };
        let message = scene_message(
            &ObstacleScene::new(vec![wall], vec![triangle], vec![pillar]),
            4,
        );
        let back = scene(&message);
        assert_eq!(back.raycast(Point::origin(), Vector::x(), 9.0), Some(1.0));
        assert_eq!(scene_message(&back, 4), message);
    }
}
