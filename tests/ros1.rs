//! `asmotion ros list` and `asmotion ros echo`, with a master and nodes of ROS 1.

use asmotion_ros_master::{Master, all, notifier, service_type, topic_type};
use assert_cmd::Command;

/// Exit code, standard output and standard error of `asmotion ros`, whose master is the one of the environment.
fn ros(arguments: &[&str], port: u16) -> (i32, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.env("ROS_MASTER_URI", format!("http://127.0.0.1:{port}/"));
    command
        .env_remove("ROS_HOSTNAME")
        .env("ROS_IP", "127.0.0.1");
    let output = command.arg("ros").args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let code = output.status.code().unwrap();
    (code, text(output.stdout), text(output.stderr))
}

#[test]
fn nodes_topics_and_services_are_listed() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot");
    let of = topic_type("std_msgs/Bool");
    let _publisher = node.node.publisher("stop", of.clone(), 1, false).unwrap();
    let other = master.node("/panel");
    let queue = all(1);
    let _subscription = other.node.subscribe("stop", Some(of), queue, notifier());
    let of = service_type("std_srvs", "Trigger");
    let _served = node.node.serve("~reset", of, 1, notifier()).unwrap();
    node.registered();
    other.registered();
    let (code, out, err) = ros(&["list"], master.port);
    assert_eq!((code, &*err), (0, ""));
    let expected = "topic  type           from    to
/stop  std_msgs/Bool  /robot  /panel

service       node
/robot/reset  /robot
";
    assert_eq!(out, expected);
    let (code, out, _) = ros(&["list", "--json"], master.port);
    assert_eq!(code, 0);
    let found: serde_json::Value = serde_json::from_str(&out).unwrap();
    let expected = serde_json::json!({
        "nodes": ["/panel", "/robot"],
        "topics": [{
            "topic": "/stop", "type": "std_msgs/Bool",
            "publishers": ["/robot"], "subscribers": ["/panel"],
        }],
        "services": [{ "service": "/robot/reset", "providers": ["/robot"] }],
    });
    assert_eq!(found, expected);
}

#[test]
fn messages_of_rospy_are_printed() {
    let Some(master) = Master::start() else {
        return;
    };
    let mut talker = master.peer("talker", &["talker", "/said", "latch"]);
    assert_eq!(talker.line(), "ready");
    talker.tell("say größe");
    std::thread::sleep(std::time::Duration::from_millis(300));
    let (code, out, err) = ros(&["echo", "/said", "--count", "1"], master.port);
    assert_eq!((code, &*out, &*err), (0, "/talker {data: \"größe\"}\n", ""));
    let uri = format!("http://127.0.0.1:{}", master.port);
    let arguments = ["echo", "said", "--count", "1", "--json", "--master", &uri];
    let (code, out, _) = ros(&arguments, 1);
    assert_eq!(code, 0);
    let found: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(found["content"], serde_json::json!({ "data": "größe" }));
    assert_eq!(found["type"], "std_msgs/String");
    assert_eq!(
        (&found["topic"], &found["source"]),
        (&"/said".into(), &"/talker".into())
    );
    let (code, out, err) = ros(&["echo", "/sad", "--for", "1"], master.port);
    assert_eq!((code, &*out), (1, ""));
    assert!(err.contains("no node publishes `/sad`"), "{err}");
    assert!(err.contains("no message on `/sad` within 1 s"), "{err}");
}

#[test]
fn without_a_master_the_commands_say_so() {
    let [port] = asmotion_skip::free_ports().unwrap();
    for arguments in [&["list"][..], &["echo", "/odom"]] {
        let (code, out, err) = ros(arguments, port);
        assert_eq!((code, &*out), (2, ""));
        assert!(
            err.contains(&format!("the ROS master http://127.0.0.1:{port}/")),
            "{err}"
        );
        assert!(err.contains("is `roscore` running there"), "{err}");
    }
    let (code, _, err) = ros(&["list", "--master", "localhost"], port);
    assert_eq!(code, 2);
    assert!(
        err.contains("`localhost` is not the address of a master"),
        "{err}"
    );
    let (code, _, err) = ros(&["echo", "a b"], port);
    assert_eq!(code, 2);
    assert!(err.contains("error"), "{err}");
}
