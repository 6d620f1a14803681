//! Parameters, set and read by rospy.

use std::time::Duration;

use asmotion_bus::{CallFailure, Payload, PendingCall, Subscription};
use asmotion_datum::Datum;
use asmotion_ros1::RosError;

use asmotion_ros_master::{Master, SOON, all, notifier};

fn done(call: Result<PendingCall, RosError>) -> Result<Datum, CallFailure> {
    let payload = call.unwrap().wait()?;
    Ok(Payload::to_datum(&payload).unwrap())
}

fn next(followed: &Subscription) -> Datum {
    let envelope = followed.next_within(SOON).expect("a value");
    envelope.payload.to_datum().unwrap()
}

#[test]
fn parameters_are_set_and_read_both_ways() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot/driver").node;
    let mut peer = master.peer("parameters", &["peer"]);
    assert_eq!(peer.line(), "ready");
    let value = Datum::record([
        (
            "frames",
            Datum::List(vec![Datum::text("map"), Datum::text("größe <&>")]),
        ),
        ("limit", Datum::Float(0.25)),
        ("on", Datum::Bool(true)),
        ("steps", Datum::Int(-3)),
    ]);
    done(node.set_parameter("~speed", &value, SOON, notifier())).unwrap();
    peer.tell("get /robot/driver/speed");
    let expected =
        r#"{"frames": ["map", "gr\u00f6\u00dfe <&>"], "limit": 0.25, "on": true, "steps": -3}"#;
    assert_eq!(peer.line(), expected);
    peer.tell(r#"set /robot/map {"size": [1, 2.5], "name": ""}"#);
    assert_eq!(peer.line(), "set");
    let read = done(node.parameter("map/size", SOON, notifier())).unwrap();
    assert_eq!(read, Datum::List(vec![Datum::Int(1), Datum::Float(2.5)]));
    let failure = done(node.parameter("nothing", SOON, notifier())).unwrap_err();
    let CallFailure::Refused(refusal) = failure else {
        panic!("{failure:?}");
    };
    assert_eq!(refusal.code, "unset");
    let failure = done(node.set_parameter("a", &Datum::Int(1 << 40), SOON, notifier()));
    assert!(failure.unwrap_err().to_string().contains("32 bits"));
}

#[test]
fn a_followed_parameter_has_each_change_and_those_of_its_parts() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot").node;
    let mut peer = master.peer("parameters", &["peer"]);
    assert_eq!(peer.line(), "ready");
    peer.tell(r#"set /speed {"max": 1.5}"#);
    assert_eq!(peer.line(), "set");
    let followed = node.follow_parameter("speed", all(10), notifier()).unwrap();
    let speed = |max| Datum::record([("max", Datum::Float(max))]);
    assert_eq!(next(&followed), speed(1.5));
    // a second observer begins with the value
    let second = node
        .follow_parameter("/speed", all(10), notifier())
        .unwrap();
    assert_eq!(next(&second), speed(1.5));
    peer.tell("set /speed/max 2.5");
    assert_eq!(peer.line(), "set");
    assert_eq!((next(&followed), next(&second)), (speed(2.5), speed(2.5)));
    peer.tell("set /speedy 1");
    assert_eq!(peer.line(), "set");
    peer.tell("set /speed/unit \"m/s\"");
    assert_eq!(peer.line(), "set");
    let unit = next(&followed);
    assert_eq!(unit.get("unit").as_deref(), Some(&Datum::text("m/s")));
    assert_eq!(unit.get("max").as_deref(), Some(&Datum::Float(2.5)));
    drop(second);
    peer.tell("delete /speed");
    assert_eq!(peer.line(), "deleted");
    assert_eq!(next(&followed), Datum::Null);
    assert!(followed.next_within(Duration::from_millis(200)).is_none());
}

#[test]
fn a_node_deletes_the_parameters_that_are_its_own() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot/driver").node;
    let value = Datum::Float(0.5);
    for name in ["~speed", "/limit"] {
        done(node.set_parameter(name, &value, SOON, notifier())).unwrap();
    }
    node.delete_parameter_at_end("~speed").unwrap();
    node.delete_parameter_at_end("~never_set").unwrap();
    drop(node);
    let mut peer = master.peer("parameters", &["peer"]);
    assert_eq!(peer.line(), "ready");
    peer.tell("list");
    let listed = peer.line();
    assert!(
        listed.contains("/limit") && !listed.contains("speed"),
        "{listed}"
    );
}
