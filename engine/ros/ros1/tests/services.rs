//! Services, with providers and callers of rospy.

use std::time::{Duration, Instant};

use asmotion_bus::{CallFailure, Payload, Refusal, Request, SenderId};
use asmotion_datum::Datum;
use asmotion_ros1::{DIED, FAILED, MISMATCH, RosError};

use asmotion_ros_master::{Master, SOON, eventually, notifier, service_type};

fn request(data: bool, timeout: Duration) -> Request {
    let argument = Payload::of(Datum::record([("data", Datum::Bool(data))]));
    Request::new(SenderId::new("test", 0), argument, timeout)
}

fn response(success: bool, message: &str) -> Datum {
    Datum::record([
        ("success", Datum::Bool(success)),
        ("message", Datum::text(message)),
    ])
}

#[test]
fn services_of_rospy_are_called() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/caller");
    let provider = master.peer("provider", &["arm"]);
    assert_eq!(provider.line(), "ready");
    for is_persistent in [false, true] {
        let of = service_type("std_srvs", "SetBool");
        let client = node
            .node
            .service_client("/arm/set", of, is_persistent)
            .unwrap();
        for _ in 0..3 {
            let answer = client.call_and_wait(request(true, SOON)).unwrap();
            assert_eq!(answer.to_datum().unwrap(), response(true, "done é"));
            assert_eq!(provider.line(), "True");
        }
        let failure = client.call_and_wait(request(false, SOON)).unwrap_err();
        let CallFailure::Refused(Refusal { code, detail }) = failure else {
            panic!("{failure:?}");
        };
        assert_eq!(code, FAILED);
        assert!(detail.contains("no é"), "{detail}");
        assert_eq!(provider.line(), "False");
        // the client goes on after a failure
        assert!(client.call_and_wait(request(true, SOON)).is_ok());
        assert_eq!(provider.line(), "True");
    }
}

#[test]
fn a_call_ends_at_its_deadline_and_its_late_response_belongs_to_no_other() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/caller");
    let provider = master.peer("provider", &["arm"]);
    assert_eq!(provider.line(), "ready");
    for is_persistent in [false, true] {
        let of = service_type("std_srvs", "SetBool");
        let client = node
            .node
            .service_client("/arm/slow", of, is_persistent)
            .unwrap();
        let begun = Instant::now();
        let failure = client.call_and_wait(request(true, Duration::from_millis(300)));
        assert_eq!(failure.unwrap_err(), CallFailure::Timeout);
        assert!(
            begun.elapsed() < Duration::from_millis(900),
            "{:?}",
            begun.elapsed()
        );
        let answer = client.call_and_wait(request(false, SOON)).unwrap();
        assert_eq!(answer.to_datum().unwrap(), response(false, "slow"));
    }
}

#[test]
fn without_a_provider_a_call_is_unavailable_or_awaits_one() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/caller");
    let of = service_type("std_srvs", "SetBool");
    let client = node.node.service_client("/arm/set", of, false).unwrap();
    let begun = Instant::now();
    let failure = client.call_and_wait(request(true, SOON));
    assert_eq!(failure.unwrap_err(), CallFailure::Unavailable);
    assert!(begun.elapsed() < SOON / 2);
    let waiting = request(true, SOON).with_awaited_provider(true);
    let pending = client.call(waiting, notifier());
    let provider = master.peer("provider", &["arm"]);
    assert_eq!(provider.line(), "ready");
    assert!(pending.wait().is_ok());
}

#[test]
fn a_provider_that_dies_during_a_call_is_a_typed_failure() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/caller");
    let provider = master.peer("provider", &["arm"]);
    assert_eq!(provider.line(), "ready");
    let of = service_type("std_srvs", "SetBool");
    let client = node.node.service_client("/arm/end", of, false).unwrap();
    let failure = client.call_and_wait(request(true, SOON)).unwrap_err();
    let CallFailure::Refused(Refusal { code, .. }) = failure else {
        panic!("{failure:?}");
    };
    assert_eq!(code, DIED);
}

#[test]
fn a_service_of_another_type_is_a_typed_failure() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/caller");
    let provider = master.peer("provider", &["arm"]);
    assert_eq!(provider.line(), "ready");
    let of = service_type("std_srvs", "Trigger");
    let client = node.node.service_client("/arm/set", of, false).unwrap();
    let empty: [(&str, Datum); 0] = [];
    let argument = Payload::of(Datum::record(empty));
    let failure = client
        .call_and_wait(Request::new(SenderId::new("test", 0), argument, SOON))
        .unwrap_err();
    let CallFailure::Refused(Refusal { code, detail }) = failure else {
        panic!("{failure:?}");
    };
    assert_eq!(code, MISMATCH);
    assert!(detail.contains("md5"), "{detail}");
}

#[test]
fn rospy_calls_services_once_and_on_a_persistent_connection() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = master.node("/robot");
    let of = service_type("std_srvs", "SetBool");
    let served = node
        .node
        .serve("gripper", of.clone(), 8, notifier())
        .unwrap();
    let again = node.node.serve("/gripper", of, 8, notifier());
    assert!(matches!(again, Err(RosError::Served { .. })));
    node.registered();
    for kind in ["once", "persistent"] {
        let mut peer = master.peer("caller", &["peer", "/gripper", kind]);
        assert_eq!(peer.line(), "ready");
        for data in [true, false, true] {
            peer.tell(if data { "true" } else { "false" });
            let call = served.next_within(SOON).expect("a request");
            assert_eq!(&*call.origin.source, "/peer");
            let found = call.argument.to_datum().unwrap();
            assert_eq!(found, Datum::record([("data", Datum::Bool(data))]));
            let jammed = Refusal {
                code: "stuck".to_owned(),
                detail: "the jaw is stuck".to_owned(),
            };
            let answer = Payload::of(response(true, "gripped"));
            call.reply(if data { Ok(answer) } else { Err(jammed) });
            let line = peer.line();
            let expected = if data {
                "True gripped"
            } else {
                "stuck: the jaw is stuck"
            };
            assert!(line.contains(expected), "{line}");
        }
    }
    // a call whose caller has left is awaited no more
    let mut peer = master.peer("caller", &["peer", "/gripper", "once"]);
    assert_eq!(peer.line(), "ready");
    peer.tell("true");
    let call = served.next_within(SOON).expect("a request");
    drop(peer);
    eventually("the call is not awaited", || {
        (!call.is_awaited()).then_some(())
    });
    drop(served);
    eventually("the service is withdrawn", || {
        let services = node.node.graph().unwrap().services;
        (!services.contains_key("/gripper")).then_some(())
    });
}

#[test]
fn a_service_that_is_never_answered_ends_at_its_limit() {
    let Some(master) = Master::start() else {
        return;
    };
    let node = asmotion_ros_master::TestNode::start(master.port, "/robot", |settings| {
        settings.timing.service = Duration::from_millis(300);
    });
    let of = service_type("std_srvs", "SetBool");
    let served = node.node.serve("gripper", of, 1, notifier()).unwrap();
    node.registered();
    let mut peer = master.peer("caller", &["peer", "/gripper", "once"]);
    assert_eq!(peer.line(), "ready");
    peer.tell("true");
    let line = peer.line();
    assert!(line.contains("no answer before the deadline"), "{line}");
    // the request that nobody took is not executed late
    assert!(served.try_next().is_none());
}
