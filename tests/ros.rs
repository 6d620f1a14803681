//! `asmotion ros`, and the messages of this build as ROS defines them.

use asmotion_messages::MESSAGES;
use asmotion_ros_interface::{Catalogue, Distribution, InterfaceName};
use assert_cmd::Command;

/// Exit code, standard output and standard error of `asmotion ros`.
fn ros(arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    let output = command.arg("ros").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap();
    (code, text(output.stdout), text(output.stderr))
}

/// The first difference between a message of this build and the one of ROS with this name.
fn difference(catalogue: &Catalogue, name: &str) -> Option<Option<String>> {
    let parsed: InterfaceName = name.parse().ok()?;
    catalogue.interface(&parsed).ok()?;
    let theirs = catalogue.schema(&parsed).unwrap();
    let (_, own) = MESSAGES.iter().find(|(own, _)| *own == name).unwrap();
    Some(own().compare(&theirs).err().map(|it| it.to_string()))
}

#[test]
fn messages_with_names_of_ros_2_have_its_fields() {
    let jazzy = Catalogue::included(Distribution::Ros2);
    let mut compared = 0;
    for (name, _) in MESSAGES {
        if let Some(difference) = difference(&jazzy, name) {
            compared += 1;
            assert_eq!(difference, None, "{name}");
        }
    }
    assert!(compared > 15, "{compared}");
}

#[test]
fn types_are_printed_as_json() {
    let lines = |arguments: &[&str]| -> Vec<serde_json::Value> {
        let (code, out, error) = ros(arguments);
        assert_eq!(code, 0, "{error}");
        let lines = out.lines();
        lines
            .map(|line| serde_json::from_str(line).unwrap())
            .collect()
    };
    let shown = lines(&["types", "std_srvs/SetBool", "--ros", "1", "--json"]);
    assert_eq!(
        shown,
        [serde_json::json!({
            "name": "std_srvs/srv/SetBool", "kind": "srv", "definition": "bool data\n---\nbool success\nstring message\n",
            "md5": "09fb03525b03e7ea1fd3992bafd87e16", "type_hash": null, "message_of_build": null, "difference": null,
        })]
    );
    let listed = lines(&["types", "nav2_msgs/action/S", "--json"]);
    assert_eq!(listed.len(), 2);
    assert_eq!(listed[1]["name"], "nav2_msgs/action/Spin");
    let hash = listed[1]["type_hash"].as_str().unwrap();
    assert!(hash.starts_with("RIHS01_"), "{hash}");
}

#[test]
fn types_are_listed_and_shown() {
    let (code, out, _) = ros(&["types", "nav2_msgs/action/S"]);
    assert_eq!(code, 0);
    assert_eq!(out, "nav2_msgs/action/SmoothPath\nnav2_msgs/action/Spin\n");
    let (code, out, _) = ros(&["types", "geometry_msgs/Twist"]);
    assert_eq!(code, 0);
    let shown = "geometry_msgs/msg/Twist
  geometry_msgs/Vector3 linear
  geometry_msgs/Vector3 angular
type hash RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a
the message `geometry_msgs/Twist` of this build has the same fields
";
    assert_eq!(out, shown);
    let (code, out, _) = ros(&["types", "std_msgs/Header", "--ros", "1"]);
    assert_eq!(code, 0);
    let shown = "std_msgs/msg/Header
  uint32 seq
  time stamp
  string frame_id
MD5 sum 2176decaecbce78abc3b96ef049fabed
the message `std_msgs/Header` of this build differs: field `stamp` here, field `seq` there
";
    assert_eq!(out, shown);
}

#[test]
fn r7_types_that_do_not_exist_are_an_error() {
    let (code, _, err) = ros(&["types", "nav2_msgs/Spn"]);
    assert_eq!(code, 1);
    let message =
        "no interface of ROS has `nav2_msgs/Spn` in its name; did you mean `nav2_msgs/Spin`?";
    assert!(err.contains(message), "{err}");
    let (code, _, err) = ros(&["types", "--definitions", "/does/not/exist"]);
    assert_eq!(code, 2);
    assert!(err.contains("/does/not/exist"), "{err}");
}
