//! Peers that lie: masters, publishers and subscribers written for the test. They need no ROS.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::time::Duration;

use asmotion_bus::LinkState;
use asmotion_ros1::header::ConnectionHeader;
use asmotion_ros1::xmlrpc::{XmlRpcValue, read_call, read_response, write_call, write_response};
use asmotion_ros1::{RosNotice, RosUri};

use asmotion_ros_master::{TestNode, all, eventually, notifier, string, topic_type};

/// Reads a request or response of HTTP, and returns its body.
fn body(stream: &mut TcpStream) -> Option<Vec<u8>> {
    let (mut bytes, mut chunk) = (Vec::new(), [0; 4096]);
    loop {
        let text = String::from_utf8_lossy(&bytes).to_lowercase();
        if let Some(at) = text.find("\r\n\r\n") {
            let length = text.split("content-length:").nth(1)?;
            let length: usize = length.split("\r\n").next()?.trim().parse().ok()?;
            if bytes.len() >= at + 4 + length {
                return Some(bytes[at + 4..at + 4 + length].to_vec());
            }
        }
        match stream.read(&mut chunk).ok()? {
            0 => return None,
            read => bytes.extend(&chunk[..read]),
        }
    }
}

/// A server of HTTP that answers each call with what `answer` writes. Returns its port.
fn server(answer: impl Fn(&str, &mut TcpStream) + Send + Sync + 'static) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let answer = Arc::new(answer);
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let answer = Arc::clone(&answer);
            std::thread::spawn(move || {
                if let Some(body) = body(&mut stream) {
                    let method = read_call(&body).map_or_else(|_| "?".to_owned(), |it| it.method);
                    answer(&method, &mut stream);
                }
            });
        }
    });
    port
}

fn reply(stream: &mut TcpStream, text: &str) {
    let length = text.len();
    let head =
        format!("HTTP/1.1 200 OK\r\nContent-Type: text/xml\r\nContent-Length: {length}\r\n\r\n");
    let _ = stream.write_all(head.as_bytes());
    let _ = stream.write_all(text.as_bytes());
}

fn triple(value: XmlRpcValue) -> XmlRpcValue {
    XmlRpcValue::Array(vec![XmlRpcValue::Int(1), XmlRpcValue::text(""), value])
}

/// Calls a method of the API of a node.
fn call(uri: &str, method: &str, parameters: &[XmlRpcValue]) -> XmlRpcValue {
    let uri: RosUri = uri.parse().unwrap();
    let mut stream = TcpStream::connect((uri.host(), uri.port())).unwrap();
    let text = write_call(method, parameters);
    let length = text.len();
    write!(
        stream,
        "POST /RPC2 HTTP/1.1\r\nHost: x\r\nContent-Length: {length}\r\n\r\n{text}"
    )
    .unwrap();
    read_response(&body(&mut stream).unwrap()).unwrap().unwrap()
}

/// The port for topics and services of a node that publishes a topic.
fn data_port(uri: &str, topic: &str) -> u16 {
    let protocol = XmlRpcValue::Array(vec![XmlRpcValue::text("TCPROS")]);
    let parameters = [
        XmlRpcValue::text("/test"),
        XmlRpcValue::text(topic),
        XmlRpcValue::Array(vec![protocol]),
    ];
    let answer = call(uri, "requestTopic", &parameters);
    let endpoint = answer.as_array().unwrap()[2].as_array().unwrap();
    u16::try_from(endpoint[2].as_int().unwrap()).unwrap()
}

/// A port at which nothing listens.
fn nowhere() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

#[test]
fn a_master_that_lies_is_an_error_with_a_reason() {
    let text = |value: &XmlRpcValue| write_response(Ok(value));
    let number = XmlRpcValue::Int(7);
    let lies = [
        (String::new(), "not XML-RPC"),
        ("\u{0}<<<>>>".to_owned(), "not XML-RPC"),
        (text(&number), "`[code, status, value]`"),
        (text(&XmlRpcValue::Array(vec![])), "`[code, status, value]`"),
        (text(&triple(XmlRpcValue::text("x"))), "not a number"),
        (write_response(Err("broken")), "broken"),
        (
            "<methodResponse><params><param>".to_owned() + &"<value><array><data>".repeat(90_000),
            "more than 32",
        ),
    ];
    for (lie, expected) in lies {
        let port = server(move |_, stream| reply(stream, &lie));
        let node = TestNode::start(port, "/robot", |_| ());
        eventually(expected, || match node.node.health().link {
            LinkState::Down { reason } => reason.contains(expected).then_some(()),
            LinkState::Up | LinkState::Blocked { .. } => None,
        });
        assert!(node.node.graph().is_err());
    }
}

#[test]
fn endless_answers_of_a_master_are_cut_off() {
    let port = server(|_, stream| {
        let _ = stream.write_all(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n");
        let chunk = format!("10000\r\n{}\r\n", " ".repeat(0x10000));
        while stream.write_all(chunk.as_bytes()).is_ok() {}
    });
    let node = TestNode::start(port, "/robot", |settings| {
        settings.limits.answer = 1 << 20;
    });
    eventually("the limit is the reason", || {
        match node.node.health().link {
            LinkState::Down { reason } => {
                reason.contains("the limit is 1048576 bytes").then_some(())
            }
            LinkState::Up | LinkState::Blocked { .. } => None,
        }
    });
    // one that says nothing at all
    let port = server(|_, _| std::thread::sleep(Duration::from_secs(60)));
    let node = TestNode::start(port, "/robot", |settings| {
        settings.timing.call = Duration::from_millis(200);
    });
    eventually("the time is the reason", || match node.node.health().link {
        LinkState::Down { reason } => reason.contains("no answer within 200ms").then_some(()),
        LinkState::Up | LinkState::Blocked { .. } => None,
    });
}

#[test]
fn wrong_lists_of_a_master_do_no_harm() {
    let port = server(|method, stream| {
        let value = match method {
            "registerSubscriber" => XmlRpcValue::Array(vec![
                XmlRpcValue::text("ftp://x"),
                XmlRpcValue::text("http://127.0.0.1:99999/"),
                XmlRpcValue::text("\u{0}"),
            ]),
            _ => XmlRpcValue::Int(1),
        };
        reply(stream, &write_response(Ok(&triple(value))));
    });
    let node = TestNode::start(port, "/robot", |settings| settings.limits.publishers = 4);
    let of = topic_type("std_msgs/String");
    let _heard = node
        .node
        .subscribe("heard", Some(of), all(1), notifier())
        .unwrap();
    let reports = |node: &TestNode, text: &str| {
        let notices = node.notices();
        notices
            .iter()
            .filter(|it| it.to_string().contains(text))
            .count()
    };
    eventually("two addresses are reported", || {
        (reports(&node, "is not the address of a master or node") >= 2).then_some(())
    });
    let many =
        (0..1000).map(|number| XmlRpcValue::Text(format!("http://127.0.0.1:{}/", number + 1)));
    let parameters = [
        XmlRpcValue::text("/master"),
        XmlRpcValue::text("/heard"),
        XmlRpcValue::Array(many.collect()),
    ];
    call(&node.node.uri(), "publisherUpdate", &parameters);
    assert_eq!(reports(&node, "1000 publishers; the limit is 4"), 1);
    for parameters in [
        vec![],
        vec![XmlRpcValue::Int(1)],
        vec![
            XmlRpcValue::text("a"),
            XmlRpcValue::text("/heard"),
            XmlRpcValue::Int(1),
        ],
    ] {
        for method in ["publisherUpdate", "paramUpdate", "requestTopic"] {
            let answer = call(&node.node.uri(), method, &parameters);
            assert_eq!(
                answer.as_array().unwrap()[0],
                XmlRpcValue::Int(-1),
                "{method}"
            );
        }
    }
    let deep = [
        XmlRpcValue::text("/master"),
        XmlRpcValue::Text("/speed".to_owned() + &"/a".repeat(200_000)),
        XmlRpcValue::Int(1),
    ];
    let _followed = node
        .node
        .follow_parameter("speed", all(1), notifier())
        .unwrap();
    let answer = call(&node.node.uri(), "paramUpdate", &deep);
    assert_eq!(answer.as_array().unwrap()[0], XmlRpcValue::Int(-1));
}

#[test]
fn wrong_headers_and_endless_calls_do_not_disturb_subscribers() {
    let node = TestNode::start(nowhere(), "/robot", |settings| {
        settings.timing.connect = Duration::from_millis(300);
    });
    let of = topic_type("std_msgs/String");
    let publisher = node.node.publisher("said", of.clone(), 10, false).unwrap();
    let port = data_port(&node.node.uri(), "/said");
    let unreadable = || {
        let notices = node.notices();
        let found = notices
            .iter()
            .filter(|it| matches!(it, RosNotice::Unreadable { .. }));
        found.count()
    };
    let bad: [&[u8]; 6] = [
        b"\xff\xff\xff\xff",
        b"\x00\x00\x00\x01\x02",
        b"\x08\0\0\0\xff\xff\xff\xff....",
        b"\x07\0\0\0\x03\0\0\0a=\xff",
        b"\x06\0\0\0\x02\0\0\0ab",
        b"",
    ];
    for (number, bytes) in bad.iter().enumerate() {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.write_all(bytes).unwrap();
        // kept open: the node ends the connection itself
        eventually("it is reported", || {
            (unreadable() == number + 1).then_some(())
        });
        assert!(!matches!(stream.read(&mut [0; 16]), Ok(read) if read > 0));
    }
    // a call without end, and one that is no call
    let uri: RosUri = node.node.uri().parse().unwrap();
    let mut endless = TcpStream::connect((uri.host(), uri.port())).unwrap();
    write!(
        endless,
        "POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 999999999999\r\n\r\n"
    )
    .unwrap();
    let chunk = vec![b' '; 1 << 20];
    let sent = (0..64)
        .take_while(|_| endless.write_all(&chunk).is_ok())
        .count();
    assert!(sent < 64, "{sent} MiB are taken");
    let header = ConnectionHeader::new()
        .with("callerid", "/good")
        .with("topic", "/said")
        .with("md5sum", "*")
        .with("type", "*");
    let mut good = TcpStream::connect(("127.0.0.1", port)).unwrap();
    good.write_all(&header.encode()).unwrap();
    eventually("a good one connects", || {
        (publisher.counts().subscribers.len() == 1).then_some(())
    });
    publisher.publish(&string("hello")).unwrap();
    let mut length = [0; 4];
    good.read_exact(&mut length).unwrap();
    let mut header = vec![0; u32::from_le_bytes(length) as usize];
    good.read_exact(&mut header).unwrap();
    let header = ConnectionHeader::decode(&header).unwrap();
    assert_eq!(header.get("md5sum"), Some(&*of.md5));
    let mut message = [0; 13];
    good.read_exact(&mut message).unwrap();
    assert_eq!(&message, b"\x09\0\0\0\x05\0\0\0hello");
}

/// A publisher of `std_msgs/String` that sends these bytes after its header. Returns the address of its API.
fn publisher(bytes: Vec<u8>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        for mut stream in listener.incoming().flatten() {
            let mut length = [0; 4];
            if stream.read_exact(&mut length).is_err() {
                continue;
            }
            let mut header = vec![0; u32::from_le_bytes(length) as usize];
            stream.read_exact(&mut header).unwrap();
            let of = topic_type("std_msgs/String");
            let header = ConnectionHeader::new()
                .with("callerid", "/liar")
                .with("md5sum", of.md5)
                .with("type", of.name);
            let _ = stream.write_all(&header.encode());
            let _ = stream.write_all(&bytes);
            std::thread::sleep(Duration::from_millis(300));
        }
    });
    let api = server(move |_, stream| {
        let endpoint = XmlRpcValue::Array(vec![
            XmlRpcValue::text("TCPROS"),
            XmlRpcValue::text("127.0.0.1"),
            XmlRpcValue::Int(i64::from(port)),
        ]);
        reply(stream, &write_response(Ok(&triple(endpoint))));
    });
    format!("http://127.0.0.1:{api}/")
}

#[test]
fn wrong_messages_are_counted_and_good_ones_still_arrive() {
    let good = b"\x09\0\0\0\x05\0\0\0hello";
    let too_long = b"\x09\0\0\0\xff\xff\xff\xffhello";
    let no_text = b"\x05\0\0\0\x01\0\0\0\xff";
    let huge = b"\xff\xff\xff\xff";
    let bytes = [&good[..], too_long, no_text, good, huge].concat();
    let node = TestNode::start(nowhere(), "/robot", |settings| {
        settings.limits.message = 1 << 16
    });
    let of = topic_type("std_msgs/String");
    let heard = node
        .node
        .subscribe("heard", Some(of), all(2), notifier())
        .unwrap();
    let update = |publishers: Vec<XmlRpcValue>| {
        let parameters = [
            XmlRpcValue::text("/master"),
            XmlRpcValue::text("/heard"),
            XmlRpcValue::Array(publishers),
        ];
        call(&node.node.uri(), "publisherUpdate", &parameters);
    };
    update(vec![XmlRpcValue::Text(publisher(bytes))]);
    for sequence in [1, 4] {
        let envelope = heard
            .next_within(asmotion_ros_master::SOON)
            .expect("a message");
        assert_eq!((envelope.sequence, &*envelope.source), (sequence, "/liar"));
        assert_eq!(envelope.payload.to_datum().unwrap(), string("hello"));
    }
    let counts = eventually("all are counted", || {
        let counts = node.node.subscription_counts("heard").unwrap().unwrap();
        (counts.unreadable >= 3).then_some(counts)
    });
    assert!(counts.received >= 2, "{counts:?}");
    for text in [
        "4294967295 bytes; the limit is 65536",
        "cannot read a message on `/heard` from /liar",
    ] {
        // notices follow the counts
        node.notice(text, |notice| {
            notice.to_string().contains(text).then_some(())
        });
    }
    // no longer listed, no longer asked
    update(vec![]);
    let counts = node.node.subscription_counts("heard").unwrap().unwrap();
    std::thread::sleep(Duration::from_millis(700));
    assert_eq!(
        node.node.subscription_counts("heard").unwrap().unwrap(),
        counts
    );
    assert_eq!(counts.publishers, 0);
}
