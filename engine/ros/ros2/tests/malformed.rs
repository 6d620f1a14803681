//! Messages that are not of their type. The peer announces the right name of the type and sends another one.

use std::time::Duration;

use asmotion_datum::Datum;
use asmotion_ros2::Qos;

use crate::peer::{
    Peer, catalogue, domain, encode, hex, json, named, node, python, text, topic_settings, wait,
};

#[test]
fn messages_of_another_type_are_counted_and_the_next_one_is_read() {
    let Some(python) = python() else { return };
    let domain = domain();
    let string = named("std_msgs/msg/String");
    let node = node("listener", domain);
    let subscription = node.subscription("/x", &string, Qos::default()).unwrap();
    // a length of 4 GiB, a text that ends early, a text without its zero, and a rest
    for (of, message, error) in [
        (
            "std_msgs/msg/UInt32",
            Datum::Int(0xffff_ffff),
            "unexpected end",
        ),
        ("std_msgs/msg/UInt32", Datum::Int(9), "unexpected end"),
        (
            "std_msgs/msg/UInt64",
            Datum::Int((0x4141 << 32) | 2),
            "string without terminating zero",
        ),
        ("std_msgs/msg/UInt64", Datum::Int(7 << 32), "trailing bytes"),
    ] {
        let before = subscription.counts().malformed;
        let of = named(of);
        let schema = catalogue().schema(&of).unwrap();
        let mut settings = topic_settings(domain, "/x", &string);
        settings["schema"] = json(&schema);
        let bytes = encode(&Datum::record([("data", message)]), &schema);
        settings["messages"] = vec![hex(&bytes)].into();
        let peer = Peer::start(&python, "publish", &settings);
        peer.expect("sent");
        wait("malformed message", || {
            (subscription.counts().malformed > before).then_some(())
        });
        let last = subscription.counts().last_error.unwrap();
        assert!(last.contains(error), "{last}");
    }
    assert_eq!(subscription.take(), None);
    let schema = catalogue().schema(&string).unwrap();
    let mut settings = topic_settings(domain, "/x", &string);
    settings["messages"] = vec![hex(&encode(&text("fine"), &schema))].into();
    let peer = Peer::start(&python, "publish", &settings);
    peer.expect("sent");
    let received = subscription
        .wait(Duration::from_secs(5))
        .expect("a message");
    assert_eq!(received.message, text("fine"));
    assert_eq!(subscription.counts().malformed, 4);
}
