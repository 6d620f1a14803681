//! The graph: what peers see of a node, and what a node sees of peers.

use std::time::Duration;

use asmotion_ros_interface::{Catalogue, Distribution};
use asmotion_ros2::{Durability, EndpointKind, Notice, Qos, Reliability};

use crate::peer::{LONG, Peer, domain, json, named, node, python, text, topic_settings, wait};

#[test]
fn cyclone_reads_the_graph_and_a_node_reads_that_of_cyclone() {
    let Some(python) = python() else { return };
    let domain = domain();
    let mut definitions = Catalogue::empty(Distribution::Ros2);
    for (name, definition) in [
        ("Gid", "uint8[16] data"),
        (
            "NodeEntitiesInfo",
            "string node_namespace\nstring node_name\nGid[] reader_gid_seq\nGid[] writer_gid_seq",
        ),
        (
            "ParticipantEntitiesInfo",
            "Gid gid\nNodeEntitiesInfo[] node_entities_info_seq",
        ),
    ] {
        let name = named(&format!("rmw_dds_common/msg/{name}"));
        definitions.define(name, definition).unwrap();
    }
    let info = named("rmw_dds_common/msg/ParticipantEntitiesInfo");
    let settings = serde_json::json!({
        "domain": domain,
        "schema": json(&definitions.schema(&info).unwrap()),
        "type": "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
        "transient": true,
        "depth": 1,
    });
    let node = node("coordinator", domain);
    let string = named("std_msgs/msg/String");
    let _publisher = node.publisher("/chatter", &string, Qos::default()).unwrap();
    let _subscription = node.subscription("/a", &string, Qos::default()).unwrap();
    let second = node.subscription("/b", &string, Qos::default()).unwrap();
    let peer = Peer::start(&python, "graph", &settings);
    peer.expect("/ coordinator 2 1");
    drop(second);
    peer.expect("/ coordinator 1 1");
    let of_peer = |graph: &asmotion_ros2::Graph| {
        let mut all = graph.nodes.values().flatten();
        all.any(|it| (&*it.namespace, &*it.name) == ("/py", "peer") && it.readers.len() == 1)
    };
    assert!(node.wait_for_graph(LONG, of_peer), "{:?}", node.graph());
    drop(peer);
    assert!(
        node.wait_for_graph(LONG, |graph| !of_peer(graph)),
        "{:?}",
        node.graph()
    );
}

#[test]
fn endpoints_of_cyclone_have_their_names_types_and_quality_of_service() {
    let Some(python) = python() else { return };
    let domain = domain();
    let mut settings = topic_settings(domain, "/scan", &named("sensor_msgs/msg/LaserScan"));
    settings["reliable"] = false.into();
    let _peer = Peer::start(&python, "subscribe", &settings);
    let node = node("watcher", domain);
    let endpoint = wait("endpoint", || {
        let graph = node.graph();
        graph
            .endpoints
            .values()
            .find(|it| it.topic == "rt/scan")
            .cloned()
    });
    assert_eq!(endpoint.kind, EndpointKind::Reader);
    let (name, of) = endpoint.ros.expect("a topic of ROS");
    assert_eq!((&*name, &*of), ("/scan", "sensor_msgs/msg/LaserScan"));
    assert_eq!(endpoint.qos.reliability, Reliability::BestEffort);
    assert_eq!(endpoint.qos.durability, Durability::Volatile);
}

#[test]
fn a_type_or_quality_of_service_that_does_not_match_is_noticed() {
    let domain = domain();
    let (one, other) = (node("one", domain), node("other", domain));
    let (string, boolean) = (named("std_msgs/msg/String"), named("std_msgs/msg/Bool"));
    let _texts = other.publisher("/x", &string, Qos::default()).unwrap();
    let _flags = one.subscription("/x", &boolean, Qos::default()).unwrap();
    let sensor = Qos::sensor_data();
    let fast = other.publisher("/y", &string, sensor).unwrap();
    let _sure = one.subscription("/y", &string, Qos::default()).unwrap();
    let mut seen = Vec::new();
    wait("notices", || {
        seen.extend(one.take_notices());
        (seen.len() >= 2).then_some(())
    });
    let types = |notice: &Notice| match notice {
        Notice::Type {
            topic, here, there, ..
        } => topic == "rt/x" && here.ends_with("Bool_") && there.ends_with("String_"),
        Notice::TypeHash { .. }
        | Notice::Qos { .. }
        | Notice::Deadline { .. }
        | Notice::Interrupted
        | Notice::Unacknowledged { .. }
        | Notice::Returned { .. }
        | Notice::Lost { .. } => false,
    };
    assert!(seen.iter().any(types), "{seen:?}");
    let qos = |notice: &Notice| match notice {
        Notice::Qos { topic, there, .. } => {
            topic == "rt/y" && there.reliability == Reliability::BestEffort
        }
        Notice::TypeHash { .. }
        | Notice::Type { .. }
        | Notice::Deadline { .. }
        | Notice::Interrupted
        | Notice::Unacknowledged { .. }
        | Notice::Returned { .. }
        | Notice::Lost { .. } => false,
    };
    assert!(seen.iter().any(qos), "{seen:?}");
    assert_eq!(fast.matches(), 0);
    fast.send(&text("to nobody")).unwrap();
}

#[test]
fn a_peer_that_is_killed_and_comes_back_is_heard_again() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let node = node("survivor", domain);
    let subscription = node.subscription("/beat", &string, Qos::default()).unwrap();
    let schema = crate::peer::catalogue().schema(&string).unwrap();
    let mut settings = topic_settings(domain, "/beat", &string);
    let beat = crate::peer::hex(&crate::peer::encode(&text("beat"), &schema));
    settings["messages"] = vec![beat].into();
    for round in 0..3 {
        let peer = Peer::start(&python, "publish", &settings);
        let message = subscription.wait(LONG);
        assert_eq!(
            message.map(|it| it.message),
            Some(text("beat")),
            "round {round}"
        );
        peer.expect("sent");
        peer.kill();
        assert_eq!(subscription.wait(Duration::from_millis(100)), None);
    }
    assert_eq!(subscription.counts().received, 3);
    assert_eq!(subscription.counts().lost, 0);
}
