//! Who may read, who may control, and what nobody may do.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use asmotion_monitor::{
    BearerToken, Dashboard, DashboardSettings, MonitorSource, SystemDescription,
};
use serde_json::json;
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Error, Message};

use crate::{Fixture, PATIENCE};

#[test]
fn a_foreign_host_is_refused_everywhere() {
    let fixture = Fixture::open(|_| {});
    for path in ["/", "/main.js", "/metrics", "/api/system", "/live"] {
        assert_eq!(
            fixture.status(path, "Host: evil.example\r\n"),
            "421",
            "{path}"
        );
        let rebound = "Host: 127.0.0.1.evil.example\r\nOrigin: http://127.0.0.1.evil.example\r\n";
        assert_eq!(fixture.status(path, rebound), "421", "{path}");
        assert_eq!(fixture.status(path, ""), "421", "{path}");
    }
    let (host, port) = (fixture.host(), fixture.address().port());
    assert_eq!(fixture.status("/", &host), "200");
    assert_eq!(
        fixture.status("/metrics", &format!("Host: localhost:{port}\r\n")),
        "200"
    );
}

#[test]
fn a_foreign_origin_is_refused_everywhere() {
    let fixture = Fixture::open(|_| {});
    let host = fixture.host();
    let port = fixture.address().port();
    for origin in [
        "http://evil.example".to_owned(),
        "null".to_owned(),
        format!("http://127.0.0.1:{}", port ^ 1),
    ] {
        for path in ["/", "/metrics", "/live"] {
            let headers = format!("{host}Origin: {origin}\r\n");
            assert_eq!(fixture.status(path, &headers), "403", "{path} {origin}");
        }
        assert!(fixture.connect(Some(&origin)).is_err(), "{origin}");
    }
    let own = format!("http://127.0.0.1:{port}");
    assert!(fixture.connect(Some(&own)).is_ok());
    assert!(fixture.connect(None).is_ok());
}

#[test]
fn a_tab_controls_nothing_without_the_token() {
    let fixture = Fixture::open(|settings| settings.control = Some(BearerToken::new("s3cret")));
    let orders = fixture.serve_orders();
    let mut client = fixture.client();
    let order = json!({ "type": "order", "id": 7, "component": "Driver", "wish": "stop" });
    client.send(&order);
    let refused = client.reply();
    assert_eq!(
        (&refused["type"], &refused["id"]),
        (&json!("problem"), &json!(7))
    );
    assert!(
        refused["text"].as_str().unwrap().contains("not armed"),
        "{refused}"
    );
    for token in ["", "s3cre", "s3crets"] {
        client.send(&json!({ "type": "arm", "token": token }));
        assert!(
            client.reply()["text"]
                .as_str()
                .unwrap()
                .contains("wrong token")
        );
    }
    client.send(&order);
    assert_eq!(client.reply()["type"], "problem");
    assert!(
        orders.try_recv().is_err(),
        "an order has reached the system"
    );

    client.send(&json!({ "type": "arm", "token": "s3cret" }));
    assert_eq!(client.reply()["type"], "armed");
    client.send(&order);
    assert_eq!(client.reply(), json!({ "type": "done", "id": 7 }));
    let order = orders.recv_timeout(PATIENCE).unwrap();
    assert_eq!(order.get("wish").unwrap().as_text(), Some("stop"));

    // another tab needs the permission, and gets it when the first one has gone
    let mut other = fixture.client();
    other.send(&json!({ "type": "arm", "token": "s3cret" }));
    assert!(
        other.reply()["text"]
            .as_str()
            .unwrap()
            .contains("another tab")
    );
    drop(client);
    let begun = Instant::now();
    loop {
        other.send(&json!({ "type": "arm", "token": "s3cret" }));
        if other.reply()["type"] == "armed" {
            break;
        }
        assert!(begun.elapsed() < PATIENCE);
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn without_control_a_token_does_not_help() {
    let fixture = Fixture::open(|_| {});
    let mut client = fixture.client();
    client.send(&json!({ "type": "arm", "token": "" }));
    assert!(
        client.reply()["text"]
            .as_str()
            .unwrap()
            .contains("--control")
    );
    // there is no other way to write
    let (head, _) = fixture.send("POST", "/api/components", &fixture.host());
    assert!(head.starts_with("HTTP/1.1 405"), "{head}");
}

#[test]
fn a_message_that_is_too_large_ends_the_connection_and_no_other() {
    let mut fixture = Fixture::open(|_| {});
    let mut other = fixture.client();
    let mut client = fixture.client();
    let large = json!({ "type": "arm", "token": "x".repeat(65 * 1024) });
    // the server may close before it has read everything
    let _ = client.0.send(Message::text(large.to_string()));
    let code = loop {
        match client.0.read() {
            Ok(Message::Close(frame)) => break frame.map(|it| it.code),
            Ok(_) => {}
            Err(Error::Io(_) | Error::ConnectionClosed | Error::Protocol(_)) => break None,
            Err(error) => panic!("{error}"),
        }
    };
    assert!(matches!(code, Some(CloseCode::Size) | None), "{code:?}");
    other.subscribe(&["Driver.odom"]);
    fixture.publish(3);
    assert_eq!(
        other.frame_with("samples")["samples"]["Driver.odom"]["data"],
        3
    );
}

#[test]
fn a_thousand_connections_neither_stop_the_server_nor_those_that_are_open() {
    let mut fixture = Fixture::open(|settings| settings.max_connections = 16);
    let mut first = fixture.client();
    first.subscribe(&["Driver.odom"]);
    let mut open = Vec::new();
    let mut refused = 0;
    for _ in 0..1000 {
        match fixture.connect(None) {
            Ok(client) => open.push(client),
            Err(_) => refused += 1,
        }
    }
    assert_eq!((open.len(), refused), (15, 985));
    fixture.publish(1);
    assert_eq!(
        first.frame_with("samples")["samples"]["Driver.odom"]["data"],
        1
    );
    // connections that send nothing make room for one that does
    open.truncate(10);
    let begun = Instant::now();
    let idle: Vec<TcpStream> = (0..1000)
        .map(|_| TcpStream::connect(fixture.address()).unwrap())
        .collect();
    while fixture.status("/metrics", &fixture.host()) != "200" {
        assert!(begun.elapsed() < PATIENCE);
    }
    fixture.publish(2);
    assert_eq!(
        first.frame_with("samples")["samples"]["Driver.odom"]["data"],
        2
    );
    drop(idle);
}

#[test]
fn subscriptions_are_limited_and_nonsense_is_answered() {
    let fixture = Fixture::open(|settings| settings.max_subscriptions = 2);
    let mut client = fixture.client();
    client.subscribe(&["log", "A.a", "A.b"]);
    client.subscribe(&["A.a", "A.b", "A.c"]);
    assert!(
        client.reply()["text"]
            .as_str()
            .unwrap()
            .contains("2 outputs")
    );
    for nonsense in [
        "",
        "[]",
        "{\"type\":\"launch\"}",
        "{\"type\":\"ack\",\"seq\":-1}",
    ] {
        client.0.send(Message::text(nonsense)).unwrap();
        assert!(
            client.reply()["text"]
                .as_str()
                .unwrap()
                .contains("not understood"),
            "{nonsense}"
        );
    }
    // a running system has no moments that a tab could ask for
    client.send(&json!({ "type": "seek", "t": 1.0, "span": 30.0, "window": true }));
    let reply = client.reply();
    assert!(reply["text"].as_str().unwrap().contains("runs"), "{reply}");
    // an acknowledgement of what was never sent opens no credit
    client.send(&json!({ "type": "ack", "seq": u64::MAX }));
    client.frame_with("seq");
}

#[test]
fn a_port_in_use_is_an_error_unless_another_one_will_do() {
    let first = Fixture::open(|_| {});
    let taken = first.address();
    let mut settings = DashboardSettings::at(taken);
    let source = || MonitorSource::new(SystemDescription::default(), None, Vec::new());
    let refused = Dashboard::open(settings.clone(), source()).unwrap_err();
    assert!(
        refused.to_string().contains(&taken.to_string()),
        "{refused}"
    );
    settings.or_free_port = true;
    let second = Dashboard::open(settings, source()).unwrap();
    assert_eq!(second.address().ip(), taken.ip());
    assert_ne!(second.address(), taken);
}

#[test]
fn every_response_forbids_the_page_to_load_from_elsewhere() {
    let fixture = Fixture::open(|_| {});
    for (path, headers) in [
        ("/", fixture.host()),
        ("/nothing", fixture.host()),
        ("/", String::new()),
    ] {
        let (head, _) = fixture.request(path, &headers);
        for part in [
            "content-security-policy: default-src 'self'",
            "frame-ancestors 'none'",
            "nosniff",
            "no-referrer",
        ] {
            assert!(head.contains(part), "{path}: {head}");
        }
        assert!(!head.contains("unsafe"), "{head}");
    }
}
