//! Messages in another frame.

use std::sync::Arc;

use asmotion_datum::{Datum, Numbers};
use asmotion_transform::{
    MessageTransform, RigidMotion, StampedMotion, TransformBuffer, TransformFailure,
    UnitQuaternion, Vector3,
};
use serde_json::{Value, json};

/// `sensor` stands at (1, 2, 3) of `map`, turned to the left by 90°.
fn buffer() -> TransformBuffer {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let motion = RigidMotion {
        rotation: UnitQuaternion::normalized([0.0, 0.0, half, half]).unwrap(),
        offset: Vector3::new(1.0, 2.0, 3.0),
    };
    let mut buffer = TransformBuffer::default();
    buffer
        .insert(StampedMotion::new("map", "sensor", 0, motion), true)
        .unwrap();
    let moved = RigidMotion::translation(10.0, 0.0, 0.0);
    for stamp in [5_000_000_000, 6_000_000_000] {
        buffer
            .insert(StampedMotion::new("map", "odom", stamp, moved), false)
            .unwrap();
    }
    buffer
}

/// Rounds, because a quarter turn is not exact.
fn datum(value: &Value) -> Datum {
    match value {
        Value::Object(fields) => {
            let fields = fields.iter();
            Datum::record(fields.map(|(name, value)| (name.clone(), datum(value))))
        }
        Value::Array(elements) => Datum::List(elements.iter().map(datum).collect()),
        Value::String(text) => Datum::text(text.as_str()),
        Value::Bool(flag) => Datum::Bool(*flag),
        Value::Number(number) => match number.as_i64() {
            Some(number) => Datum::Int(number),
            None => Datum::Float(number.as_f64().unwrap()),
        },
        Value::Null => Datum::Null,
    }
}

fn header(frame: &str, sec: i64) -> Value {
    json!({ "stamp": { "sec": sec, "nanosec": 0 }, "frame_id": frame })
}

fn point(x: f64, y: f64, z: f64) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

fn pose(x: f64, y: f64) -> Value {
    json!({ "position": point(x, y, 0.0), "orientation": { "x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0 } })
}

fn transformed(kind: &str, message: &Datum) -> Result<Datum, TransformFailure> {
    MessageTransform::new(kind, "map")
        .unwrap()
        .apply(message, &buffer())
}

fn numbers(message: &Datum, path: &str, names: &[&str]) -> Vec<f64> {
    let number = |name: &&str| message.get(&format!("{path}.{name}"))?.as_float();
    let found = names.iter().map(|name| number(name).unwrap());
    found.map(rounded).collect()
}

fn rounded(number: f64) -> f64 {
    (number * 1e9).round() / 1e9
}

const XYZ: [&str; 3] = ["x", "y", "z"];

fn frame(message: &Datum, path: &str) -> String {
    message.get(path).unwrap().as_text().unwrap().to_owned()
}

#[test]
fn points_move_and_directions_turn() {
    let message = datum(&json!({ "header": header("sensor", 7), "point": point(1.0, 0.0, 0.0) }));
    let found = transformed("geometry_msgs/PointStamped", &message).unwrap();
    assert_eq!(numbers(&found, "point", &XYZ), [1.0, 3.0, 3.0]);
    assert_eq!(frame(&found, "header.frame_id"), "map");
    assert_eq!(found.get("header.stamp"), message.get("header.stamp"));
    let message = datum(&json!({ "header": header("/sensor", 7), "vector": point(1.0, 0.0, 0.0) }));
    let found = transformed("geometry_msgs/msg/Vector3Stamped", &message).unwrap();
    assert_eq!(numbers(&found, "vector", &XYZ), [0.0, 1.0, 0.0]);
    let polygon = json!({ "points": [point(1.0, 0.0, 0.0), point(0.0, 1.0, 0.0)] });
    let message = datum(&json!({ "header": header("sensor", 7), "polygon": polygon }));
    let found = transformed("geometry_msgs/PolygonStamped", &message).unwrap();
    assert_eq!(numbers(&found, "polygon.points.1", &XYZ), [0.0, 2.0, 3.0]);
}

#[test]
fn poses_and_covariances_move() {
    let mut covariance = vec![0.0; 36];
    // sure along y of the sensor, unknown along x, and yaw
    (covariance[0], covariance[7], covariance[35]) = (f64::INFINITY, 0.25, 0.5);
    let body = json!({ "pose": pose(2.0, 0.0), "covariance": [] });
    let message = json!({
        "header": header("sensor", 7), "child_frame_id": "base", "pose": body,
        "twist": { "linear": point(1.0, 0.0, 0.0) },
    });
    let mut message = datum(&message);
    let Datum::Record(fields) = &mut message else {
        panic!()
    };
    let Datum::Record(body) = &mut fields.iter_mut().find(|it| it.0 == "pose").unwrap().1 else {
        panic!()
    };
    let packed = Datum::Numbers(Numbers::F64(Arc::from(covariance)));
    body.iter_mut().find(|it| it.0 == "covariance").unwrap().1 = packed;
    let found = transformed("nav_msgs/Odometry", &message).unwrap();
    assert_eq!(numbers(&found, "pose.pose.position", &XYZ), [1.0, 4.0, 3.0]);
    assert_eq!(
        numbers(&found, "pose.pose.orientation", &["z", "w"]),
        [rounded(std::f64::consts::FRAC_1_SQRT_2); 2]
    );
    let covariance = found.get("pose.covariance").unwrap();
    let entry = |index| covariance.element(index).unwrap().as_float().unwrap();
    assert!((entry(0) - 0.25).abs() < 1e-9 || entry(0).is_infinite());
    assert_eq!((entry(7), entry(35)), (f64::INFINITY, 0.5));
    // the velocity is in the frame of the robot
    assert_eq!(
        (found.get("twist"), found.get("child_frame_id")),
        (message.get("twist"), message.get("child_frame_id"))
    );
}

#[test]
fn poses_of_a_path_can_have_frames_of_their_own() {
    let poses = json!([
        { "header": header("", 0), "pose": pose(1.0, 0.0) },
        { "header": header("sensor", 99), "pose": pose(2.0, 0.0) },
        { "header": header("odom", 99), "pose": pose(3.0, 0.0) },
    ]);
    let message = datum(&json!({ "header": header("sensor", 5), "poses": poses }));
    let found = transformed("nav_msgs/Path", &message).unwrap();
    let at = |index| numbers(&found, &format!("poses.{index}.pose.position"), &XYZ);
    assert_eq!(
        [at(0), at(1), at(2)],
        [[1.0, 3.0, 3.0], [1.0, 4.0, 3.0], [13.0, 0.0, 0.0]]
    );
    for index in 0..3 {
        assert_eq!(
            frame(&found, &format!("poses.{index}.header.frame_id")),
            "map"
        );
    }
    let sec = found.get("poses.1.header.stamp.sec").unwrap().as_int();
    assert_eq!(sec, Some(99));
}

#[test]
fn a_message_without_time_takes_the_latest_transform_and_its_time() {
    let message = datum(&json!({ "header": header("odom", 0), "pose": pose(1.0, 0.0) }));
    let found = transformed("geometry_msgs/PoseStamped", &message).unwrap();
    assert_eq!(found.get("header.stamp.sec").unwrap().as_int(), Some(6));
    assert_eq!(numbers(&found, "pose.position", &XYZ), [11.0, 0.0, 0.0]);
}

#[test]
fn an_orientation_without_length_stays_so() {
    let nothing = json!({ "x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0 });
    let poses = json!([{ "position": point(1.0, 0.0, 0.0), "orientation": nothing }]);
    let message = datum(&json!({ "header": header("sensor", 7), "poses": poses }));
    let found = transformed("geometry_msgs/PoseArray", &message).unwrap();
    let names = ["x", "y", "z", "w"];
    assert_eq!(numbers(&found, "poses.0.orientation", &names), [0.0; 4]);
    assert_eq!(numbers(&found, "poses.0.position", &XYZ), [1.0, 3.0, 3.0]);
}

/// A cloud of two rows with two points and a colour each, and padding.
fn cloud(is_big_endian: bool, is_double: bool) -> (Datum, usize) {
    let size = if is_double { 8 } else { 4 };
    let (step, row_step) = (3 * size + 4, 2 * (3 * size + 4) + 5);
    let mut bytes = vec![0xee; 2 * row_step];
    for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        for (index, number) in [row as f64, column as f64, 0.5].into_iter().enumerate() {
            let at = row * row_step + column * step + index * size;
            let place = &mut bytes[at..at + size];
            match (is_double, is_big_endian) {
                (true, true) => place.copy_from_slice(&number.to_be_bytes()),
                (true, false) => place.copy_from_slice(&number.to_le_bytes()),
                (false, true) => place.copy_from_slice(&(number as f32).to_be_bytes()),
                (false, false) => place.copy_from_slice(&(number as f32).to_le_bytes()),
            }
        }
    }
    let kind = if is_double { 8 } else { 7 };
    let field = |name: &str, offset: usize, kind: i64| json!({ "name": name, "offset": offset, "datatype": kind, "count": 1 });
    let fields = [
        field("rgb", 3 * size, 6),
        field("x", 0, kind),
        field("y", size, kind),
        field("z", 2 * size, kind),
    ];
    let mut message = datum(&json!({
        "header": header("sensor", 7), "height": 2, "width": 2, "fields": fields, "is_bigendian": is_big_endian,
        "point_step": step, "row_step": row_step, "data": [], "is_dense": true,
    }));
    let Datum::Record(entries) = &mut message else {
        panic!()
    };
    entries.iter_mut().find(|it| it.0 == "data").unwrap().1 = Datum::Bytes(bytes.into());
    (message, row_step)
}

#[test]
fn clouds_of_all_layouts_move() {
    for (is_big, is_double) in [(false, false), (false, true), (true, false), (true, true)] {
        let (message, row_step) = cloud(is_big, is_double);
        let found = transformed("sensor_msgs/PointCloud2", &message).unwrap();
        let Datum::Bytes(bytes) = found.get("data").unwrap().into_owned() else {
            panic!()
        };
        let size = if is_double { 8 } else { 4 };
        // row 1, column 1: (1, 1, 0.5) in the frame of the sensor
        let start = row_step + 3 * size + 4;
        let number = |index: usize| {
            let place = &bytes[start + index * size..start + (index + 1) * size];
            match (is_double, is_big) {
                (true, true) => f64::from_be_bytes(place.try_into().unwrap()),
                (true, false) => f64::from_le_bytes(place.try_into().unwrap()),
                (false, true) => f32::from_be_bytes(place.try_into().unwrap()).into(),
                (false, false) => f32::from_le_bytes(place.try_into().unwrap()).into(),
            }
        };
        let rounded = [0, 1, 2].map(|index| (number(index) * 1e5).round() / 1e5);
        assert_eq!(rounded, [0.0, 3.0, 3.5], "{is_big} {is_double}");
        // colours and padding stay
        assert_eq!(
            bytes.iter().filter(|byte| **byte == 0xee).count(),
            4 * 4 + 2 * 5
        );
    }
}

#[test]
fn clouds_that_lie_about_their_layout_are_refused() {
    let (message, _) = cloud(false, false);
    let with = |name: &str, value: Datum| {
        let mut changed = message.clone();
        let Datum::Record(entries) = &mut changed else {
            panic!()
        };
        entries.iter_mut().find(|it| it.0 == name).unwrap().1 = value;
        transformed("sensor_msgs/PointCloud2", &changed)
    };
    let huge = Datum::Int(u32::MAX.into());
    for name in ["height", "width", "point_step", "row_step"] {
        assert_eq!(
            with(name, huge.clone()),
            Err(TransformFailure::Cloud),
            "{name}"
        );
    }
    assert_eq!(
        with("point_step", Datum::Int(0)),
        Err(TransformFailure::Cloud)
    );
    assert_eq!(
        with("point_step", Datum::Int(11)),
        Err(TransformFailure::Cloud)
    );
    assert_eq!(
        with("fields", Datum::List(Vec::new())),
        Err(TransformFailure::Cloud)
    );
    let empty = with("width", Datum::Int(0)).unwrap();
    assert_eq!(frame(&empty, "header.frame_id"), "map");
}

#[test]
fn what_cannot_be_transformed_is_refused_before_it_arrives() {
    let error =
        |kind: &str, frame: &str| MessageTransform::new(kind, frame).unwrap_err().to_string();
    assert_eq!(
        error("geometry_msgs/TwistStamped", "map"),
        "messages of `geometry_msgs/TwistStamped` cannot be transformed into another frame"
    );
    for frame in ["", "/map", "the map"] {
        let text = error("nav_msgs/Path", frame);
        assert_eq!(text, format!("`{frame}` is not the name of a frame"));
    }
    let message = datum(&json!({ "header": header("", 7), "pose": pose(1.0, 0.0) }));
    let found = transformed("geometry_msgs/PoseStamped", &message);
    assert_eq!(found, Err(TransformFailure::NoFrame));
    let found = transformed("geometry_msgs/PoseStamped", &Datum::Null);
    assert_eq!(found, Err(TransformFailure::NoFrame));
}
