//! Calls of services of other systems: of a gateway, and of servers that misbehave.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "tests")]

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use asmotion_bus::{
    Bus, CallFailure, IncomingCall, LocalBus, Notifier, Payload, PendingCall, Refusal, Request,
    SenderId, ServiceClient, TraceContext,
};
use asmotion_datum::{Datum, Schema, Shape};
use asmotion_gateway::{
    BearerToken, Gateway, GatewayOperation, GatewayService, GatewaySettings, HttpClient,
};

const SECOND: Duration = Duration::from_secs(1);

/// A gateway to the operation `maps.any`, whose requests a function handles.
fn gateway(token: Option<&str>, mut take: impl FnMut(IncomingCall) + Send + 'static) -> Gateway {
    let bus = LocalBus::new();
    let served = bus.serve("maps.any", 8, Arc::new(Notifier::new())).unwrap();
    std::thread::spawn(move || {
        loop {
            if let Some(call) = served.next_within(SECOND) {
                take(call);
            }
        }
    });
    let any = GatewayOperation {
        name: "any".to_owned(),
        request: Schema::plain(Shape::Any),
        response: Schema::plain(Shape::Any),
        one_way: false,
    };
    let maps = GatewayService {
        name: "maps".to_owned(),
        interface: "test/Maps".to_owned(),
        timeout: 20 * SECOND,
        operations: vec![any],
    };
    let mut settings = GatewaySettings::at("127.0.0.1:0".parse().unwrap());
    settings.token = token.map(BearerToken::new);
    Gateway::open(settings, vec![maps], Arc::new(bus)).unwrap()
}

fn any_of(gateway: &Gateway) -> String {
    format!("http://{}/services/maps/any", gateway.address())
}

/// A server in a thread: a function handles each of its connections.
struct Peer {
    address: SocketAddr,
    connections: Arc<AtomicUsize>,
}

impl Peer {
    fn new(mut handle: impl FnMut(&mut TcpStream) + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let connections = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&connections);
        std::thread::spawn(move || {
            for mut stream in listener.incoming().map_while(Result::ok) {
                counted.fetch_add(1, Ordering::Relaxed);
                handle(&mut stream);
            }
        });
        Self {
            address,
            connections,
        }
    }

    /// A server that reads a request, sends these bytes and closes the connection.
    fn saying(bytes: impl Into<Vec<u8>>) -> Self {
        let bytes = bytes.into();
        Self::new(move |stream| {
            request(stream);
            // the client may have closed the connection
            let _ = stream.write_all(&bytes);
        })
    }

    fn url(&self) -> String {
        format!("http://{}/any", self.address)
    }
}

/// Reads a request: its head, and its body.
fn request(stream: &mut TcpStream) -> (String, String) {
    let mut reader = BufReader::new(stream);
    let mut head = String::new();
    while reader.read_line(&mut head).unwrap_or(0) > 2 {}
    let length = head
        .to_ascii_lowercase()
        .lines()
        .find_map(|line| line.strip_prefix("content-length: ")?.parse().ok());
    let mut body = vec![0; length.unwrap_or(0)];
    reader.read_exact(&mut body).unwrap();
    (head, String::from_utf8(body).unwrap())
}

fn response(status: &str, body: &str) -> String {
    let length = body.len();
    format!(
        "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}"
    )
}

fn word(word: &str) -> Payload {
    Payload::of(Datum::Text(word.into()))
}

fn start(
    service: &dyn ServiceClient,
    url: &str,
    argument: Payload,
    timeout: Duration,
    one_way: bool,
) -> PendingCall {
    let mut request = Request::new(SenderId::new("Caller", 1), argument, timeout);
    request.trace = Some(TraceContext { id: 7, span: 9 });
    let notifier = Arc::new(Notifier::new());
    service.call(url, request, one_way, notifier).unwrap()
}

/// The result of a call, as text.
fn result(payload: Payload) -> String {
    let datum = payload.to_datum().unwrap();
    asmotion_datum::json::encode(&datum).unwrap()
}

fn call(url: &str, timeout: Duration) -> Result<String, CallFailure> {
    let client = HttpClient::start(None).unwrap();
    let pending = start(
        &*client.service(None, None).unwrap(),
        url,
        word("office"),
        timeout,
        false,
    );
    pending.wait().map(result)
}

#[track_caller]
fn is_refused(result: Result<String, CallFailure>, code: &str, words: &str) {
    let Err(CallFailure::Refused(refusal)) = result else {
        panic!("{result:?}");
    };
    assert_eq!(refusal.code, code, "{refusal}");
    assert!(refusal.detail.contains(words), "{refusal}");
}

#[test]
fn every_end_of_a_call_of_a_gateway_is_that_of_the_operation() {
    let gateway = gateway(Some("s3cret"), |call| {
        let refusal = |code: &str| Refusal {
            code: code.to_owned(),
            detail: "no such map".to_owned(),
        };
        match call.argument.to_datum().unwrap().as_text() {
            Some("refuse") => call.reply(Err(refusal("NO_MAP"))),
            Some("leave") => drop(call),
            Some("wait") => std::mem::forget(call),
            _ => {
                let argument = call.argument.clone();
                call.reply(Ok(argument));
            }
        }
    });
    let url = any_of(&gateway);
    let client = HttpClient::start(None).unwrap();
    let service = client
        .service(Some(BearerToken::new("s3cret")), None)
        .unwrap();
    let call = |argument: &str, timeout| {
        let pending = start(&*service, &url, word(argument), timeout, false);
        pending.wait().map(result)
    };
    assert_eq!(call("office", 20 * SECOND), Ok("\"office\"".to_owned()));
    is_refused(call("refuse", 20 * SECOND), "NO_MAP", "no such map");
    assert_eq!(call("leave", 20 * SECOND), Err(CallFailure::Unavailable));
    let began = Instant::now();
    assert_eq!(call("wait", SECOND / 5), Err(CallFailure::Timeout));
    assert!(began.elapsed() < 10 * SECOND);
    let stranger = client
        .service(Some(BearerToken::new("guess")), None)
        .unwrap();
    let pending = start(&*stranger, &url, word("office"), SECOND, false);
    is_refused(pending.wait().map(result), "NO_TOKEN", "token");
    let told = start(&*service, &url, word("office"), 20 * SECOND, true);
    assert_eq!(told.wait().map(result), Ok("null".to_owned()));
}

#[test]
fn a_cancelled_call_is_cancelled_at_the_provider() {
    let (taken, takes) = mpsc::channel();
    let gateway = gateway(None, move |call| taken.send(call).unwrap());
    let client = HttpClient::start(None).unwrap();
    let service = client.service(None, None).unwrap();
    let pending = start(&*service, &any_of(&gateway), word("x"), 60 * SECOND, false);
    let call = takes.recv_timeout(20 * SECOND).unwrap();
    assert!(call.is_awaited());
    pending.cancel();
    let until = Instant::now() + 20 * SECOND;
    while call.is_awaited() {
        assert!(Instant::now() < until, "it is still awaited");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_request_has_the_argument_the_deadline_the_trace_and_the_token() {
    let (said, hears) = mpsc::channel();
    let peer = Peer::new(move |stream| {
        said.send(request(stream)).unwrap();
        stream
            .write_all(response("200 OK", "{\"x\": 1.5}").as_bytes())
            .unwrap();
    });
    let client = HttpClient::start(None).unwrap();
    let service = client
        .service(Some(BearerToken::new("s3cret")), None)
        .unwrap();
    let pending = start(&*service, &peer.url(), word("office"), 5 * SECOND, false);
    assert_eq!(pending.wait().map(result), Ok("{\"x\":1.5}".to_owned()));
    let (head, body) = hears.recv().unwrap();
    assert_eq!(body, "\"office\"");
    let head = head.to_ascii_lowercase();
    let (line, _) = head.split_once("\r\n").unwrap();
    let timeout_ms = line
        .strip_prefix("post /any?timeout_ms=")
        .and_then(|rest| rest.strip_suffix(" http/1.1"));
    let timeout_ms: u64 = timeout_ms.unwrap().parse().unwrap();
    assert!((1000..=5000).contains(&timeout_ms), "{timeout_ms}");
    for header in [
        format!("host: {}", peer.address),
        "content-type: application/json".to_owned(),
        "authorization: bearer s3cret".to_owned(),
        "traceparent: 00-00000000000000000000000000000007-0000000000000009-01".to_owned(),
    ] {
        assert!(head.contains(&format!("{header}\r\n")), "{head}");
    }
}

#[test]
fn a_connection_is_used_again_and_a_closed_one_is_replaced() {
    let mut kept = Vec::new();
    let (close, closes) = mpsc::channel::<()>();
    let peer = Peer::new(move |stream| {
        let mut stream = stream.try_clone().unwrap();
        // two requests for each connection
        for _ in 0..2 {
            request(&mut stream);
            stream
                .write_all(response("200 OK", "1").as_bytes())
                .unwrap();
        }
        closes.recv().unwrap();
        kept.clear();
        stream.shutdown(std::net::Shutdown::Both).unwrap();
        kept.push(());
    });
    let client = HttpClient::start(None).unwrap();
    let service = client.service(None, None).unwrap();
    let call = || start(&*service, &peer.url(), word("x"), 20 * SECOND, false).wait();
    for calls in [1, 2] {
        assert_eq!(call().map(result), Ok("1".to_owned()));
        assert_eq!(peer.connections.load(Ordering::Relaxed), 1, "{calls}");
    }
    close.send(()).unwrap();
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(call().map(result), Ok("1".to_owned()));
    assert_eq!(peer.connections.load(Ordering::Relaxed), 2);
}

/// Calls a server that is unavailable. Returns the reason.
#[track_caller]
fn reason(url: &str) -> String {
    let client = HttpClient::start(None).unwrap();
    let service = client.service(None, None).unwrap();
    let pending = start(&*service, url, word("office"), 20 * SECOND, false);
    let end = loop {
        match pending.try_take() {
            Some(end) => break end,
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    assert_eq!(end.map(result), Err(CallFailure::Unavailable));
    pending.reason().unwrap().to_owned()
}

#[test]
fn a_server_that_is_not_there_is_unavailable_before_the_deadline() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/any", listener.local_addr().unwrap());
    drop(listener);
    let refused = reason(&url);
    assert!(
        refused.starts_with("cannot connect: Connection refused"),
        "{refused}"
    );
    let unknown = reason("http://nowhere.invalid/any");
    assert!(unknown.contains("lookup"), "{unknown}");
}

#[test]
fn a_server_that_is_unavailable_says_so_itself() {
    let details = r#"{"code":"BUSY","detail":"calls are under way on all connections"}"#;
    for (status, body, expected) in [
        (
            "503 Service Unavailable",
            "<html>",
            "the server answers `503 Service Unavailable`",
        ),
        (
            "503 Service Unavailable",
            details,
            "the server answers `503 Service Unavailable`: calls are under way on all connections",
        ),
        (
            "429 Too Many Requests",
            "",
            "the server answers `429 Too Many Requests`",
        ),
    ] {
        let peer = Peer::saying(response(status, body));
        assert_eq!(reason(&peer.url()), expected);
    }
}

#[test]
fn a_server_that_does_not_encrypt_is_a_fault_with_the_reason() {
    let peer = Peer::saying(response("200 OK", "1"));
    let url = peer.url().replace("http:", "https:");
    is_refused(call(&url, 20 * SECOND), "NO_TLS", "");
}

#[test]
fn a_status_without_problem_details_is_a_fault_of_its_own() {
    let ends = [
        (
            "500 Internal Server Error",
            "HTTP_500",
            "Internal Server Error",
        ),
        ("404 Not Found", "HTTP_404", "Not Found"),
        ("502 Bad Gateway", "HTTP_502", "Bad Gateway"),
    ];
    for (status, code, words) in ends {
        let peer = Peer::saying(response(status, "<html>"));
        is_refused(call(&peer.url(), 20 * SECOND), code, words);
    }
    let stopped = r#"{"code":"STOPPED"}"#;
    for (status, body, failure) in [
        ("503 Service Unavailable", "", CallFailure::Unavailable),
        (
            "503 Service Unavailable",
            "<html>",
            CallFailure::Unavailable,
        ),
        ("503 Service Unavailable", stopped, CallFailure::Stopped),
        ("429 Too Many Requests", stopped, CallFailure::Unavailable),
        ("504 Gateway Timeout", "", CallFailure::Timeout),
    ] {
        let peer = Peer::saying(response(status, body));
        assert_eq!(call(&peer.url(), 20 * SECOND), Err(failure), "{status}");
    }
}

#[test]
fn a_redirect_is_not_followed() {
    let other = Peer::saying(response("200 OK", "1"));
    let url = other.url();
    let redirect = format!("HTTP/1.1 307 Moved\r\nLocation: {url}\r\nContent-Length: 0\r\n\r\n");
    let peer = Peer::saying(redirect);
    is_refused(call(&peer.url(), 20 * SECOND), "HTTP_307", &url);
    assert_eq!(other.connections.load(Ordering::Relaxed), 0);
}

#[test]
fn a_response_that_is_none_is_a_fault() {
    let html = "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: 6\r\n\r\n<html>";
    for (bytes, code, words) in [
        ("SSH-2.0-OpenSSH_9.2\r\n", "BAD_REPLY", ""),
        (
            "HTTP/1.1 200 OK\r\nContent-Length: x\r\n\r\n",
            "BAD_REPLY",
            "",
        ),
        (html, "BAD_REPLY", "text/html"),
        ("", "NO_REPLY", ""),
        ("HTTP/1.1 200 OK\r\nContent-Le", "NO_REPLY", ""),
        (
            "HTTP/1.1 200 OK\r\nContent-Length: 10\r\n\r\n[1, 2",
            "NO_REPLY",
            "early",
        ),
        (
            "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n5\r\n[1",
            "NO_REPLY",
            "early",
        ),
    ] {
        let peer = Peer::saying(bytes);
        is_refused(call(&peer.url(), 20 * SECOND), code, words);
    }
}

#[test]
fn a_response_is_limited_in_size_and_time() {
    let huge = Peer::new(|stream| {
        request(stream);
        let head = b"HTTP/1.1 200 OK\r\nContent-Length: 100000000\r\n\r\n";
        let mut sent = stream.write_all(head);
        while sent.is_ok() {
            sent = stream.write_all(&[b' '; 65536]);
        }
    });
    is_refused(call(&huge.url(), 60 * SECOND), "TOO_LARGE", "longer");
    // the announced length alone: nothing follows
    let announced = Peer::new(|stream| {
        request(stream);
        let head = b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n[";
        stream.write_all(head).unwrap();
        let _ = stream.read_to_end(&mut Vec::new());
    });
    is_refused(call(&announced.url(), 60 * SECOND), "TOO_LARGE", "longer");
    let slow = Peer::new(|stream| {
        request(stream);
        let mut sent = stream.write_all(b"HTTP/1.1 200 OK\r\nX: ");
        while sent.is_ok() {
            std::thread::sleep(Duration::from_millis(20));
            sent = stream.write_all(b"x");
        }
    });
    let began = Instant::now();
    assert_eq!(call(&slow.url(), SECOND / 5), Err(CallFailure::Timeout));
    assert!(began.elapsed() < 10 * SECOND);
}

#[test]
fn calls_beyond_the_limit_and_calls_of_a_dropped_client_are_unavailable() {
    let mut kept = Vec::new();
    let peer = Peer::new(move |stream| kept.push(stream.try_clone().unwrap()));
    let client = HttpClient::start(None).unwrap();
    let service = client.service(None, None).unwrap();
    let call = || start(&*service, &peer.url(), word("x"), 60 * SECOND, false);
    let mut pending: Vec<_> = (0..64).map(|_| call()).collect();
    assert_eq!(call().wait().map(result), Err(CallFailure::Unavailable));
    drop(client);
    for pending in pending.drain(..) {
        assert_eq!(pending.wait().map(result), Err(CallFailure::Unavailable));
    }
    assert_eq!(call().wait().map(result), Err(CallFailure::Unavailable));
}
