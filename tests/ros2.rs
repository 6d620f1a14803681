//! `asmotion ros list --ros 2` and `asmotion ros echo --ros 2`, with nodes of Cyclone DDS.

use asmotion_ros_domain::{CycloneNode, TopicPolicies, domain, python};
use assert_cmd::Command;
use serde_json::{Value, json};

/// Exit code, standard output and standard error of `asmotion ros` in a domain, on the loopback interface alone.
fn ros(arguments: &[&str], domain: u16) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
    let output = command.arg("ros").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap();
    (code, text(output.stdout), text(output.stderr))
}

#[test]
fn nodes_and_topics_of_a_domain_are_listed_with_their_quality_of_service() {
    let Some(python) = python() else { return };
    let domain = domain();
    let mut lidar = CycloneNode::start(&python, domain, "lidar");
    let mut map = CycloneNode::start(&python, domain, "map_server");
    let scan = "sensor_msgs/LaserScan";
    lidar.advertise("/scan", scan, TopicPolicies::best_effort(), 0);
    map.subscribe("/scan", scan, TopicPolicies::best_effort());
    map.advertise(
        "/map",
        "nav_msgs/OccupancyGrid",
        TopicPolicies::latched(1),
        0,
    );
    map.advertise(
        "/map/_action/status",
        "std_msgs/Empty",
        TopicPolicies::default(),
        0,
    );
    let (code, out, err) = ros(&["list", "--ros", "2"], domain);
    assert_eq!((code, &*err), (0, ""));
    let expected = "topic  type                        from                                     to
/map   nav_msgs/msg/OccupancyGrid  /map_server (reliable, transient local)  -
/scan  sensor_msgs/msg/LaserScan   /lidar (best effort, volatile)           /map_server (best effort, volatile)

service  type  node

node
/lidar
/map_server
";
    assert_eq!(out, expected);
    let (code, out, err) = ros(&["list", "--ros", "2", "--hidden"], domain);
    assert_eq!((code, &*err), (0, ""));
    assert!(out.contains("/map/_action/status"), "{out}");
    let domain_id = domain.to_string();
    let arguments = ["list", "--ros", "2", "--json", "--domain", &domain_id];
    let (code, out, _) = ros(&arguments, 0);
    assert_eq!(code, 0);
    let found: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(found["nodes"], json!(["/lidar", "/map_server"]));
    let qos = json!({
        "reliability": "reliable", "durability": "transient_local", "deadline_ms": null, "lifespan_ms": null,
    });
    let publisher = json!({ "node": "/map_server", "qos": qos, "type_hash": null });
    let expected = json!({
        "topic": "/map", "type": "nav_msgs/msg/OccupancyGrid", "publishers": [publisher], "subscribers": [],
    });
    assert_eq!(found["topics"][0], expected);
}

#[test]
fn messages_of_ros_2_are_printed_with_those_that_were_sent_before() {
    let Some(python) = python() else { return };
    let domain = domain();
    let mut talker = CycloneNode::start(&python, domain, "talker");
    talker.advertise("/said", "std_msgs/String", TopicPolicies::latched(1), 0);
    talker.publish("/said", &json!({ "data": "größe" }));
    let arguments = ["echo", "/said", "--ros", "2", "--count", "1"];
    let (code, out, err) = ros(&arguments, domain);
    assert_eq!((code, &*out, &*err), (0, "/talker {data: \"größe\"}\n", ""));
    let arguments = ["echo", "said", "--ros", "2", "--count", "1", "--json"];
    let (code, out, _) = ros(&arguments, domain);
    assert_eq!(code, 0);
    let found: Value = serde_json::from_str(&out).unwrap();
    let expected = json!({
        "topic": "/said", "source": "/talker", "sequence": 1, "type": "std_msgs/msg/String",
        "content": { "data": "größe" },
    });
    assert_eq!(found, expected);
    let arguments = ["echo", "/sad", "--ros", "2", "--for", "1"];
    let (code, out, err) = ros(&arguments, domain);
    assert_eq!((code, &*out), (1, ""));
    assert!(err.contains("no node published `/sad` within 1 s"), "{err}");
}

#[test]
fn options_belong_to_a_generation_of_ros() {
    let (code, _, err) = ros(&["list", "--ros", "2", "--master", "http://h:1"], 0);
    assert_eq!(code, 2);
    assert!(
        err.contains("`--master` is an option of ROS 1, not of `--ros 2`"),
        "{err}"
    );
    let (code, _, err) = ros(&["echo", "/x", "--domain", "3"], 0);
    assert_eq!(code, 2);
    assert!(
        err.contains("`--domain` is an option of ROS 2, not of `--ros 1`"),
        "{err}"
    );
    let (code, _, err) = ros(&["list", "--hidden"], 0);
    assert_eq!(code, 2);
    assert!(
        err.contains("`--hidden` is an option of ROS 2, not of `--ros 1`"),
        "{err}"
    );
    let (code, _, err) = ros(&["list", "--ros", "2", "--domain", "233"], 0);
    assert_eq!(code, 2);
    assert!(err.contains("233"), "{err}");
}
