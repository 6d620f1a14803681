//! The graph, as the tools of ROS show it.

use std::time::Duration;

use asmotion_ros_master::{Master, TestNode, all, eventually, notifier, service_type, topic_type};
use asmotion_ros1::RosNotice;

#[test]
fn r1_tools_of_ros_show_the_node() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot/coordinator");
    let twist = topic_type("geometry_msgs/Twist");
    let _publisher = node
        .node
        .publisher("cmd_vel", twist.clone(), 1, false)
        .unwrap();
    let _subscription = node.node.subscribe(
        "odom",
        Some(topic_type("nav_msgs/Odometry")),
        all(1),
        notifier(),
    );
    let _served = node
        .node
        .serve("~stop", service_type("std_srvs", "Trigger"), 1, notifier());
    node.registered();
    assert_eq!(master.tool("rosnode", &["list"]), "/robot/coordinator\n");
    let info = master.tool("rosnode", &["info", "/robot/coordinator"]);
    for line in [
        "* /robot/cmd_vel [geometry_msgs/Twist]",
        "* /robot/odom [unknown type]",
        "* /robot/coordinator/stop",
        &format!("Pid: {}", std::process::id()),
    ] {
        assert!(info.contains(line), "{line}: {info}");
    }
    let info = master.tool("rostopic", &["info", "/robot/cmd_vel"]);
    assert!(info.contains("Type: geometry_msgs/Twist"), "{info}");
    let uri = node.node.uri();
    assert!(
        info.contains(&format!("* /robot/coordinator ({uri})")),
        "{info}"
    );
    let services = master.tool("rosservice", &["info", "/robot/coordinator/stop"]);
    assert!(services.contains("Type: std_srvs/Trigger"), "{services}");
    let pinged = master.tool("rosnode", &["ping", "-c", "1", "/robot/coordinator"]);
    assert!(pinged.contains("xmlrpc reply from"), "{pinged}");
    // connections are part of what it tells
    let peer = master.peer(
        "listener",
        &["/driver", "/robot/cmd_vel", "geometry_msgs", "Twist", "0"],
    );
    assert_eq!(peer.line(), "connected");
    let info = master.tool("rosnode", &["info", "/robot/coordinator"]);
    assert!(info.contains("* to: /driver"), "{info}");

    let graph = node.node.graph().unwrap();
    assert!(graph.nodes().contains(&"/driver"));
    let topic = &graph.topics["/robot/cmd_vel"];
    assert_eq!(topic.type_name, "geometry_msgs/Twist");
    assert_eq!(
        (&*topic.publishers, &*topic.subscribers),
        (
            &["/robot/coordinator".to_owned()][..],
            &["/driver".to_owned()][..]
        )
    );
    assert_eq!(
        graph.services["/robot/coordinator/stop"],
        ["/robot/coordinator"]
    );
    drop(node);
    drop(peer);
    let nodes = master.tool("rosnode", &["list"]);
    assert!(!nodes.contains("/robot/coordinator"), "{nodes}");
}

#[test]
fn a_node_whose_name_is_taken_ends() {
    let Some(master) = Master::start() else {
        return;
    };
    let of = topic_type("std_msgs/Bool");
    let first = master.node("/twin");
    let _one = first.node.publisher("a", of.clone(), 1, false).unwrap();
    first.registered();
    let second = master.node("/twin");
    let _two = second.node.publisher("b", of, 1, false).unwrap();
    second.registered();
    first.notice("the first is asked to end", |notice| {
        matches!(notice, RosNotice::Ended { .. }).then_some(())
    });
    assert!(!first.node.health().is_up());
    std::thread::sleep(Duration::from_millis(600));
    // it does not fight for the name
    second.registered();
    assert_eq!(second.node.graph().unwrap().nodes(), ["/twin"]);
}

#[test]
fn r6_without_a_master_there_is_a_clear_error() {
    let [port] = asmotion_skip::free_ports().unwrap();
    let node = TestNode::start(port, "/alone", |_| ());
    let error = node
        .node
        .await_registered(Duration::from_millis(700))
        .unwrap_err();
    let text = error.to_string();
    assert!(
        text.contains(&format!("http://127.0.0.1:{port}/")),
        "{text}"
    );
    assert!(
        text.contains("onnection refused") && text.contains("roscore"),
        "{text}"
    );
    assert!(node.node.graph().is_err());
    // one notice, however often it was tried
    eventually("a notice", || (node.notices().len() == 1).then_some(()));
}
