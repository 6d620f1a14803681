//! A table of all messages by name, for code that learns types at run time.

use asmotion_datum::{Message, Schema};

use crate::builtin_interfaces::*;
use crate::geometry_msgs::*;
use crate::nav::*;
use crate::nav_msgs::*;
use crate::rover::*;
use crate::sensor_msgs::*;
use crate::std_msgs::*;
use crate::world::*;
use crate::youbot::*;

/// Returns the schema of a message.
pub type DescribeMessage = fn() -> &'static Schema;

/// Name and schema of every message, ordered by name.
pub const MESSAGES: &[(&str, DescribeMessage)] = &[
    row::<Time>(),
    row::<Point>(),
    row::<Pose>(),
    row::<PoseStamped>(),
    row::<PoseWithCovariance>(),
    row::<Quaternion>(),
    row::<Transform>(),
    row::<TransformStamped>(),
    row::<Twist>(),
    row::<TwistStamped>(),
    row::<TwistWithCovariance>(),
    row::<Vector3>(),
    row::<Event>(),
    row::<Obstacles>(),
    row::<Place>(),
    row::<PlanRequest>(),
    row::<MapMetaData>(),
    row::<OccupancyGrid>(),
    row::<Odometry>(),
    row::<Path>(),
    row::<Encoders>(),
    row::<WheelSpeeds>(),
    row::<LaserScan>(),
    row::<Bool>(),
    row::<Empty>(),
    row::<Float64>(),
    row::<Header>(),
    row::<Text>(),
    row::<Disc>(),
    row::<Polygon>(),
    row::<RoverDisc>(),
    row::<RoverDiscs>(),
    row::<Scene>(),
    row::<Segment>(),
    row::<Vertex>(),
    row::<Goal>(),
    row::<JointCommand>(),
    row::<JointPositions>(),
    row::<JointStatus>(),
    row::<Notice>(),
    row::<Period>(),
];

const fn row<T: Message>() -> (&'static str, DescribeMessage) {
    (T::NAME, T::schema)
}

#[cfg(test)]
mod tests {
    use super::*;
    use asmotion_datum::{Datum, Shape, cbor, json};
    use std::fmt::Debug;

    fn survives<T: Message + Debug>(message: T) {
        assert_eq!(
            cbor::decode::<T>(&cbor::encode(&message).unwrap()).unwrap(),
            message
        );
        assert_eq!(
            json::decode::<T>(&json::encode(&message).unwrap()).unwrap(),
            message
        );
        assert_eq!(Datum::of(&message).unwrap().to::<T>().unwrap(), message);
    }

    #[test]
    fn its_names_are_unique_and_in_order() {
        let names: Vec<&str> = MESSAGES.iter().map(|(name, _)| *name).collect();
        assert!(names.is_sorted_by(|a, b| a < b), "{names:?}");
        assert!(MESSAGES.iter().all(|(name, schema)| schema().name == *name));
    }

    #[test]
    fn its_fields_stand_in_the_order_of_ros() {
        for (name, fields) in [
            ("builtin_interfaces/Time", "sec nanosec"),
            ("std_msgs/Header", "stamp frame_id"),
            ("geometry_msgs/Quaternion", "x y z w"),
            ("geometry_msgs/Twist", "linear angular"),
            (
                "geometry_msgs/TransformStamped",
                "header child_frame_id transform",
            ),
            ("nav_msgs/Odometry", "header child_frame_id pose twist"),
            (
                "nav_msgs/MapMetaData",
                "map_load_time resolution width height origin",
            ),
            ("nav_msgs/OccupancyGrid", "header info data"),
            (
                "sensor_msgs/LaserScan",
                "header angle_min angle_max angle_increment time_increment scan_time range_min range_max ranges intensities",
            ),
        ] {
            let (_, schema) = MESSAGES.iter().find(|(row, _)| *row == name).unwrap();
            let Shape::Record(record) = &schema().shape else {
                panic!("{name} is no record");
            };
            let found: Vec<&str> = record.iter().map(|field| field.name.as_ref()).collect();
            assert_eq!(found.join(" "), fields);
        }
    }

    #[test]
    fn every_field_of_it_is_described() {
        for (name, schema) in MESSAGES {
            if let Shape::Record(fields) = &schema().shape {
                assert!(fields.iter().all(|field| !field.doc.is_empty()), "{name}");
            }
        }
    }

    #[test]
    fn its_zero_is_that_of_ros_2() {
        assert_eq!(Pose::default().orientation.yaw(), 0.0);
        assert_eq!(
            Quaternion::default(),
            Quaternion {
                x: 0.0,
                y: 0.0,
                z: 0.0,
                w: 1.0
            }
        );
        assert_eq!(PoseWithCovariance::default().covariance, [0.0; 36]);
        assert_eq!(Header::default(), Header::new(0, ""));
        assert_eq!(Twist::default(), Twist::planar(0.0, 0.0));
    }

    #[test]
    fn its_messages_survive_the_codecs() {
        let pose = Pose::planar(1.0, -2.5, 0.1);
        let stamped = PoseStamped {
            header: Header::new(1_700_000_000_123_456_789, "map"),
            pose,
        };
        let grid = OccupancyGrid {
            info: MapMetaData {
                resolution: 0.05,
                width: 3,
                height: 2,
                ..MapMetaData::default()
            },
            data: vec![-1, 0, 100, 65, 1, -1],
            ..OccupancyGrid::default()
        };
        let mut odometry = Odometry {
            child_frame_id: "base_link".to_owned(),
            ..Odometry::default()
        };
        odometry.pose.covariance[35] = 1.0 / 3.0;
        survives(odometry);
        survives(Path::from_poses(5, "map", [pose, Pose::default()]));
        survives(PlanRequest {
            map: grid.clone(),
            start: stamped.clone(),
            goal: stamped,
        });
        survives(grid);
        survives(Empty {});
        survives(Text {
            data: "\"ü\n".to_owned(),
        });
        survives(Event::new(-1, Event::BLOCKED, "at (1.0, 2.0)"));
        let disc = Disc {
            x: 0.1,
            y: 0.2,
            radius: 0.3,
        };
        let corner = Vertex { x: 1.0, y: 2.0 };
        survives(Obstacles {
            stamp: Time::from_nanos(1),
            points: vec![corner; 2],
        });
        survives(Scene {
            revision: 1 << 40,
            segments: vec![Segment {
                a: corner,
                b: Vertex::default(),
            }],
            discs: vec![disc],
            polygons: vec![Polygon {
                vertices: vec![corner; 3],
            }],
        });
        survives(Encoders {
            stamp: Time::default(),
            left: 1e300,
            right: -0.1,
        });
    }

    #[test]
    fn n2_a_scan_keeps_what_is_no_range() {
        let special = [f32::NEG_INFINITY, 0.1, f32::NAN, f32::INFINITY];
        let scan = LaserScan {
            range_min: 0.05,
            range_max: 8.0,
            ranges: special.to_vec(),
            ..LaserScan::default()
        };
        let bits = |scan: &LaserScan| {
            scan.ranges
                .iter()
                .map(|range| range.to_bits())
                .collect::<Vec<_>>()
        };
        let by_cbor: LaserScan = cbor::decode(&cbor::encode(&scan).unwrap()).unwrap();
        let by_json: LaserScan = json::decode(&json::encode(&scan).unwrap()).unwrap();
        assert_eq!(bits(&by_cbor), bits(&scan));
        assert_eq!(bits(&by_json), bits(&scan));
        assert_eq!(
            by_json.hits().collect::<Vec<_>>(),
            [(0.0, f64::from(0.1_f32))]
        );
    }
}
