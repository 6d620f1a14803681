//! The bus over RabbitMQ passes the contract suite.

use std::sync::Arc;

use asmotion_bus::PublishOptions;

use crate::common::{LONG, all, connect, number, publisher, settings, subscribe};

#[test]
fn t29_the_bus_over_rabbitmq_keeps_the_contract() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let mut settings = settings(&vhost.url());
    settings.notices = Arc::new(|notice| println!("{notice}"));
    settings.robot = Some("rover1".to_owned());
    let bus = connect(settings);
    assert_eq!(asmotion_bus::contract::violations(&bus, "there"), []);
    drop(bus);
    assert_eq!(vhost.queues().unwrap(), [""; 0], "it leaves no queues");
}

#[test]
fn without_a_robot_a_tool_sees_the_keys_of_all() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let vhost = broker.vhost().unwrap();
    let tool = connect(settings(&vhost.url()));
    let subscription = subscribe(&tool, "#.odom", all(10));
    let robots = ["rover1", "rover2"].map(|robot| {
        let mut settings = settings(&vhost.url());
        settings.robot = Some(robot.to_owned());
        connect(settings)
    });
    for robot in &robots {
        let mut publisher = publisher(robot, "left.odom", PublishOptions::default());
        publisher.publish(0, number(1)).unwrap();
    }
    let next = || subscription.next_within(LONG).unwrap().topic.to_string();
    let mut topics = [next(), next()];
    topics.sort();
    assert_eq!(topics, ["rover1.left.odom", "rover2.left.odom"]);
}
