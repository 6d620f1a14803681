//! A client of Chromium's DevTools protocol, as far as the tests need it.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asmotion_skip::Requirement;
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Chromium, with which the dashboard is tested.
const CHROMIUM: Requirement<'_> = Requirement {
    name: "chromium",
    tests: "the tests of the dashboard in a browser",
    remedy: "Install Debian's package `chromium`, or run `./test`",
};

/// Limit on the time in which something appears on a page.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser without a window. Dropping this ends it.
pub struct Browser {
    process: Child,
    port: u16,
    _profile: TempDir,
}

/// A tab.
pub struct Tab {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    next: u64,
    /// Errors of scripts, of the console, and of loading.
    pub errors: Vec<String>,
    /// Addresses of all requests.
    pub requests: Vec<String>,
    /// Events of the trace under way.
    traced: Vec<Value>,
    /// Whether all events of the last trace have arrived.
    is_traced: bool,
}

impl Browser {
    /// Starts a browser; `None`, with a notice, if it is not installed.
    pub fn start() -> Option<Self> {
        let profile = tempfile::tempdir().unwrap();
        let mut command = Command::new("chromium");
        command.args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--hide-scrollbars",
            "--remote-debugging-port=0",
        ]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        let silent = command.arg("about:blank").stdin(Stdio::null());
        let Ok(process) = silent.stdout(Stdio::null()).stderr(Stdio::null()).spawn() else {
            CHROMIUM.skip();
            return None;
        };
        let port = devtools_port(profile.path());
        Some(Self {
            process,
            port,
            _profile: profile,
        })
    }

    /// Opens a page in a new tab of this size.
    pub fn open(&self, url: &str, (width, height): (u32, u32), theme: &str) -> Tab {
        let tab = self.request("PUT", "/json/new?about:blank");
        let address = tab["webSocketDebuggerUrl"].as_str().unwrap();
        let (socket, _) = tungstenite::connect(address).unwrap();
        let mut tab = Tab {
            socket,
            next: 1,
            errors: Vec::new(),
            requests: Vec::new(),
            traced: Vec::new(),
            is_traced: false,
        };
        for domain in ["Page", "Runtime", "Log", "Network"] {
            tab.call(&format!("{domain}.enable"), json!({}));
        }
        tab.call(
            "Emulation.setDeviceMetricsOverride",
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false }),
        );
        tab.call(
            "Emulation.setEmulatedMedia",
            json!({ "features": [{ "name": "prefers-color-scheme", "value": theme }] }),
        );
        tab.call("Page.navigate", json!({ "url": url }));
        tab
    }

    fn request(&self, method: &str, path: &str) -> Value {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nConnection: close\r\n\r\n",
            self.port
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut text = Vec::new();
        let mut part = [0; 4096];
        // the server closes the connection when it likes, so the body is read until it is complete
        loop {
            let count = stream.read(&mut part).unwrap();
            text.extend_from_slice(&part[..count]);
            let said = String::from_utf8_lossy(&text);
            let body = said.split_once("\r\n\r\n").map_or("", |(_, body)| body);
            if let Ok(value) = serde_json::from_str(body) {
                return value;
            }
            assert!(count > 0, "{said}");
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The port that the browser has chosen, which it writes into its profile.
fn devtools_port(profile: &Path) -> u16 {
    let file = profile.join("DevToolsActivePort");
    let begun = Instant::now();
    loop {
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        if let Some(port) = text.lines().next().and_then(|line| line.parse().ok()) {
            return port;
        }
        assert!(begun.elapsed() < PATIENCE, "chromium does not start");
        std::thread::sleep(Duration::from_millis(50));
    }
}

impl Tab {
    /// Calls a method of the protocol.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        let id = self.next;
        self.next += 1;
        let call = json!({ "id": id, "method": method, "params": params });
        self.socket.send(Message::text(call.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else {
                continue;
            };
            let message: Value = serde_json::from_str(&text).unwrap();
            if message["id"] == id {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].clone();
            }
            self.event(&message);
        }
    }

    fn event(&mut self, message: &Value) {
        let params = &message["params"];
        match message["method"].as_str().unwrap_or_default() {
            "Runtime.exceptionThrown" => self.errors.push(params["exceptionDetails"].to_string()),
            "Runtime.consoleAPICalled" if params["type"] == "error" => {
                self.errors.push(params["args"].to_string())
            }
            "Log.entryAdded" if params["entry"]["level"] == "error" => {
                self.errors.push(params["entry"].to_string())
            }
            "Tracing.dataCollected" => self
                .traced
                .extend(params["value"].as_array().into_iter().flatten().cloned()),
            "Tracing.tracingComplete" => self.is_traced = true,
            "Network.requestWillBeSent" => self
                .requests
                .push(params["request"]["url"].as_str().unwrap().to_owned()),
            "Network.webSocketCreated" => self
                .requests
                .push(params["url"].as_str().unwrap().to_owned()),
            _ => {}
        }
    }

    /// The share of its main thread that the page uses over a while, in processor time.
    pub fn main_thread_share(&mut self, span: Duration) -> f64 {
        self.call("Page.bringToFront", json!({}));
        self.traced.clear();
        self.is_traced = false;
        let categories = ["devtools.timeline", "disabled-by-default-devtools.timeline"];
        let config = json!({ "includedCategories": categories });
        let params = json!({ "transferMode": "ReportEvents", "traceConfig": config });
        self.call("Tracing.start", params);
        std::thread::sleep(span);
        self.call("Tracing.end", json!({}));
        while !self.is_traced {
            self.eval("1");
        }
        let thread = |event: &Value| (event["pid"].clone(), event["tid"].clone());
        let mut events = self.traced.iter();
        // only the main thread of the page draws frames
        let frame = events
            .find(|it| it["name"] == "FireAnimationFrame")
            .unwrap();
        let main = thread(frame);
        let tasks = self.traced.iter();
        let tasks = tasks.filter(|it| it["name"] == "RunTask" && thread(it) == main);
        let used_us: f64 = tasks.filter_map(|it| it["tdur"].as_f64()).sum();
        used_us / 1e6 / span.as_secs_f64()
    }

    /// Evaluates an expression on the page.
    pub fn eval(&mut self, expression: &str) -> Value {
        let params =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let result = self.call("Runtime.evaluate", params);
        assert!(
            result["exceptionDetails"].is_null(),
            "{expression}: {}",
            result["exceptionDetails"]
        );
        result["result"]["value"].clone()
    }

    /// Waits until an expression has a value that is neither false, null, 0 nor an empty text, and returns it.
    #[track_caller]
    pub fn wait(&mut self, expression: &str) -> Value {
        // a tab that is hidden draws nothing
        self.call("Page.bringToFront", json!({}));
        let begun = Instant::now();
        loop {
            let value = self.eval(&format!(
                "(() => {{ try {{ return {expression}; }} catch (error) {{ return null; }} }})()"
            ));
            let is_empty = value.is_null() || value == false || value == 0 || value == "";
            if !is_empty {
                return value;
            }
            if begun.elapsed() > PATIENCE {
                self.screenshot("failed");
                panic!(
                    "{expression} does not come; see target/dashboard/failed.png; errors: {:?}",
                    self.errors
                );
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Clicks the first element that the expression returns. A click that another element got, because the page moved in between, is
    /// repeated.
    pub fn click(&mut self, element: &str) {
        let begun = Instant::now();
        loop {
            let place = self.wait(&format!(
                "(() => {{ const it = {element}; if (!it || it.disabled || it.hidden) return null; it.scrollIntoView({{ block: 'center' }}); \
                 window.isClicked = false; it.addEventListener('click', () => window.isClicked = true, {{ once: true, capture: true }}); \
                 const box = it.getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; }})()"
            ));
            let (x, y) = (place[0].as_f64().unwrap(), place[1].as_f64().unwrap());
            self.mouse("mousePressed", x, y);
            self.mouse("mouseReleased", x, y);
            // a click that leads to another page leaves nothing to ask
            if self.eval("window.isClicked") != false {
                return;
            }
            assert!(begun.elapsed() < PATIENCE, "{element} gets no click");
        }
    }

    /// Sends an event of the left button.
    pub fn mouse(&mut self, kind: &str, x: f64, y: f64) {
        let params = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let text = if kind == "keyDown" { text } else { "" };
            self.call(
                "Input.dispatchKeyEvent",
                json!({ "type": kind, "key": key, "text": text }),
            );
        }
    }

    /// Saves what is shown as `target/dashboard/NAME.png`.
    pub fn screenshot(&mut self, name: &str) {
        self.call("Page.bringToFront", json!({}));
        let image = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes = data_encoding::BASE64
            .decode(image["data"].as_str().unwrap().as_bytes())
            .unwrap();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/dashboard");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(format!("{name}.png")), bytes).unwrap();
    }
}
