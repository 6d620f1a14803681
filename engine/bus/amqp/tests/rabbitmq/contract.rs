//! It keeps the contract.

use std::sync::Arc;

use amqp::AmqpBus;
use bus::Bus;

use crate::common::{connect, settings};

#[test]
fn t29_the_bus_over_rabbitmq_keeps_the_contract() {
    let Some(broker) = broker::calm() else { return };
    let vhost = broker.vhost().unwrap();
    let mut settings = settings(&vhost.url());
    settings.notices = Arc::new(|notice| println!("{notice}"));
    settings.robot = Some("rover1".to_owned());
    let bus = connect(settings);
    assert_eq!(bus::contract::violations(&bus, "there"), []);
    drop(bus);
    assert_eq!(vhost.queues().unwrap(), [""; 0], "it leaves no queues");
}

#[test]
fn without_a_robot_a_tool_sees_whole_keys() {
    let Some(broker) = broker::calm() else { return };
    let vhost = broker.vhost().unwrap();
    let tool: AmqpBus = connect(settings(&vhost.url()));
    assert_eq!(bus::contract::violations(&tool, "rover1.x"), []);
    assert!(tool.health().is_up());
}
