//! A test broker starts, obeys, fails, recovers and leaves nothing behind.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::net::TcpStream;

#[test]
fn it_obeys_and_keeps_tests_apart() {
    let Some(broker) = asmotion_broker::calm() else {
        return;
    };
    let (one, other) = (broker.vhost().unwrap(), broker.vhost().unwrap());
    assert_ne!(one.name(), other.name());
    assert_eq!(one.queues().unwrap(), [""; 0]);
    assert_eq!(broker.evaluate("1 + 1").unwrap(), "2");
    assert!(broker.evaluate("no_such_module:f()").is_err());
}

#[test]
fn it_is_restored_after_each_fault() {
    for fault in [
        (|broker| broker.kill().unwrap()) as fn(&asmotion_broker::TestBroker),
        |broker| broker.stop_app().unwrap(),
        |broker| broker.raise_alarm().unwrap(),
        |broker| broker.freeze().unwrap(),
    ] {
        let Some(broker) = asmotion_broker::alone() else {
            return;
        };
        fault(&broker);
        drop(broker);
        let broker = asmotion_broker::alone().unwrap();
        assert_eq!(broker.evaluate("rabbit_alarm:get_alarms()").unwrap(), "[]");
        TcpStream::connect(broker.address()).unwrap();
    }
}
