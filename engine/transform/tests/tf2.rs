//! Look-ups in arbitrary trees, compared with those of tf2.

use std::io::Write as _;
use std::process::{Command, Stdio};

use asmotion_datum::Datum;
use asmotion_skip::TF2;
use asmotion_transform::{
    MessageTransform, RigidMotion, StampedMotion, TransformBuffer, TransformFailure,
    UnitQuaternion, Vector3,
};
use serde_json::{Value, json};

/// Python of the system, for which Debian installs tf2.
const PYTHON: &str = "/usr/bin/python3";

fn has_tf2() -> bool {
    let mut command = Command::new(PYTHON);
    let tried = command
        .args(["-c", "import tf2_py, tf2_geometry_msgs"])
        .stderr(Stdio::null());
    let is_installed = tried.status().is_ok_and(|it| it.success());
    if !is_installed {
        TF2.skip();
    }
    is_installed
}

/// Arbitrary numbers, equal in every run.
struct Arbitrary(u64);

impl Arbitrary {
    fn next(&mut self) -> u64 {
        // Steele, Lea and Flood: SplitMix
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, bound: u64) -> u64 {
        self.next() % bound
    }

    /// Between -1 and 1.
    fn number(&mut self) -> f64 {
        self.below(2_000_001) as f64 / 1e6 - 1.0
    }

    fn rotation(&mut self) -> [f64; 4] {
        loop {
            let parts = [self.number(), self.number(), self.number(), self.number()];
            let length = parts.iter().map(|it| it * it).sum::<f64>().sqrt();
            if length > 0.1 {
                return parts.map(|it| it / length);
            }
        }
    }
}

/// Small, because the Python of tf2 passes times as numbers of seconds in floating point.
const START: i64 = 1_000_000_000;

/// Frames of two trees; a frame has a parent among those before it, and a few get another one.
fn case(arbitrary: &mut Arbitrary) -> (Vec<Value>, Vec<Value>) {
    let name = |number: u64| format!("frame{number}");
    let (frames, mut transforms) = (4 + arbitrary.below(8), Vec::new());
    for child in (1..frames).filter(|child| *child != 3) {
        let parent = arbitrary.below(child);
        let is_static = arbitrary.below(3) == 0;
        let count = if is_static {
            1
        } else {
            1 + arbitrary.below(20)
        };
        let mut stamp = START + arbitrary.below(200) as i64 * 1_000_000;
        let parent_later = if arbitrary.below(5) == 0 {
            arbitrary.below(child)
        } else {
            parent
        };
        for index in 0..count {
            let parent = if index > count / 2 {
                parent_later
            } else {
                parent
            };
            let [x, y, z, w] = arbitrary.rotation();
            let offset = [arbitrary.number(), arbitrary.number(), arbitrary.number()];
            let numbers = [offset[0], offset[1], offset[2], x, y, z, w];
            transforms.push(json!([
                name(parent),
                name(child),
                stamp,
                numbers,
                is_static
            ]));
            stamp += 1_000_000 + arbitrary.below(100_000_000) as i64;
        }
    }
    let lookups = (0..40).map(|_| {
        // one frame more than there are
        let (target, source) = (arbitrary.below(frames + 1), arbitrary.below(frames + 1));
        let stamp = match arbitrary.below(6) {
            0 => 0,
            _ => START + arbitrary.below(900_000_000) as i64,
        };
        json!([name(target), name(source), stamp])
    });
    let lookups = lookups.collect();
    (transforms, lookups)
}

fn tf2(cases: &Value) -> Vec<Value> {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/tf2.py");
    let mut command = Command::new(PYTHON);
    command
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(cases.to_string().as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn filled(transforms: &[Value]) -> TransformBuffer {
    let mut buffer = TransformBuffer::default();
    for transform in transforms {
        let number = |index: usize| transform[3][index].as_f64().unwrap();
        let motion = RigidMotion {
            rotation: UnitQuaternion::normalized([3, 4, 5, 6].map(number)).unwrap(),
            offset: Vector3::new(number(0), number(1), number(2)),
        };
        let text = |index: usize| transform[index].as_str().unwrap();
        let stamp = transform[2].as_i64().unwrap();
        let new = StampedMotion::new(text(0), text(1), stamp, motion);
        buffer.insert(new, transform[4].as_bool().unwrap()).unwrap();
    }
    buffer
}

/// The pose, the point and the direction of `tf2.py` in the target.
fn moved(
    buffer: &TransformBuffer,
    target: &str,
    source: &str,
    stamp: i64,
) -> Result<Vec<f64>, TransformFailure> {
    let record = |names: &'static [&'static str], numbers: &[f64]| {
        let numbers = numbers.iter().map(|it| Datum::Float(*it));
        Datum::record(names.iter().copied().zip(numbers))
    };
    let (xyz, xyzw): (&[&str], &[&str]) = (&["x", "y", "z"], &["x", "y", "z", "w"]);
    let point = record(xyz, &[1.0, -2.0, 0.5]);
    let orientation = record(xyzw, &[0.6, 0.0, 0.0, 0.8]);
    let pose = Datum::record([("position", point.clone()), ("orientation", orientation)]);
    let parts = [
        ("geometry_msgs/PoseStamped", "pose", pose),
        ("geometry_msgs/PointStamped", "point", point.clone()),
        ("geometry_msgs/Vector3Stamped", "vector", point),
    ];
    let mut all = Vec::new();
    for (kind, field, value) in parts {
        let time = [
            ("sec", Datum::Int(stamp / 1_000_000_000)),
            ("nanosec", Datum::Int(stamp % 1_000_000_000)),
        ];
        let header = [
            ("stamp", Datum::record(time)),
            ("frame_id", Datum::text(source)),
        ];
        let message = Datum::record([("header", Datum::record(header)), (field, value)]);
        let found = MessageTransform::new(kind, target)
            .unwrap()
            .apply(&message, buffer)?;
        let mut read = |path: &str, names: &[&str]| {
            let number = |name: &&str| {
                found
                    .get(&format!("{path}.{name}"))
                    .unwrap()
                    .as_float()
                    .unwrap()
            };
            all.extend(names.iter().map(number));
        };
        match field {
            "pose" => {
                read("pose.position", xyz);
                read("pose.orientation", xyzw);
            }
            field => read(field, xyz),
        }
    }
    Ok(all)
}

fn exception(failure: &TransformFailure) -> &'static str {
    match failure {
        TransformFailure::UnknownFrame { .. } => "LookupException",
        TransformFailure::Disconnected { .. } | TransformFailure::Circle { .. } => {
            "ConnectivityException"
        }
        TransformFailure::Past { .. } | TransformFailure::Future { .. } => "ExtrapolationException",
        TransformFailure::NoFrame | TransformFailure::Cloud => "",
    }
}

/// A quaternion and its negative are the same rotation.
fn is_close(here: &[f64], there: &[f64]) -> bool {
    let close =
        |a: &[f64], b: &[f64], sign: f64| a.iter().zip(b).all(|(a, b)| (a - sign * b).abs() < 1e-6);
    here.len() == there.len()
        && close(&here[..3], &there[..3], 1.0)
        && (close(&here[3..7], &there[3..7], 1.0) || close(&here[3..7], &there[3..7], -1.0))
        && close(&here[7..], &there[7..], 1.0)
}

#[test]
fn look_ups_in_arbitrary_trees_equal_those_of_tf2() {
    if !has_tf2() {
        return;
    }
    let (mut arbitrary, mut found_at_all, mut failed) = (Arbitrary(7), 0, [0; 3]);
    let cases: Vec<_> = (0..60).map(|_| case(&mut arbitrary)).collect();
    let objects = cases.iter();
    let objects = objects
        .map(|(transforms, lookups)| json!({ "transforms": transforms, "lookups": lookups }));
    let mut answers = tf2(&objects.collect()).into_iter();
    for (round, (transforms, lookups)) in cases.iter().enumerate() {
        let buffer = filled(transforms);
        for lookup in lookups {
            let there = answers.next().unwrap();
            let text = |index: usize| lookup[index].as_str().unwrap();
            let (target, source, stamp) = (text(0), text(1), lookup[2].as_i64().unwrap());
            // here, a message that is in the frame already stays as it is
            if target == source {
                continue;
            }
            let here = moved(&buffer, target, source, stamp);
            let place = format!("round {round}: {lookup}: {here:?}, tf2: {there}");
            match (&here, there["error"].as_str()) {
                (Ok(numbers), None) => {
                    let of_tf2 = there["numbers"].as_array().unwrap();
                    let of_tf2: Vec<_> = of_tf2.iter().map(|it| it.as_f64().unwrap()).collect();
                    assert!(is_close(numbers, &of_tf2), "{place}");
                    let time = buffer.look_up(target, source, stamp).unwrap().stamp;
                    assert_eq!(Some(time), there["stamp"].as_i64(), "{place}");
                    found_at_all += 1;
                }
                (Err(failure), Some(error)) => {
                    assert_eq!(exception(failure), error, "{place}");
                    let kinds = [
                        "LookupException",
                        "ConnectivityException",
                        "ExtrapolationException",
                    ];
                    failed[kinds.iter().position(|kind| *kind == error).unwrap()] += 1;
                }
                _ => panic!("{place}"),
            }
        }
    }
    // every outcome has occurred often
    assert!(
        found_at_all > 300 && failed.iter().all(|count| *count > 50),
        "{found_at_all} {failed:?}"
    );
}
