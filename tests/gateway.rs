//! Services over HTTP: promoted operations are called by clients without access to the bus.

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::io::{BufRead, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::processes::Running;

const MAPS: &str = r#"
schema = "composite/1"
[composite]
name = "maps"
[gateways.main]
listen = "127.0.0.1:${PORT:-0}"
[components.MapServer]
implementation = { rust = "nav::MapServer" }
task           = { period_ms = 20 }
services       = { maps = "nav/MapService" }
properties     = { source = "${MAPS}" }
[[promote]]
service = "MapServer.maps"
as      = "maps"
binding = "http"
"#;

/// Writes a composite into a new folder.
fn composite(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("main.composite.toml");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn run(composite: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    command.arg("run").arg(composite).args(arguments);
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/navigation/maps");
    command.env("MAPS", maps);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Calls an operation over HTTP, with `curl` if it is installed. Returns the status and the body.
pub(super) fn post(url: &str, argument: &str) -> (u16, Value) {
    let mut command = Command::new("curl");
    command.args([
        "-sS",
        "-H",
        "Content-Type: application/json",
        "-w",
        "\n%{http_code}",
    ]);
    command.args(["-d", argument, url]);
    let said = match command.output() {
        Ok(output) => String::from_utf8(output.stdout).unwrap(),
        Err(_) => said(url, argument),
    };
    let (body, status) = said.rsplit_once('\n').unwrap();
    let body = serde_json::from_str(body).unwrap_or(Value::Null);
    (status.parse().unwrap(), body)
}

/// The output that `curl` would print.
fn said(url: &str, argument: &str) -> String {
    let (address, path) = url
        .strip_prefix("http://")
        .unwrap()
        .split_once('/')
        .unwrap();
    let mut stream = TcpStream::connect(address.parse::<SocketAddr>().unwrap()).unwrap();
    let length = argument.len();
    let request = format!(
        "POST /{path} HTTP/1.1\r\nHost: {address}\r\nContent-Type: application/json\r\n\
         Connection: close\r\nContent-Length: {length}\r\n\r\n{argument}"
    );
    stream.write_all(request.as_bytes()).unwrap();
    let mut said = String::new();
    stream.read_to_string(&mut said).unwrap();
    let (head, body) = said.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap();
    format!("{body}\n{status}")
}

/// The status that `curl` prints for `GET /services` with these arguments; `None` if it is not installed.
fn curl(services: &str, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("curl");
    command.args(["-sS", "-o", "/dev/null", "-w", "%{http_code}"]);
    let output = command.args(arguments).arg(services).output().ok()?;
    Some(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn the_token_and_the_hosts_of_the_composite_are_those_of_its_gateway() {
    let keys = "token = \"${TOKEN}\"\nallowed_hosts = \"rover1.local\"\n[components";
    let (_folder, path) = composite(&MAPS.replacen("[components", keys, 1));
    let mut running = Running::start(run(&path, &[]).env("TOKEN", "s3cret"));
    let services = running.listening();
    let token = ["-H", "Authorization: Bearer s3cret"];
    let Some(accepted) = curl(&services, &token) else {
        return;
    };
    assert_eq!(accepted, "200");
    assert_eq!(curl(&services, &[]).unwrap(), "401");
    let (_, port) = services
        .trim_end_matches("/services")
        .rsplit_once(':')
        .unwrap();
    for (name, expected) in [("rover1.local", "200"), ("evil.example", "421")] {
        let resolve = format!("{name}:{port}:127.0.0.1");
        let services = format!("http://{name}:{port}/services");
        let arguments = [&token[..], &["--resolve", &resolve]].concat();
        assert_eq!(curl(&services, &arguments).unwrap(), expected, "{name}");
    }
}

#[test]
fn c5_curl_calls_a_promoted_service() {
    let (_folder, path) = composite(MAPS);
    let mut running = Running::start(&mut run(&path, &[]));
    let services = running.listening();
    let (status, map) = post(&format!("{services}/maps/getMap"), r#"{"name": "office"}"#);
    assert_eq!(status, 200, "{map}");
    let cells = map["data"].as_array().unwrap().len();
    assert_eq!(
        map["info"]["width"].as_u64().unwrap() as usize
            * map["info"]["height"].as_u64().unwrap() as usize,
        cells
    );
    // both clients get the same
    let own = said(&format!("{services}/maps/getMap"), r#"{"name": "office"}"#);
    let (own, _) = own.rsplit_once('\n').unwrap();
    assert_eq!(serde_json::from_str::<Value>(own).unwrap(), map);
    for (operation, argument, status, code) in [
        (
            "maps/getMap",
            r#"{"name": "nowhere"}"#,
            422,
            map_fault(&services),
        ),
        (
            "maps/getMap",
            r#"{"place": "office"}"#,
            400,
            json!("BAD_REQUEST"),
        ),
        ("maps/getMap?timeout_ms=0", "{}", 400, json!("BAD_QUERY")),
        ("maps/getMaps", "{}", 404, json!("NO_OPERATION")),
        ("map/getMap", "{}", 404, json!("NO_SERVICE")),
    ] {
        let (found, said) = post(&format!("{services}/{operation}"), argument);
        assert_eq!(
            (found, &said["code"]),
            (status, &code),
            "{operation}: {said}"
        );
    }
    let output = running.interrupt();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.is_empty() || !said.contains("panicked"), "{said}");
}

/// The fault code for an unknown map, which is the operation's own.
fn map_fault(services: &str) -> Value {
    let (_, said) = post(
        &format!("{services}/maps/getMap"),
        r#"{"name": "elsewhere"}"#,
    );
    assert!(
        said["detail"].as_str().unwrap().contains("elsewhere"),
        "{said}"
    );
    said["code"].clone()
}

#[test]
fn a_gateway_is_opened_elsewhere_or_not_at_all_or_says_what_stands_in_the_way() {
    let (_folder, path) = composite(MAPS);
    let ends = |arguments: &[&str]| {
        let output = run(&path, arguments).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    // without it, time is virtual again
    let (code, said) = ends(&["--http", "off", "--for", "60"]);
    assert!(code == Some(0) && said.contains("virtual clock"), "{said}");
    for (arguments, words) in [
        (&["--clock", "virtual"][..], "--http off"),
        (
            &["--speed", "1"],
            "a run over a gateway uses the wall clock",
        ),
        (&["--http", "localhost"], "127.0.0.1:8080"),
        (
            &["--http", "mian=127.0.0.1:0"],
            "unknown gateway `mian`; the gateways are main",
        ),
    ] {
        let (code, said) = ends(arguments);
        assert!(
            code == Some(2) && said.contains(words),
            "{arguments:?}: {said}"
        );
    }
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let (code, said) = ends(&["--http", &address]);
    assert!(
        code == Some(2) && said.contains(&address) && said.contains("--http off"),
        "{said}"
    );
    let output = run(&path, &["--for", "0.2", "--json", "--http", "127.0.0.1:0"]).output();
    let output = output.unwrap();
    let first = String::from_utf8(output.stdout).unwrap();
    let first: Value = serde_json::from_str(first.lines().next().unwrap()).unwrap();
    assert_eq!(
        (&first["type"], &first["name"]),
        (&json!("gateway"), &json!("main"))
    );
    let loopback = ["--for", "0.2", "--http", "127.0.0.1:0"];
    let everywhere = ["--for", "0.2", "--http", "0.0.0.0:0"];
    for (arguments, warns) in [(loopback, false), (everywhere, true)] {
        let (code, said) = ends(&arguments);
        assert_eq!((code, said.contains("C067")), (Some(0), warns), "{said}");
    }
    let (_folder, plain) = composite(&MAPS.replace("binding = \"http\"", ""));
    let output = run(&plain, &["--http", "127.0.0.1:0"]).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("binding = \"http\""), "{said}");
}

#[test]
fn t18_a_component_that_is_stopped_says_so_at_once_and_one_that_is_slow_is_too_late() {
    let slow = MAPS.replace("period_ms = 20", "period_ms = 2000, delay_ms = 1500");
    let (_folder, path) = composite(&slow);
    let mut running = Running::start(&mut run(&path, &[]));
    let services = running.listening();
    let began = std::time::Instant::now();
    let (status, said) = post(&format!("{services}/maps/getMap?timeout_ms=100"), "{}");
    assert!(began.elapsed() < std::time::Duration::from_millis(1400));
    assert_eq!((status, &said["code"]), (504, &json!("TIMEOUT")));
    drop(running);
    let stopped = format!("{MAPS}{PLANNER}");
    let stopped = stopped.replace("period_ms = 20", "period_ms = 20, run_on_startup = false");
    let (_folder, path) = composite(&stopped);
    let mut running = Running::start(&mut run(&path, &[]));
    let services = running.listening();
    let (status, said) = post(&format!("{services}/planning/plan"), "{}");
    assert_eq!((status, &said["code"]), (503, &json!("STOPPED")));
    let detail = json!("the component that serves `planning` does not run");
    assert_eq!(said["detail"], detail);
    // needs no cycle
    let (status, map) = post(&format!("{services}/maps/getMap"), "{}");
    assert_eq!((status, &map["header"]["frame_id"]), (200, &json!("map")));
}

const PLANNER: &str = r#"
[components.Planner]
implementation = { rust = "nav::TrajectoryPlanner" }
task           = { period_ms = 20 }
services       = { planning = "nav/PlanService" }
[[promote]]
service = "Planner.planning"
as      = "planning"
binding = "http"
"#;

const FLAG: &str = r#"
schema = "composite/1"
[composite]
name = "flag"
[gateways.main]
listen = "127.0.0.1:0"
[components.Coordinator]
implementation = { asm = "flag.asm" }
task           = { period_ms = 20 }
subscribe      = { go = "std_msgs/Bool" }
[components.Coordinator.bind.monitored]
go = { topic = "go", none = false }
[[promote]]
topic = "go"
as    = "go"
[components.MapServer]
implementation = { rust = "nav::MapServer" }
task           = { period_ms = 20 }
services       = { maps = "nav/MapService" }
properties     = { source = "${MAPS}" }
[[promote]]
service = "MapServer.maps"
as      = "maps"
binding = "http"
"#;

const FLAG_ASM: &str = "asm flag
import StandardLibrary
signature:
  enum domain Mode = {WAITING | STARTED}
  monitored go: Boolean
  controlled mode: Mode
definitions:
  main rule r_Main = if mode = WAITING and go then mode := STARTED endif
default init s0:
  function mode = WAITING
";

/// The response to a `GET` request.
fn get(url: &str) -> Value {
    let address_and_path = url.strip_prefix("http://").unwrap();
    let (address, path) = address_and_path.split_once('/').unwrap();
    let mut stream = TcpStream::connect(address.parse::<SocketAddr>().unwrap()).unwrap();
    let request = format!("GET /{path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut said = String::new();
    stream.read_to_string(&mut said).unwrap();
    let (_, body) = said.split_once("\r\n\r\n").unwrap();
    serde_json::from_str(body).unwrap()
}

#[test]
fn the_state_of_a_coordinator_is_read_over_http() {
    let (folder, path) = composite(FLAG);
    std::fs::write(folder.path().join("flag.asm"), FLAG_ASM).unwrap();
    let mut running = Running::start(&mut run(&path, &[]));
    let services = running.listening();
    let components = services.replace("/services", "/components");
    let until = std::time::Instant::now() + std::time::Duration::from_secs(20);
    let coordinator = loop {
        let coordinator = get(&format!("{components}/Coordinator"));
        if coordinator["inspection"]["read"]["go"] == "false" {
            break coordinator;
        }
        assert!(std::time::Instant::now() < until, "{coordinator}");
        std::thread::sleep(std::time::Duration::from_millis(100));
    };
    assert_eq!(coordinator["state"], "Running");
    assert_eq!(
        coordinator["inspection"]["state"],
        json!({ "mode": "WAITING" })
    );
    assert_eq!(coordinator["inspection"]["silent"], json!(["go"]));
    let listed = get(&components);
    assert_eq!(
        listed["components"].as_array().unwrap().len(),
        2,
        "{listed}"
    );
}

/// The composite `courier` as two systems: the dispatcher behind a gateway, and the courier, which calls it over HTTP.
fn offices(folder: &Path) -> (PathBuf, PathBuf) {
    let specs = Path::new(env!("CARGO_MANIFEST_DIR")).join("specs/courier");
    for file in ["courier.asm", "dispatcher.asm", "Dispatch.asm"] {
        std::fs::copy(specs.join(file), folder.join(file)).unwrap();
    }
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        let head = format!("schema = \"composite/1\"\n[composite]\nname = \"{name}\"\n");
        std::fs::write(&path, head + text).unwrap();
        path
    };
    let office = write("office", OFFICE);
    let street = write("street", STREET);
    (office, street)
}

const OFFICE: &str = r#"
[gateways.main]
listen = "127.0.0.1:0"
token = "${OFFICE_TOKEN}"
[components.Dispatcher]
implementation = { asm = "dispatcher.asm" }
task = { period_ms = 20 }
services = { dispatch = "courier/Dispatch" }
[[promote]]
service = "Dispatcher.dispatch"
as = "jobs"
binding = "http"
"#;

const STREET: &str = r#"
[components.Courier]
implementation = { asm = "courier.asm" }
task = { period_ms = 20 }
references = { dispatcher = "courier/Dispatch" }
[[wires]]
reference = "Courier.dispatcher"
binding = "http"
url = "${JOBS}"
token = "${TOKEN}"
timeout_ms = 2000
"#;

/// Runs the courier against a service until it has done two jobs.
fn courier(street: &Path, url: &str, token: &str, arguments: &[&str]) -> std::process::Output {
    let limits = ["--until", "jobs=2", "--for", "5", "--json"];
    let mut command = run(street, &[&limits[..], arguments].concat());
    command.env("JOBS", url).env("TOKEN", token);
    command.output().unwrap()
}

#[test]
fn c5_a_reference_calls_a_service_of_another_system_over_http() {
    let folder = tempfile::tempdir().unwrap();
    let (office, street) = offices(folder.path());
    let mut dispatcher = Running::start(run(&office, &[]).env("OFFICE_TOKEN", "s3cret"));
    let url = format!("{}/jobs", dispatcher.listening());
    let output = courier(&street, &url, "s3cret", &["--clock", "wall"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(!String::from_utf8_lossy(&output.stdout).contains("s3cret"));
    let output = courier(&street, &url, "guess", &["--clock", "wall"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("NO_TOKEN"));
    // virtual time would pass while the other system replies
    let output = courier(&street, &url, "s3cret", &["--clock", "virtual"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("--clock wall"));
    // the other system is gone: its calls end, and the run goes on
    drop(dispatcher.interrupt());
    let output = courier(&street, &url, "s3cret", &["--clock", "wall"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
}

/// A server made of Python's standard library.
const PYTHON: &str = r#"
import http.server, json
class Jobs(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        argument = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        is_job = self.path.split("?")[0] == "/jobs/job"
        reply = json.dumps(argument + 3).encode() if is_job else b""
        self.send_response(200)
        self.send_header("Content-Type", "application/json; charset=utf-8")
        self.end_headers()
        self.wfile.write(reply)
server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Jobs)
print(server.server_port, flush=True)
server.serve_forever()
"#;

/// A server in Python, which ends with this value.
struct PythonServer {
    process: std::process::Child,
    port: u16,
}

impl PythonServer {
    /// Starts a server that prints its port; `None`, with a notice, without Python.
    fn start(text: &str, folder: &Path) -> Option<Self> {
        let mut command = Command::new("python3");
        command.args(["-c", text]).current_dir(folder);
        command.stdout(Stdio::piped()).stderr(Stdio::null());
        let Ok(mut process) = command.spawn() else {
            asmotion_skip::PYTHON.skip();
            return None;
        };
        let mut port = String::new();
        std::io::BufReader::new(process.stdout.as_mut().unwrap())
            .read_line(&mut port)
            .unwrap();
        let port = port.trim().parse().unwrap();
        Some(Self { process, port })
    }
}

impl Drop for PythonServer {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The courier's run against a server with this text; `None`, with a notice, without Python.
fn courier_of(street: &Path, server: &str) -> Option<std::process::Output> {
    let server = PythonServer::start(server, street.parent().unwrap())?;
    let url = format!("http://127.0.0.1:{}/jobs", server.port);
    Some(courier(street, &url, "none", &["--clock", "wall"]))
}

#[test]
fn c5_a_reference_calls_a_service_written_in_python() {
    let folder = tempfile::tempdir().unwrap();
    let (_, street) = offices(folder.path());
    if let Some(output) = courier_of(&street, PYTHON) {
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }
}

#[test]
fn c5_a_server_that_answers_wrongly_fails_the_call_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (_, street) = offices(folder.path());
    let answer = "json.dumps(argument + 3).encode()";
    for (wrong, error) in [
        (r#"b"""#, "null"),
        (r#"b'"seven"'"#, "null"),
        (r#"b'{"a":'"#, "BAD_REPLY"),
        (r#"b"<html>""#, "BAD_REPLY"),
        ("self.send_error(500)", "HTTP_500"),
        ("__import__('time').sleep(9)", "cancelled"),
    ] {
        let Some(output) = courier_of(&street, &PYTHON.replace(answer, wrong)) else {
            return;
        };
        // the courier asks again until its time is up
        assert_eq!(output.status.code(), Some(1), "{wrong}: {output:?}");
        let text = String::from_utf8(output.stdout).unwrap();
        let lines = text
            .lines()
            .map(|it| serde_json::from_str::<Value>(it).unwrap());
        let lines: Vec<_> = lines.collect();
        let mut replies = lines.iter().filter(|line| line["type"] == "reply");
        let reply = replies
            .next_back()
            .unwrap_or_else(|| panic!("{wrong}: {text}"));
        assert!(
            reply["error"].to_string().contains(error),
            "{wrong}: {reply}"
        );
        if error == "null" {
            // the reply does not fit the operation
            let last = lines.iter().rfind(|line| line["type"] == "losses").unwrap();
            assert!(last["misfits"].as_u64() > Some(1), "{wrong}: {last}");
            let mut bad = lines.iter().filter(|line| line["type"] == "bad_reply");
            let bad = bad.next().unwrap_or_else(|| panic!("{wrong}: {text}"));
            let found = if wrong == r#"b"""# {
                "null"
            } else {
                "\"seven\""
            };
            let expected = serde_json::json!({ "fault": {
                "code": "BAD_REPLY", "detail": format!("expected Integer, found {found}"),
            }});
            assert_eq!(bad["error"], expected, "{bad}");
            let place = [&bad["component"], &bad["reference"], &bad["operation"]];
            assert_eq!(place, ["Courier", "dispatcher", "job"]);
            let replied = lines.iter().find(|line| line["type"] == "reply").unwrap();
            assert_eq!(bad["call"], replied["call"], "{replied}");
            let summary = lines
                .iter()
                .rfind(|line| line["type"] == "summary")
                .unwrap();
            assert!(summary["failed_calls"].as_u64() > Some(1), "{summary}");
        }
    }
}

/// Asks for a map, and notes how the call ends.
const SURVEYOR: &str = "asm surveyor
import StandardLibrary
signature:
    enum domain Action = {NOACT | ASK}
    enum domain Ev = {NOEV | GOT | FAILED}
    enum domain Mode = {BEGINS | ASKS | DONE | BROKEN}
    monitored ev: Ev
    controlled mode: Mode
    controlled hasEnded: Boolean
    out command: Action
definitions:
    main rule r_Main =
        par
            if mode = BEGINS then par command := ASK mode := ASKS endpar endif
            if ev != NOEV then hasEnded := true endif
            if ev = GOT then mode := DONE endif
            if ev = FAILED then mode := BROKEN endif
        endpar
default init s0:
    function mode = BEGINS
    function hasEnded = false
    function command = NOACT
";

const SURVEYED: &str = r#"
schema = "composite/1"
[composite]
name = "survey"
[components.Surveyor]
implementation = { asm = "surveyor.asm" }
task = { period_ms = 20 }
references = { maps = "nav/MapService" }
bind.out.command.ASK = { call = "maps.getMap", with = { name = "office" }, ok = "GOT", failed = "FAILED", event = "ev" }
bind.monitored.ev = { value = "NOEV" }
[[wires]]
reference = "Surveyor.maps"
binding = "http"
url = "${MAPS_URL}"
timeout_ms = 15000
"#;

/// The type of an operation is that of its interface, whoever provides it.
#[test]
fn c5_a_reply_of_another_type_than_that_of_its_operation_is_a_failed_call() {
    let (folder, path) = composite(SURVEYED);
    std::fs::write(folder.path().join("surveyor.asm"), SURVEYOR).unwrap();
    let trace = folder.path().join("survey.trace");
    let is_job = "self.path.split(\"?\")[0] == \"/jobs/job\"";
    let server = PYTHON.replace(is_job, "True");
    for (reply, state, detail) in [
        ("b'{\"info\": {\"width\": 2}}'", "DONE", ""),
        ("b'\"seven\"'", "BROKEN", "found a string"),
        ("b'[1, 2]'", "BROKEN", "expected"),
        ("b'{\"info\": {\"width\": \"two\"}}'", "BROKEN", "width"),
        ("b'{\"inf\": 1}'", "BROKEN", "inf"),
        (
            "b'{\"info\": {\"width\": 2}, \"info\": {}}'",
            "BROKEN",
            "the field `info` occurs twice",
        ),
    ] {
        let server = server.replace("json.dumps(argument + 3).encode()", reply);
        let Some(server) = PythonServer::start(&server, folder.path()) else {
            return;
        };
        let url = format!("http://127.0.0.1:{}/maps", server.port);
        let mut command = run(&path, &["--until", "hasEnded=true", "--for", "20"]);
        command
            .args(["--json", "--clock", "wall", "--trace"])
            .arg(&trace);
        let output = command.env("MAPS_URL", &url).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(
            text.contains(&format!("\"control_state\":\"{state}\"")),
            "{reply}: {output:?}"
        );
        let error = last_error(&output);
        let written = std::fs::read_to_string(&trace).unwrap();
        let replied = written
            .lines()
            .find(|it| it.contains("reply Surveyor.maps.getMap"));
        let replied = replied.unwrap_or_else(|| panic!("{reply}: {written}"));
        if state == "DONE" {
            assert_eq!(error, Value::Null);
            continue;
        }
        assert_eq!(error["fault"]["code"], "BAD_REPLY", "{reply}: {error}");
        assert!(error.to_string().contains(detail), "{reply}: {error}");
        assert!(replied.contains("BAD_REPLY"), "{reply}: {replied}");
    }
}

/// The specification learns at once that a server has given up, or that there is none, and the run says why.
#[test]
fn c5_a_server_that_times_out_or_is_not_there_ends_the_call_at_once() {
    let (folder, path) = composite(SURVEYED);
    std::fs::write(folder.path().join("surveyor.asm"), SURVEYOR).unwrap();
    let survey = |url: &str, arguments: &[&str]| {
        let limits = ["--until", "hasEnded=true", "--for", "10", "--clock", "wall"];
        let mut command = run(&path, &[&limits[..], arguments].concat());
        let output = command.env("MAPS_URL", url).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        output
    };
    let output = survey("http://127.0.0.1:1/maps", &[]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let reason =
        "`maps` at http://127.0.0.1:1/maps is unavailable: cannot connect: Connection refused";
    assert!(text.contains(reason), "{output:?}");
    let reply = "reply = json.dumps(argument + 3).encode() if is_job else b\"\"";
    let server = PYTHON.replace(reply, "return self.send_error(504)");
    let Some(server) = PythonServer::start(&server, folder.path()) else {
        return;
    };
    let url = format!("http://127.0.0.1:{}/maps", server.port);
    // the wire allows 15 s
    let output = survey(&url, &["--json"]);
    assert_eq!(last_error(&output), "timeout");
}

/// The error of the last reply that a run has reported.
fn last_error(output: &std::process::Output) -> Value {
    let text = String::from_utf8_lossy(&output.stdout);
    let mut lines = text
        .lines()
        .map(|it| serde_json::from_str::<Value>(it).unwrap());
    let reply = lines.rfind(|it| it["type"] == "reply");
    reply.unwrap_or_else(|| panic!("{output:?}"))["error"].clone()
}

#[test]
fn c5_a_wire_trusts_the_authority_that_it_names() {
    let folder = tempfile::tempdir().unwrap();
    let (_, street) = offices(folder.path());
    for name in ["plant", "other"] {
        let certificates = folder.path().join(name);
        std::fs::create_dir(&certificates).unwrap();
        asmotion_broker::write_certificates(&certificates).unwrap();
    }
    let encrypted = "context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
context.load_cert_chain('server.pem', 'server.key')
server.socket = context.wrap_socket(server.socket, server_side=True)
print(server";
    let server = PYTHON.replace("http.server, json", "http.server, json, ssl");
    let server = server.replace("print(server", encrypted);
    // an encrypted response that ends with its connection may have been cut
    let length = "self.send_header('Content-Length', str(len(reply)))\n        self.end_headers";
    let server = server.replace("self.end_headers", length);
    let Some(server) = PythonServer::start(&server, &folder.path().join("plant")) else {
        return;
    };
    let url = format!("https://localhost:{}/jobs", server.port);
    let composite = std::fs::read_to_string(&street).unwrap();
    let run_with = |ca: &str, variable: Option<&str>| {
        let key = match ca {
            "" => String::new(),
            ca => format!("ca = \"{ca}\"\ntimeout_ms"),
        };
        let text = match ca {
            "" => composite.clone(),
            _ => composite.replace("timeout_ms", &key),
        };
        std::fs::write(&street, text).unwrap();
        let limits = [
            "--until", "jobs=2", "--for", "4", "--json", "--clock", "wall",
        ];
        let mut command = run(&street, &limits);
        command.env("JOBS", &url).env("TOKEN", "none");
        if let Some(variable) = variable {
            command.env("SSL_CERT_FILE", folder.path().join(variable));
        }
        command.output().unwrap()
    };
    for (ca, variable) in [
        ("plant/authority.pem", None),
        ("", Some("plant/authority.pem")),
        ("plant/authority.pem", Some("other/authority.pem")),
    ] {
        let output = run_with(ca, variable);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{ca} {variable:?}: {output:?}"
        );
    }
    for (ca, variable) in [
        ("other/authority.pem", None),
        ("", None),
        ("other/authority.pem", Some("plant/authority.pem")),
    ] {
        let output = run_with(ca, variable);
        assert_eq!(
            output.status.code(),
            Some(1),
            "{ca} {variable:?}: {output:?}"
        );
        let fault = &last_error(&output)["fault"];
        assert_eq!(fault["code"], "NO_TLS", "{ca} {variable:?}: {fault}");
        let detail = fault["detail"].as_str().unwrap();
        assert!(detail.contains("invalid peer certificate"), "{detail}");
    }
    // the certificate of an authority is none of a server
    let alone = PYTHON.replace("http.server, json", "http.server, json, ssl");
    let encrypted = encrypted.replace("server.pem', 'server.key", "alone.pem', 'alone.key");
    let alone = alone.replace("print(server", &encrypted);
    let alone = PythonServer::start(&alone, &folder.path().join("plant")).unwrap();
    let text = composite.replace("timeout_ms", "ca = \"plant/alone.pem\"\ntimeout_ms");
    std::fs::write(&street, text).unwrap();
    let url_of_alone = format!("https://localhost:{}/jobs", alone.port);
    let output = courier(&street, &url_of_alone, "none", &["--clock", "wall"]);
    let fault = &last_error(&output)["fault"];
    assert_eq!(fault["code"], "NO_TLS", "{fault}");
    let detail = fault["detail"].as_str().unwrap();
    assert!(
        detail.contains("basicConstraints=critical,CA:FALSE"),
        "{detail}"
    );
    // what looks like a certificate and is none
    let pem = "-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n";
    std::fs::write(folder.path().join("none.pem"), pem).unwrap();
    let output = run_with("none.pem", None);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        said.contains("wire of `Courier.dispatcher`") && said.contains("none.pem`: no certificate"),
        "{said}"
    );
    // an expanded composite finds the file from its own place
    run_with("plant/authority.pem", None);
    let mut expand = Command::new(env!("CARGO_BIN_EXE_asmotion"));
    expand.arg("expand").arg(&street).env("JOBS", &url);
    let output = expand.env("TOKEN", "none").output().unwrap();
    let expanded = String::from_utf8(output.stdout).unwrap();
    assert!(
        expanded.contains("ca = \"plant/authority.pem\""),
        "{expanded}"
    );
}

/// The courier with a dispatcher in its own process, which is stopped, and one behind a gateway.
const ALTERNATIVES: &str = r#"
[components.Courier]
implementation = { asm = "courier.asm" }
task = { period_ms = 20 }
references = { dispatcher = "courier/Dispatch" }
[components.Dispatcher]
implementation = { asm = "dispatcher.asm" }
task = { period_ms = 20, run_on_startup = ${START} }
services = { dispatch = "courier/Dispatch" }
[[wires]]
reference = "Courier.dispatcher"
service = "Dispatcher.dispatch"
timeout_ms = 500
[[wires]]
reference = "Courier.dispatcher"
binding = "http"
url = "${JOBS}"
token = "${TOKEN}"
timeout_ms = 500
"#;

#[test]
fn c4_a_reference_with_several_bindings_calls_the_first_service_that_is_available() {
    let folder = tempfile::tempdir().unwrap();
    let (office, street) = offices(folder.path());
    let mut dispatcher = Running::start(run(&office, &[]).env("OFFICE_TOKEN", "s3cret"));
    let url = format!("{}/jobs", dispatcher.listening());
    let head = "schema = \"composite/1\"\n[composite]\nname = \"street\"\n";
    // the wrong token is a fault of the second service
    for (runs, token, status) in [
        ("true", "guess", 0),
        ("false", "s3cret", 0),
        ("false", "guess", 1),
    ] {
        let text = ALTERNATIVES.replace("${START}", runs);
        std::fs::write(&street, format!("{head}{text}")).unwrap();
        let output = courier(&street, &url, token, &["--clock", "wall"]);
        assert_eq!(output.status.code(), Some(status), "{runs} {output:?}");

        // a call counts once, although it is made at both services
        let (summary, attempts) = summary_and_calls(&output);
        let calls: BTreeSet<_> = attempts.iter().collect();
        let is_repeated = attempts.len() > calls.len();
        assert_eq!(is_repeated, runs == "false", "{runs}: {output:?}");
        let counted = summary["calls"].as_array().unwrap().iter();
        let counted: u64 = counted.map(|it| it["count"].as_u64().unwrap()).sum();
        let possible = 1..=u64::try_from(calls.len()).unwrap();
        assert!(possible.contains(&counted), "{runs}: {summary} {calls:?}");
    }
    drop(dispatcher.interrupt());
}

/// The summary of a run, and the numbers of the calls until its end, once for each service that is tried.
fn summary_and_calls(output: &std::process::Output) -> (Value, Vec<u64>) {
    let text = String::from_utf8_lossy(&output.stdout);
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    let lines: Vec<Value> = lines.collect();
    let summary = lines.last().unwrap().clone();
    let end = summary["time_s"].as_f64().unwrap();
    let calls = lines.iter().filter(|line| line["type"] == "call");
    let calls = calls.filter(|line| line["t"].as_f64().unwrap() <= end);
    let calls = calls.map(|line| line["call"].as_u64().unwrap()).collect();
    (summary, calls)
}
