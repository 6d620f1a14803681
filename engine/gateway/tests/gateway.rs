//! A gateway on a local bus: every outcome of a call has its HTTP status.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, reason = "tests")]

mod client;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use asmotion_bus::{
    Bus, IncomingCall, LocalBus, Notifier, Payload, PublishOptions, Refusal, SenderId,
};
use asmotion_datum::{Datum, Message, Schema, Shape};
use asmotion_gateway::{BearerToken, Gateway, GatewayOperation, GatewayService, GatewaySettings};
use client::{Client, Said};
use serde_json::json;

asmotion_datum::message! {
    /// The type of requests.
    pub struct Question = "test/Question" {
        /// whose
        pub name: String,
        /// how many
        pub count: u32 = 1,
        pub range: f64,
        pub path: Vec<Point>,
    }

    #[derive(Copy)]
    pub struct Point = "test/Point" {
        pub x: f64,
        pub y: f64,
    }

    /// The type of responses.
    pub struct Reply = "test/Reply" {
        pub text: String,
        pub range: f64,
    }
}

const SECOND: Duration = Duration::from_secs(1);

/// A gateway to a service `maps`, and a thread in which a function handles its requests.
struct Open {
    gateway: Option<Gateway>,
    ended: Arc<AtomicBool>,
    server: Option<JoinHandle<()>>,
}

impl Open {
    fn new(
        change: impl FnOnce(&mut GatewaySettings),
        mut take: impl FnMut(IncomingCall) + Send + 'static,
    ) -> Self {
        let bus = LocalBus::new();
        let notifier = Arc::new(Notifier::new());
        let serving = ["get", "tell", "any"].map(|operation| {
            let address = format!("maps.{operation}");
            bus.serve(&address, 8, Arc::clone(&notifier)).unwrap()
        });
        let ended = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&ended);
        let server = std::thread::spawn(move || {
            while !end.load(Ordering::Relaxed) {
                serving
                    .iter()
                    .filter_map(asmotion_bus::ServedAddress::try_next)
                    .for_each(&mut take);
                notifier.wait(Duration::from_millis(5));
            }
        });
        let mut settings = GatewaySettings::at("127.0.0.1:0".parse().unwrap());
        change(&mut settings);
        let gateway = Gateway::open(settings, vec![maps(), empty()], Arc::new(bus)).unwrap();
        Self {
            gateway: Some(gateway),
            ended,
            server: Some(server),
        }
    }

    fn client(&self) -> Client {
        Client(self.gateway.as_ref().unwrap().address())
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        self.gateway = None;
        self.ended.store(true, Ordering::Relaxed);
        self.server.take().unwrap().join().unwrap();
    }
}

fn maps() -> GatewayService {
    let operation = |name: &str, request: Schema, one_way| GatewayOperation {
        name: name.to_owned(),
        request,
        response: Reply::schema().clone(),
        one_way,
    };
    GatewayService {
        name: "maps".to_owned(),
        interface: "test/Maps".to_owned(),
        timeout: 20 * SECOND,
        operations: vec![
            operation("get", Question::schema().clone(), false),
            operation("tell", Question::schema().clone(), true),
            operation("any", Schema::plain(Shape::Any), false),
        ],
    }
}

/// A service without a provider.
fn empty() -> GatewayService {
    GatewayService {
        name: "plans".to_owned(),
        ..maps()
    }
}

/// Publishes the description of a process on a bus.
fn describe(bus: &LocalBus, state: &str) {
    let component = json!({
        "name": "Coordinator", "id": "office_coordinator", "state": "Running", "cycles": 12, "properties": [["password", "secret"]],
        "inspection": [["state", { "mode": state }], ["calls", ["planner.plan"]]],
    });
    let presence = json!({ "process": "robot", "components": [component] }).to_string();
    let presence: Datum = asmotion_datum::json::decode(&presence).unwrap();
    let origin = SenderId::new("robot", 1);
    let kind = Schema::opaque("asmotion/Presence");
    let sending = PublishOptions::state();
    let mut publisher = bus
        .publisher("presence.robot", &origin, &kind, sending)
        .unwrap();
    publisher.publish(0, Payload::of(presence)).unwrap();
}

#[test]
fn components_are_listed_with_the_state_that_they_describe() {
    let bus = LocalBus::new();
    let settings = GatewaySettings::at("127.0.0.1:0".parse().unwrap());
    let gateway = Gateway::open(settings, vec![maps()], Arc::new(bus.clone())).unwrap();
    let client = Client(gateway.address());
    assert_eq!(client.get("/components").json, json!({ "components": [] }));
    describe(&bus, "PLANNING");
    describe(&bus, "FOLLOWING");
    let said = client.get("/components/Coordinator");
    let inspection = json!({ "state": { "mode": "FOLLOWING" }, "calls": ["planner.plan"] });
    assert_eq!((said.status, &said.json["inspection"]), (200, &inspection));
    assert_eq!(said.json["state"], "Running");
    assert!(!said.body.contains("secret"), "properties are confidential");
    let all = client.get("/components").json;
    assert_eq!(all["components"], json!([said.json]));
    let by_id = client.get("/components/office_coordinator");
    assert_eq!(
        (by_id.status, by_id.json["id"].as_str(), &by_id.json),
        (200, Some("office_coordinator"), &said.json)
    );
    let said = client.get("/components/office_coordinater");
    is_problem(
        &said,
        404,
        "NO_COMPONENT",
        &["did you mean `office_coordinator`?"],
    );
    let said = client.get("/components/Coordinater");
    is_problem(&said, 404, "NO_COMPONENT", &["did you mean `Coordinator`?"]);
    is_problem(
        &client.post("/components", "{}"),
        405,
        "OTHER_METHOD",
        &["GET"],
    );
}

/// Replies with the content of the request.
fn echo(call: IncomingCall) {
    let asked: Result<Question, _> = call.argument.read();
    call.reply(match asked {
        Ok(asked) => Ok(Payload::of(Reply {
            text: format!("{} {} {:?}", asked.name, asked.count, asked.path),
            range: asked.range,
        })),
        Err(error) => Err(Refusal {
            code: "BAD_REQUEST".to_owned(),
            detail: error.to_string(),
        }),
    });
}

/// Never replies.
fn silent() -> impl FnMut(IncomingCall) + Send {
    let mut kept = Vec::new();
    move |call| kept.push(call)
}

#[track_caller]
fn is_problem(said: &Said, status: u16, code: &str, words: &[&str]) {
    assert_eq!(
        (said.status, said.json["code"].as_str()),
        (status, Some(code)),
        "{said:?}"
    );
    assert_eq!(
        said.header("content-type"),
        Some("application/problem+json")
    );
    let text = said.json.to_string();
    for word in words {
        assert!(text.contains(word), "{text} does not say {word}");
    }
}

#[test]
fn an_operation_is_called_with_json_and_answers_with_json() {
    let open = Open::new(|_| {}, echo);
    let argument = json!({ "name": "office", "range": "Infinity", "path": [{ "x": 1 }, {}] });
    let said = open
        .client()
        .post("/services/maps/get", &argument.to_string());
    let text = "office 1 [Point { x: 1.0, y: 0.0 }, Point { x: 0.0, y: 0.0 }]";
    let expected = json!({ "text": text, "range": "Infinity" });
    assert_eq!((said.status, &said.json), (200, &expected));
    assert_eq!(said.header("content-type"), Some("application/json"));
    // an empty body means that all fields are omitted
    let said = open.client().post("/services/maps/get", "");
    assert_eq!(said.json, json!({ "text": " 1 []", "range": 0.0 }));
}

/// A provider that does not know the type gets the argument as a typed caller would have sent it.
#[test]
fn an_argument_has_the_type_of_the_operation() {
    let open = Open::new(
        |_| {},
        |call| {
            let said = call.argument.to_datum().unwrap().to_string();
            call.reply(Ok(Payload::of(Reply {
                text: said,
                range: 0.0,
            })));
        },
    );
    for (argument, expected) in [
        (
            r#"{"range": "NaN", "path": [{"x": 1}]}"#,
            r#"{name: "", count: 1, range: NaN, path: [{x: 1.0, y: 0.0}]}"#,
        ),
        ("", r#"{name: "", count: 1, range: 0.0, path: []}"#),
    ] {
        let said = open.client().post("/services/maps/get", argument);
        assert_eq!(said.json["text"], expected, "{argument}");
    }
}

#[test]
fn an_argument_that_does_not_fit_is_refused_at_its_place_before_anybody_is_asked() {
    let open = Open::new(|_| {}, |call| panic!("{call:?}"));
    let client = open.client();
    for (argument, words) in [
        (
            r#"{"nam": "a"}"#,
            &["unknown field `nam`", "`name`", "/services/maps"][..],
        ),
        (
            r#"{"name": 7}"#,
            &["`name`: expected `string`, found an integer"],
        ),
        (
            r#"{"count": -1}"#,
            &["`count`: -1 is not between 0 and 4294967295"],
        ),
        (
            r#"{"count": 1.5}"#,
            &["`count`: expected `uint32`, found a number"],
        ),
        (r#"{"range": "much"}"#, &["`range`"]),
        (r#"{"path": [{}, {"x": true}]}"#, &["`path.1.x`: expected"]),
        (r#"{"path": 1}"#, &["`path`"]),
        (
            r#"{"path": [{"x": 1, "x": 2}]}"#,
            &["`path.0`: the field `x` occurs twice"],
        ),
        (r"[1]", &["expected `test/Question`, found a list"]),
        (r#"{"name": "#, &["malformed JSON"]),
        ("\u{0}", &["malformed JSON"]),
    ] {
        for operation in ["get", "tell"] {
            let said = client.post(&format!("/services/maps/{operation}"), argument);
            is_problem(&said, 400, "BAD_REQUEST", words);
        }
    }
    let deep = "[".repeat(100_000);
    is_problem(
        &client.post("/services/maps/any", &deep),
        400,
        "BAD_REQUEST",
        &["JSON"],
    );
}

#[test]
fn every_end_of_a_call_has_its_status() {
    let mut open = Open::new(
        |_| {},
        |call| {
            let refusal = |code: &str| Refusal {
                code: code.to_owned(),
                detail: "no such map".to_owned(),
            };
            match call.argument.to_datum().unwrap().as_text() {
                Some("refuse") => call.reply(Err(refusal("NO_MAP"))),
                Some("misread") => call.reply(Err(refusal("BAD_REQUEST"))),
                Some("leave") => drop(call),
                _ => call.reply(Ok(Payload::of(Datum::Null))),
            }
        },
    );
    let any = |open: &Open, word: &str| open.client().post("/services/maps/any", word);
    assert_eq!(any(&open, "null").json, json!(null));
    is_problem(&any(&open, "\"refuse\""), 422, "NO_MAP", &["no such map"]);
    is_problem(
        &any(&open, "\"misread\""),
        400,
        "BAD_REQUEST",
        &["/services/maps"],
    );
    is_problem(&any(&open, "\"leave\""), 503, "UNAVAILABLE", &["`maps`"]);
    let nobody = open.client().post("/services/plans/get", "{}");
    is_problem(&nobody, 503, "UNAVAILABLE", &["`plans`"]);
    // a provider that has stopped
    open.ended.store(true, Ordering::Relaxed);
    open.server
        .replace(std::thread::spawn(|| {}))
        .unwrap()
        .join()
        .unwrap();
    is_problem(&any(&open, "1"), 503, "UNAVAILABLE", &["try again"]);
}

#[test]
fn the_callers_deadline_ends_a_call() {
    let open = Open::new(|_| {}, silent());
    let began = Instant::now();
    let said = open
        .client()
        .post("/services/maps/get?timeout_ms=150", "{}");
    is_problem(&said, 504, "TIMEOUT", &["within 150 ms", "?timeout_ms="]);
    let took = began.elapsed();
    assert!(
        took >= Duration::from_millis(150) && took < 10 * SECOND,
        "{took:?}"
    );
    let said = open.client().post("/services/maps/get?timeout=150", "{}");
    is_problem(&said, 400, "BAD_QUERY", &["timeout_ms=500"]);
}

#[test]
fn who_waits_for_no_answer_hears_that_it_was_accepted() {
    let (told, hears) = std::sync::mpsc::channel();
    let open = Open::new(
        |_| {},
        move |call| {
            told.send((call.is_one_way(), call.argument.to_datum().unwrap()))
                .unwrap()
        },
    );
    for path in ["/services/maps/tell", "/services/maps/any?oneway=true"] {
        let said = open.client().post(path, r#"{"name": "a"}"#);
        assert_eq!((said.status, said.body.as_str()), (202, ""));
        let (one_way, argument) = hears.recv_timeout(20 * SECOND).unwrap();
        assert!(one_way && argument.get("name").unwrap().as_text() == Some("a"));
    }
    let nobody = open.client().post("/services/plans/tell", "{}");
    is_problem(&nobody, 503, "UNAVAILABLE", &[]);
}

#[test]
fn who_hangs_up_has_taken_the_call_back() {
    let (came, comes) = std::sync::mpsc::channel();
    let open = Open::new(|_| {}, move |call| came.send(call).unwrap());
    let mut stream = TcpStream::connect(open.client().0).unwrap();
    let head = "POST /services/maps/get HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n";
    stream.write_all(head.as_bytes()).unwrap();
    let call = comes.recv_timeout(20 * SECOND).unwrap();
    assert!(call.is_awaited());
    drop(stream);
    let until = Instant::now() + 15 * SECOND;
    while call.is_awaited() {
        assert!(Instant::now() < until, "the call is still awaited");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn what_is_not_there_has_a_name_near_it() {
    let open = Open::new(|_| {}, echo);
    let client = open.client();
    for (path, code, words) in [
        (
            "/services/map/get",
            "NO_SERVICE",
            &["did you mean `maps`?"][..],
        ),
        (
            "/services/x/get",
            "NO_SERVICE",
            &["the services are maps, plans"],
        ),
        (
            "/services/maps/gett",
            "NO_OPERATION",
            &["did you mean `get`?"],
        ),
        ("/services/maps/move", "NO_OPERATION", &["get, tell, any"]),
        ("/", "NO_PATH_HERE", &["GET /services"]),
        ("/services/maps/get/more", "NO_PATH_HERE", &[]),
    ] {
        is_problem(&client.post(path, "{}"), 404, code, words);
    }
    is_problem(&client.get("/services/map"), 404, "NO_SERVICE", &["maps"]);
    let said = client.get("/services/maps/get");
    is_problem(&said, 405, "OTHER_METHOD", &["POST"]);
    assert_eq!(said.header("allow"), Some("POST"));
    is_problem(
        &client.post("/services", "{}"),
        405,
        "OTHER_METHOD",
        &["GET"],
    );
}

#[test]
fn it_says_what_can_be_called_and_with_what() {
    let open = Open::new(|_| {}, echo);
    assert_eq!(open.client().get("/health").json, json!({ "state": "UP" }));
    let all = open.client().get("/services").json;
    assert_eq!(all["services"][1]["name"], "plans");
    let mut one = open.client().get("/services/maps").json;
    assert_eq!(one["interface"], "test/Maps");
    assert_eq!(one["timeout_ms"], 20_000);
    let get = one["operations"][0].clone();
    assert_eq!(get["call"], "POST /services/maps/get");
    assert_eq!(one["operations"][1]["oneway"], true);
    assert_eq!(one["operations"][1].get("result"), None);
    // the request's schema and its definitions form one document
    one.as_object_mut()
        .unwrap()
        .extend(get["argument"].as_object().unwrap().clone());
    let schema = jsonschema::validator_for(&one).unwrap();
    assert!(schema.is_valid(&json!({ "name": "a", "path": [{ "x": 1.5 }], "range": "NaN" })));
    for wrong in [json!({ "nam": "a" }), json!({ "count": -1 }), json!(1)] {
        assert!(!schema.is_valid(&wrong), "{wrong}");
    }
}

#[test]
fn it_bears_no_more_than_it_was_told_to() {
    let limits = |settings: &mut GatewaySettings| {
        settings.max_body = 100;
        settings.max_connections = 1;
        settings.request_timeout = Duration::from_millis(300);
    };
    let open = Open::new(limits, echo);
    let client = open.client();
    let long = json!({ "name": "a".repeat(101) }).to_string();
    let said = client.post("/services/maps/get", &long);
    is_problem(&said, 413, "TOO_LARGE", &["100 bytes", "max_body_kb"]);
    let lying =
        "POST /services/maps/get HTTP/1.1\r\nHost: localhost\r\nContent-Length: 50\r\n\r\n{";
    is_problem(&client.say(lying), 408, "SLOW", &[]);
    let form = "POST /services/maps/get HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\
                Content-Type: application/x-www-form-urlencoded\r\n\r\n{}";
    is_problem(
        &client.say(form),
        415,
        "OTHER_CONTENT_TYPE",
        &["curl --json"],
    );
    let page = "POST /services/maps/get HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\
                Origin: http://elsewhere.example\r\n\r\n";
    is_problem(&client.say(page), 403, "WEB_PAGE", &["proxy"]);
    // an incomplete request does not block other clients
    let mut idle = TcpStream::connect(client.0).unwrap();
    idle.write_all(b"GET /hea").unwrap();
    assert_eq!(client.get("/health").status, 200);
    let mut heard = Vec::new();
    let _ = idle.read_to_end(&mut heard);
    assert!(heard.is_empty(), "it is hung up on");
    for noise in [
        "\r\n\r\n",
        "GET / HTTP/9\r\n\r\n",
        "\u{1}\u{2}\u{3}\r\n\r\n",
    ] {
        let mut stream = TcpStream::connect(client.0).unwrap();
        stream.write_all(noise.as_bytes()).unwrap();
        stream.shutdown(std::net::Shutdown::Write).unwrap();
        // refused by HTTP status, or the connection is closed
        let mut heard = Vec::new();
        let _ = stream.read_to_end(&mut heard);
        assert!(
            heard.is_empty() || heard.starts_with(b"HTTP/1.1 4"),
            "{noise:?}"
        );
    }
    assert_eq!(client.get("/health").status, 200);
}

#[test]
fn what_is_under_way_ends_before_the_gateway_is_closed() {
    let (came, comes) = std::sync::mpsc::channel();
    let mut open = Open::new(|_| {}, move |call| came.send(call).unwrap());
    let (client, address) = (open.client(), open.client().0);
    let caller = std::thread::spawn(move || client.post("/services/maps/get", "{}"));
    let call = comes.recv_timeout(20 * SECOND).unwrap();
    let gateway = open.gateway.take();
    let closing = std::thread::spawn(move || drop(gateway));
    // new connections are refused
    while TcpStream::connect(address).is_ok() {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(!closing.is_finished());
    echo(call);
    assert_eq!(caller.join().unwrap().status, 200);
    closing.join().unwrap();
}

/// A `GET /health` with these header lines.
fn health(client: &Client, headers: &[&str]) -> Said {
    let lines: String = headers.iter().map(|line| format!("{line}\r\n")).collect();
    client.say(&format!(
        "GET /health HTTP/1.1\r\nConnection: close\r\n{lines}\r\n"
    ))
}

#[test]
fn a_request_that_addresses_another_host_is_rejected() {
    let allowed = |settings: &mut GatewaySettings| {
        settings.allowed_hosts = vec!["rover1.local".to_owned()];
    };
    let open = Open::new(allowed, |call| panic!("{call:?}"));
    let client = open.client();
    for host in [
        "localhost",
        "localhost:8080",
        "127.0.0.1:8080",
        "[::1]:80",
        "Rover1.Local:8080",
    ] {
        assert_eq!(
            health(&client, &[&format!("Host: {host}")]).status,
            200,
            "{host}"
        );
    }
    for host in [
        "evil.example",
        "evil.example:8080",
        "localhost.evil.example",
        "rover1",
        "",
        "a b",
        "@",
    ] {
        let said = health(&client, &[&format!("Host: {host}")]);
        is_problem(&said, 421, "OTHER_HOST", &["allowed_hosts"]);
    }
    is_problem(
        &health(&client, &[]),
        421,
        "OTHER_HOST",
        &["request without a host"],
    );
    let absolute =
        "GET http://evil.example/services HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    is_problem(&client.say(absolute), 421, "OTHER_HOST", &["evil.example"]);
    let call = "POST /services/maps/get HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\nContent-Length: 0\r\n\r\n";
    is_problem(&client.say(call), 421, "OTHER_HOST", &["evil.example"]);
}

#[test]
fn a_gateway_with_a_token_handles_only_requests_that_present_it() {
    let secret = |settings: &mut GatewaySettings| {
        settings.token = Some(BearerToken::new("s3cret"));
    };
    let open = Open::new(secret, echo);
    let client = open.client();
    let host = "Host: localhost";
    assert_eq!(
        health(&client, &[host, "Authorization: Bearer s3cret"]).status,
        200
    );
    for wrong in [
        "X: y",
        "Authorization: Bearer s3cre",
        "Authorization: Basic s3cret",
        "Authorization: s3cret",
    ] {
        let said = health(&client, &[host, wrong]);
        is_problem(&said, 401, "NO_TOKEN", &["Authorization: Bearer"]);
        assert_eq!(said.header("www-authenticate"), Some("Bearer"));
    }
    is_problem(
        &client.post("/services/maps/get", "{}"),
        401,
        "NO_TOKEN",
        &[],
    );
    is_problem(&client.get("/services"), 401, "NO_TOKEN", &[]);
}

#[test]
fn callers_that_send_no_complete_request_shut_nobody_out() {
    let few = |settings: &mut GatewaySettings| {
        settings.max_connections = 4;
        settings.request_timeout = 60 * SECOND;
    };
    let open = Open::new(few, echo);
    let client = open.client();
    let begun = Instant::now();
    let mut held = Vec::new();
    for sent in [
        "",
        "GET /hea",
        "POST /services/maps/get HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 50\r\n\r\n{",
        // a complete request on a connection that is kept open
        "GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n",
    ] {
        for _ in 0..4 {
            let mut stream = TcpStream::connect(client.0).unwrap();
            stream.write_all(sent.as_bytes()).unwrap();
            held.push(stream);
        }
        assert_eq!(client.get("/health").status, 200, "{sent:?}");
        assert_eq!(
            client.post("/services/maps/get", "{}").status,
            200,
            "{sent:?}"
        );
    }
    assert!(begun.elapsed() < 20 * SECOND, "{:?}", begun.elapsed());
    // the first to be idle was the first to be closed
    let mut first = held.remove(0);
    first.set_read_timeout(Some(20 * SECOND)).unwrap();
    let mut heard = Vec::new();
    let end = first.read_to_end(&mut heard);
    let is_closed = end.is_ok_and(|_| heard.is_empty());
    assert!(is_closed, "{heard:?}");
}

#[test]
fn further_callers_hear_at_once_that_calls_are_under_way_on_all_connections() {
    let (came, comes) = std::sync::mpsc::channel();
    let few = |settings: &mut GatewaySettings| settings.max_connections = 2;
    let open = Open::new(few, move |call| came.send(call).unwrap());
    let callers = [(); 2].map(|()| {
        let client = open.client();
        std::thread::spawn(move || client.post("/services/maps/get", "{}"))
    });
    let calls = [(); 2].map(|()| comes.recv_timeout(20 * SECOND).unwrap());
    for _ in 0..3 {
        let said = open.client().get("/health");
        is_problem(&said, 503, "BUSY", &["max_connections"]);
        assert_eq!(said.header("retry-after"), Some("1"));
    }
    calls.into_iter().for_each(echo);
    for caller in callers {
        assert_eq!(caller.join().unwrap().status, 200);
    }
    assert_eq!(open.client().get("/health").status, 200);
}
