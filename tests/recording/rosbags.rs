//! Recordings for tools of ROS 2, read by the Python package `rosbags`.

use std::process::Command;

use asmotion_recording::{RecordingItem, RunReader};
use serde_json::Value;

use super::{asmotion, output, python, steps};

/// The last message of a channel, as JSON, and the number of messages.
fn last(file: &std::path::Path, wanted: &str) -> (usize, Value) {
    let items = RunReader::open(file).unwrap();
    let messages = items.filter_map(|item| match item {
        RecordingItem::Message { channel, data, .. } if channel == wanted => Some(data),
        RecordingItem::Message { .. }
        | RecordingItem::Text { .. }
        | RecordingItem::Step { .. }
        | RecordingItem::End(_)
        | RecordingItem::Cut(_) => None,
    });
    let messages: Vec<_> = messages.collect();
    let last = messages.last().unwrap_or_else(|| panic!("{wanted}"));
    (
        messages.len(),
        serde_json::from_str(&last.json().unwrap()).unwrap(),
    )
}

#[test]
fn d3_tools_of_ros_2_read_everything_in_a_recording_that_is_for_them() {
    let Some(python) = python() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str, more: &[&str]| {
        let file = folder.path().join(name);
        let path = file.display().to_string();
        let (code, said) = output(asmotion(&["--record", &path]).args(more));
        assert_eq!(code, Some(0), "{said}");
        file
    };
    let bag = record("bag.mcap", &["--record-for", "ros2"]);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/recording/bag.py");
    let read = Command::new(python).arg(script).arg(&bag).output().unwrap();
    let errors = String::from_utf8_lossy(&read.stderr);
    assert!(read.status.success(), "{errors}");
    let content: Value = serde_json::from_slice(&read.stdout).unwrap();
    let counts = &content["counts"];
    // the same messages as in a recording for viewers, where our own reader finds them under the same names
    let viewed = record("run.mcap", &[]);
    let (count, odometry) = last(&viewed, "topic/odom");
    assert_eq!(counts["/odom nav_msgs/msg/Odometry"], count, "{counts}");
    assert_eq!(last(&bag, "topic/odom"), (count, odometry.clone()));
    let position = &odometry["pose"]["pose"]["position"];
    assert_eq!(
        content["position"],
        serde_json::json!([position["x"], position["y"]])
    );
    assert_eq!(content["frame"], odometry["header"]["frame_id"]);
    assert_eq!(content["covariances"], 36);
    assert!(content["age_s"].as_f64().unwrap().abs() < 0.1, "{content}");
    let (count, scan) = last(&viewed, "port/LaserDriver.scan");
    assert_eq!(
        counts["/port/LaserDriver/scan sensor_msgs/msg/LaserScan"],
        count
    );
    assert_eq!(content["ranges"], scan["ranges"].as_array().unwrap().len());
    assert!(content["nearest"].as_f64().unwrap() > 0.0);
    // what has no type of ROS is a text
    let (read_steps, cut) = steps(&bag);
    assert_eq!((read_steps, cut), steps(&viewed));
    assert_eq!(
        counts["/asm/ASMCoordinator/step std_msgs/msg/String"],
        read_steps
    );
    let (count, event) = last(&viewed, "events");
    assert_eq!(counts["/events std_msgs/msg/String"], count);
    assert_eq!(last(&bag, "events"), (count, event));
}

#[test]
fn a_table_is_for_no_tool_of_ros() {
    let (code, said) = output(&mut asmotion(&[
        "--record",
        "run.csv",
        "--record-for",
        "ros2",
    ]));
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("`--record-for` has no effect on a table"),
        "{said}"
    );
    assert!(!std::path::Path::new("run.csv").exists());
}
