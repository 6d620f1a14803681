//! Services in both mappings.

use std::time::{Duration, Instant};

use asmotion_datum::Datum;
use asmotion_ros2::{CallError, Node, Server, ServiceMapping};

use crate::peer::{LONG, Peer, catalogue, domain, json, named, node, python, wait};

const ADD: &str = "example_interfaces/srv/AddTwoInts";

fn settings(domain: u16) -> serde_json::Value {
    let [request, response] = &catalogue().schemas(&named(ADD)).unwrap()[..] else {
        panic!("a service has two parts");
    };
    serde_json::json!({
        "domain": domain,
        "requests": "rq/addRequest",
        "replies": "rr/addReply",
        "request": json(request),
        "response": json(response),
        "request_type": "example_interfaces::srv::dds_::AddTwoInts_Request_",
        "response_type": "example_interfaces::srv::dds_::AddTwoInts_Response_",
        "calls": 20,
        "depth": 100,
    })
}

fn request(a: i64, b: i64) -> Datum {
    Datum::record([("a", Datum::Int(a)), ("b", Datum::Int(b))])
}

fn sum(sum: i64) -> Datum {
    Datum::record([("sum", Datum::Int(sum))])
}

/// Serves until `count` requests are answered.
fn serve(server: &Server, count: usize) {
    for _ in 0..count {
        let request = server.wait(LONG).expect("a request");
        let number = |name| request.request.get(name).unwrap().as_int().unwrap();
        server
            .reply(&request.reply_to, &sum(number("a") + number("b")))
            .unwrap();
    }
}

#[test]
fn the_first_call_of_a_new_client_reaches_cyclone() {
    let Some(python) = python() else { return };
    let domain = domain();
    let peer = Peer::start(&python, "serve", &settings(domain));
    peer.expect("ready");
    for round in 0..5 {
        let node = node("caller", domain);
        let client = node
            .client("/add", &named(ADD), ServiceMapping::OfPeer)
            .unwrap();
        let answer = client.call(&request(round, 40), LONG).wait();
        assert_eq!(answer, Ok(sum(round + 40)));
        peer.expect(&format!("request {round} 40"));
        let next = client
            .call(&request(round, -40), Duration::from_secs(5))
            .wait();
        assert_eq!(next, Ok(sum(round - 40)));
        peer.expect(&format!("request {round} -40"));
        let counts = client.counts();
        assert_eq!((counts.sent, counts.responses, counts.malformed), (2, 2, 0));
    }
}

#[test]
fn calls_end_at_their_deadline_with_the_reason() {
    let Some(python) = python() else { return };
    let domain = domain();
    let node = node("caller", domain);
    let client = node
        .client("/add", &named(ADD), ServiceMapping::OfPeer)
        .unwrap();
    let begun = Instant::now();
    let alone = client
        .call(&request(1, 2), Duration::from_millis(300))
        .wait();
    assert!(
        matches!(alone, Err(CallError::NoServer { .. })),
        "{alone:?}"
    );
    assert!(begun.elapsed() < Duration::from_secs(2));
    let peer = Peer::start(&python, "serve", &settings(domain));
    peer.expect("ready");
    wait("server", || client.is_ready().then_some(()));
    // the peer never answers -1
    let silent = client
        .call(&request(-1, 2), Duration::from_millis(500))
        .wait();
    assert!(
        matches!(silent, Err(CallError::Deadline { .. })),
        "{silent:?}"
    );
    peer.expect("request -1 2");
    assert_eq!(client.call(&request(3, 4), LONG).wait(), Ok(sum(7)));
    let wrong = client
        .call(&Datum::record([("a", Datum::text("x"))]), LONG)
        .wait();
    assert!(matches!(wrong, Err(CallError::Request(_))), "{wrong:?}");
}

#[test]
fn cyclone_calls_a_server() {
    let Some(python) = python() else { return };
    let domain = domain();
    let node = node("adder", domain);
    let server = node
        .server("/add", &named(ADD), ServiceMapping::OfPeer, 64)
        .unwrap();
    let peer = Peer::start(&python, "call", &settings(domain));
    serve(&server, 20);
    // a datagram that comes late lets the next request overtake it: replies are told apart by their numbers, not their order
    let mut replies = peer.lines(20);
    let expected = (0..20).map(|number| format!("reply 4711 {number} {}", 1000 + number));
    let mut expected: Vec<_> = expected.collect();
    replies.sort();
    expected.sort();
    assert_eq!(replies, expected);
    let counts = server.counts();
    assert_eq!((counts.received, counts.replied), (20, 20));
    assert_eq!((counts.malformed, counts.unreachable), (0, 0));
}

/// A reader of Cyclone DDS leaves out what the first heartbeat announces. Here it knows the writer later than the writer knows the
/// reader, so that the first heartbeat that it hears is that of the first reply.
#[test]
fn a_burst_of_replies_reaches_a_client_that_has_just_matched() {
    let Some(python) = python() else { return };
    for _ in 0..2 {
        let domain = domain();
        let peer = Peer::start(&python, "call", &settings(domain));
        let node = node("adder", domain);
        let has_client = |graph: &asmotion_ros2::Graph| {
            let mut endpoints = graph.endpoints.values();
            endpoints.any(|it| it.topic == "rr/addReply")
        };
        assert!(node.wait_for_graph(LONG, has_client));
        let server = node
            .server("/add", &named(ADD), ServiceMapping::OfPeer, 64)
            .unwrap();
        let requests = (0..20).map(|_| server.wait(LONG).expect("a request"));
        let requests: Vec<_> = requests.collect();
        for request in &requests {
            let number = request.request.get("a").unwrap().as_int().unwrap();
            server.reply(&request.reply_to, &sum(number)).unwrap();
        }
        let mut replies = peer.lines(20);
        let mut expected: Vec<_> = (0..20)
            .map(|number| format!("reply 4711 {number} {number}"))
            .collect();
        replies.sort();
        expected.sort();
        assert_eq!(replies, expected);
    }
}

#[test]
fn a_header_of_cyclone_is_never_taken_for_a_request() {
    let Some(python) = python() else { return };
    let domain = domain();
    let node = node("adder", domain);
    let server = node
        .server("/add", &named(ADD), ServiceMapping::Enhanced, 64)
        .unwrap();
    let _peer = Peer::start(&python, "call", &settings(domain));
    wait("malformed requests", || {
        (server.counts().malformed == 20).then_some(())
    });
    assert_eq!(server.take(), None);
    assert_eq!(
        server.counts().last_error.as_deref(),
        Some("malformed CDR: trailing bytes")
    );
}

#[test]
fn a_reply_of_cyclone_is_never_taken_for_a_response() {
    let Some(python) = python() else { return };
    let domain = domain();
    let peer = Peer::start(&python, "serve", &settings(domain));
    peer.expect("ready");
    let node = node("caller", domain);
    let client = node
        .client("/add", &named(ADD), ServiceMapping::Enhanced)
        .unwrap();
    let wrong = client.call(&request(1, 2), Duration::from_secs(3)).wait();
    assert!(
        matches!(wrong, Err(CallError::Deadline { .. })),
        "{wrong:?}"
    );
}

/// A server and a client on two nodes, which use the mapping of DDS-RPC unless another is set.
fn pair(domain: u16) -> (Node, Node) {
    (node("adder", domain), node("caller", domain))
}

#[test]
fn nodes_call_each_other_in_both_mappings() {
    for mapping in [
        ServiceMapping::OfPeer,
        ServiceMapping::Enhanced,
        ServiceMapping::Cyclone,
    ] {
        let (adder, caller) = pair(domain());
        let server = adder.server("add", &named(ADD), mapping, 64).unwrap();
        let client = caller.client("add", &named(ADD), mapping).unwrap();
        let other = caller.client("add", &named(ADD), mapping).unwrap();
        let calls: Vec<_> = (0..10)
            .map(|number| client.call(&request(number, 1), LONG))
            .collect();
        let others: Vec<_> = (0..10)
            .map(|number| other.call(&request(number, 2), LONG))
            .collect();
        serve(&server, 20);
        for (number, (call, other)) in (0..).zip(calls.into_iter().zip(others)) {
            assert_eq!(call.wait(), Ok(sum(number + 1)), "{mapping:?}");
            assert_eq!(other.wait(), Ok(sum(number + 2)), "{mapping:?}");
        }
        assert_eq!(server.counts().malformed, 0);
    }
}

#[test]
fn nodes_with_different_mappings_refuse_each_other() {
    for (there, here) in [
        (ServiceMapping::Enhanced, ServiceMapping::Cyclone),
        (ServiceMapping::Cyclone, ServiceMapping::Enhanced),
    ] {
        let (adder, caller) = pair(domain());
        let server = adder.server("add", &named(ADD), there, 64).unwrap();
        let client = caller.client("add", &named(ADD), here).unwrap();
        let call = client.call(&request(1, 2), Duration::from_secs(3));
        wait("a malformed request", || {
            (server.counts().malformed == 1).then_some(())
        });
        assert_eq!(server.take(), None);
        assert!(matches!(call.wait(), Err(CallError::Deadline { .. })));
    }
}
